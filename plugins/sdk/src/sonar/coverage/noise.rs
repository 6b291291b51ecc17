use serde::{Deserialize, Serialize};

use super::stack::{PingStack, Side};

/// What a sidescan hears when it does not transmit: the mean square of each bin.
///
/// A sonar amplifies what comes late more than what comes early, by a law of its own, so nothing in a usual ping tells
/// noise from a faint seabed. A plugin with the grant `sonar` can set the transmission power to 0 for some pings and
/// keep what it hears; or it can leave that out, and then only bins without any amplitude count as silent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloor {
    port: Option<Side>,
    starboard: Option<Side>,
}

impl NoiseFloor {
    /// The noise in a stack of pings without transmission. `None` if the stack is empty.
    #[must_use]
    pub fn of(stack: &PingStack) -> Option<Self> {
        let (port, starboard) = stack.mean_sides();
        (port.is_some() || starboard.is_some()).then_some(Self { port, starboard })
    }

    /// The noise in each bin of a side; `None` if it is not known for bins at the same ranges.
    pub(super) fn bins(&self, is_port: bool, like: &Side) -> Option<&[f32]> {
        let side = if is_port {
            self.port.as_ref()
        } else {
            self.starboard.as_ref()
        }?;
        side.is_like(like).then_some(&side.power)
    }
}
