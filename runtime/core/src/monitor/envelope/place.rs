//! Judges where the vehicle is, not where it may go. Recovery uses this.

use backseat_fence::{Shape, Span, Sweep, VerticalExtent};
use backseat_units::{EastNorth, Utc};

use super::Envelope;
use crate::plugin::{NavigationSample, Refusal};

/// Stands for an unknown altitude, which recovery does not treat as too low. A lease that depends on the altitude ends
/// without it.
const UNKNOWN_ALTITUDE_M: f64 = 1e6;
/// A place is first judged with this much room above and below the vehicle, metres, and without it if that fails.
const ROOM_M: f64 = 2.0;

/// A place inside the fence. Every place that is nearer to it than `clearance_m`, and within these depths and not below
/// this altitude, is inside too.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Good {
    pub(crate) at: EastNorth,
    pub(crate) clearance_m: f64,
    pub(crate) depth_min_m: f64,
    pub(crate) depth_max_m: f64,
    /// Metres above the seabed. An unknown altitude counts as high enough.
    pub(crate) altitude_min_m: f64,
}

impl Good {
    pub(crate) fn covers(&self, navigation: &NavigationSample) -> bool {
        let depth_m = navigation.depth.as_m().max(0.0);
        let altitude_m = navigation.altitude.map_or(f64::MAX, |altitude| altitude.as_m());
        // NaN fails these comparisons.
        navigation.local.distance_m(self.at) < self.clearance_m
            && depth_m >= self.depth_min_m
            && depth_m <= self.depth_max_m
            && altitude_m >= self.altitude_min_m
    }
}

impl Envelope {
    /// Judges where the vehicle is at this moment, widened by the error of navigation. Returns the surroundings for
    /// which the judgement holds as well; `None` if the fence changes with time.
    pub(crate) fn judge_place(&self, navigation: &NavigationSample, utc: Utc) -> Result<Option<Good>, Refusal> {
        let roomy = extent(navigation, ROOM_M);
        let (extent, clearance_m) = match self.place(navigation, 0.0, &roomy, utc) {
            Ok(clearance_m) => (roomy, clearance_m),
            Err(_) => {
                let exact = extent(navigation, 0.0);
                (exact, self.place(navigation, 0.0, &exact, utc)?)
            }
        };
        let good = Good {
            at: navigation.local,
            clearance_m,
            depth_min_m: extent.depth_min_m,
            depth_max_m: extent.depth_max_m,
            altitude_min_m: extent.altitude_min_m,
        };
        Ok((!self.timed).then_some(good))
    }

    /// Whether the vehicle is inside the fence with at least `room_m` metres to spare in the plane.
    pub(crate) fn is_well_inside(&self, navigation: &NavigationSample, room_m: f64, utc: Utc) -> bool {
        self.place(navigation, room_m, &extent(navigation, 0.0), utc).is_ok()
    }

    fn place(
        &self,
        navigation: &NavigationSample,
        room_m: f64,
        extent: &VerticalExtent,
        utc: Utc,
    ) -> Result<f64, Refusal> {
        let sweep = Sweep::new(Shape::point(navigation.local), self.limits.navigation_error_m + room_m);
        let fence = self.fence.during(Span { from: utc, until: utc });
        match fence.check(&sweep, extent) {
            Ok(clearance) => Ok(clearance.metres),
            // Where the vehicle may surface, it may be at any depth above the deepest one that is allowed.
            Err(breach) => match fence.check_surfacing(&sweep, extent) {
                Ok(clearance) => Ok(clearance.metres),
                Err(_) => Err(breach.into()),
            },
        }
    }
}

fn extent(navigation: &NavigationSample, room_m: f64) -> VerticalExtent {
    // The surface moves, and a vehicle on it may report a depth below 0.
    let depth_m = navigation.depth.as_m().max(0.0);
    let altitude_m = navigation
        .altitude
        .map_or(UNKNOWN_ALTITUDE_M, |altitude| altitude.as_m());
    VerticalExtent {
        depth_min_m: (depth_m - room_m).max(0.0),
        depth_max_m: depth_m + room_m,
        altitude_min_m: altitude_m - room_m,
    }
}
