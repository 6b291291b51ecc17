use backseat_sdk::Relative;

use crate::Config;

/// A place beside the hull, as BFRNV counts it, but with a depth in place of the vertical position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Along the hull, metres.
    pub horizontal_m: f64,
    /// Below the surface, metres.
    pub depth_m: f64,
    /// From the hull, metres.
    pub distance_m: f64,
}

impl Place {
    /// How far the vehicle is from it, metres.
    #[must_use]
    pub fn distance_from(&self, relative: &Relative) -> f64 {
        let along_m = relative.horizontal - self.horizontal_m;
        let across_m = relative.depth - self.depth_m;
        let away_m = relative.distance - self.distance_m;
        along_m.hypot(across_m).hypot(away_m)
    }
}

/// The places in the order of inspection: row by row from the shallowest, to and fro along the hull.
#[must_use]
pub fn places(config: &Config) -> Vec<Place> {
    let between = |[first, last]: [f64; 2], at: u32, count: u32| {
        let share = f64::from(at) / f64::from(count.max(2) - 1);
        first + (last - first) * share
    };
    let mut places = Vec::new();
    for row in 0..config.rows {
        for step in 0..config.columns {
            let column = if row % 2 == 0 { step } else { config.columns - 1 - step };
            places.push(Place {
                horizontal_m: between(config.horizontal_m, column, config.columns),
                depth_m: between(config.depth_m, row, config.rows),
                distance_m: config.distance_m,
            });
        }
    }
    places
}
