//! Where the vehicle itself is, not where it may come to: for recovery.

use backseat_fence::{Shape, Span, Sweep, VerticalExtent};
use backseat_units::{EastNorth, Utc};

use super::Envelope;
use crate::plugin::{NavigationSample, Refusal};

/// A vehicle whose height is not known is as high as it likes: what needs it does not stand without it.
const UNKNOWN_ALTITUDE_M: f64 = 1e6;
/// The room that depth and altitude are judged with where they have it, metres.
const ROOM_M: f64 = 2.0;

/// A place inside the fence: no other within so many metres of it, and within these depths, is outside.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Good {
    pub(crate) at: EastNorth,
    pub(crate) clearance_m: f64,
    pub(crate) depth_min_m: f64,
    pub(crate) depth_max_m: f64,
    /// Metres above the seabed; an unknown one is as good as any.
    pub(crate) altitude_min_m: f64,
}

impl Good {
    pub(crate) fn covers(&self, navigation: &NavigationSample) -> bool {
        let depth_m = navigation.depth.as_m().max(0.0);
        let altitude_m = navigation.altitude.map_or(f64::MAX, |altitude| altitude.as_m());
        // Written so that a figure that is none fails.
        navigation.local.distance_m(self.at) < self.clearance_m
            && depth_m >= self.depth_min_m
            && depth_m <= self.depth_max_m
            && altitude_m >= self.altitude_min_m
    }
}

impl Envelope {
    /// Whether the vehicle's place, navigation's error around it, holds at this moment. What it then answers for is kept,
    /// `None` where the fence changes with time.
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

    /// Whether it holds with so many metres to spare in the plane.
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
            // Where it may surface it may be at any depth above the deepest.
            Err(breach) => match fence.check_surfacing(&sweep, extent) {
                Ok(clearance) => Ok(clearance.metres),
                Err(_) => Err(breach.into()),
            },
        }
    }
}

fn extent(navigation: &NavigationSample, room_m: f64) -> VerticalExtent {
    // The surface moves, and a vehicle on it may read less than nothing.
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
