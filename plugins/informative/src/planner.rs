use backseat_sdk::survey::{FieldMap, GaussianProcess, Kernel, Line, Rectangle};
use backseat_sdk::units::EastNorth;
use serde::{Deserialize, Serialize};

/// The directions of the first line of a plan.
const DIRECTIONS: u32 = 12;
/// By how much the second line of a plan turns from the first one, degrees.
const TURNS_DEG: [f64; 3] = [0.0, -75.0, 75.0];
/// How far apart the places of a line are that a plan counts as measured, as a part of the field's scale.
const APART: f64 = 0.4;
/// How far apart the places are at which the uncertainty counts, as a part of the field's scale.
const GRID: f64 = 0.8;
/// The most of these places.
const PLACES_MAX: usize = 150;

/// What is surveyed, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The area.
    pub area: Rectangle,
    /// How the field varies.
    pub kernel: Kernel,
    /// How much more the uncertainty counts where the field is one deviation above its mean.
    pub favour: f64,
    /// The length of a line, metres.
    pub line_m: f64,
}

impl Settings {
    /// An empty Gaussian process for the field.
    ///
    /// # Errors
    /// One line, if the kernel cannot be used.
    pub fn process(&self) -> Result<GaussianProcess, String> {
        GaussianProcess::new(self.kernel, 120, APART * self.kernel.length_m)
    }

    /// The places at which the uncertainty counts: a grid over the area.
    #[must_use]
    pub fn places(&self) -> Vec<EastNorth> {
        let (length_m, width_m) = (self.area.length_m(), self.area.width_m());
        let mut apart_m = GRID * self.kernel.length_m;
        let count = |apart_m: f64| ((length_m / apart_m).ceil(), (width_m / apart_m).ceil());
        while count(apart_m).0 * count(apart_m).1 > PLACES_MAX as f64 {
            apart_m *= 1.1;
        }
        let (rows, columns) = count(apart_m);
        let mut places = Vec::new();
        let mut row = 0.5;
        while row < rows {
            let mut column = 0.5;
            while column < columns {
                places.push(
                    self.area
                        .point((row / rows - 0.5) * length_m, (column / columns - 0.5) * width_m),
                );
                column += 1.0;
            }
            row += 1.0;
        }
        places
    }
}

/// Looks for the next line, some plans at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planner {
    from: EastNorth,
    /// How many plans were looked at.
    tried: u32,
    best: Option<(f64, Line)>,
}

impl Planner {
    /// A search for a line from a place.
    #[must_use]
    pub const fn new(from: EastNorth) -> Self {
        Self {
            from,
            tried: 0,
            best: None,
        }
    }

    /// Looks at the next plan. Returns whether there are more.
    pub fn look(&mut self, settings: &Settings, map: &FieldMap, places: &[EastNorth]) -> bool {
        let plans = DIRECTIONS * TURNS_DEG.len() as u32;
        if let Some((first, second)) = self.plan(settings) {
            let way_m = first.length_m() + second.length_m();
            let mut measured = along(&first, settings);
            measured.extend(along(&second, settings));
            if let Some(after) = map.after_measuring(&measured) {
                let gain: f64 = places.iter().map(|place| gain(settings, map, &after, *place)).sum();
                let worth = gain / way_m;
                if self.best.is_none_or(|(best, _)| worth > best) {
                    self.best = Some((worth, first));
                }
            }
        }
        self.tried += 1;
        self.tried < plans
    }

    /// The first line of the best plan so far.
    #[must_use]
    pub fn best(&self) -> Option<Line> {
        self.best.map(|(_, line)| line)
    }

    /// The next plan; `None` if it leads out of the area.
    fn plan(&self, settings: &Settings) -> Option<(Line, Line)> {
        let turns = TURNS_DEG.len() as u32;
        let bearing_deg = 360.0 * f64::from(self.tried / turns) / f64::from(DIRECTIONS);
        let turn_deg = TURNS_DEG[(self.tried % turns) as usize];
        let first = inside(self.from, bearing_deg, settings)?;
        // A second line that leads out of the area is shorter, or nothing.
        let second = inside(first.end, bearing_deg + turn_deg, settings).unwrap_or(Line {
            start: first.end,
            end: first.end,
        });
        Some((first, second))
    }
}

/// A line from a place, as long as it may be and stay in the area; `None` if that is less than a third of it.
fn inside(from: EastNorth, bearing_deg: f64, settings: &Settings) -> Option<Line> {
    let parts = [1.0, 0.8, 0.6, 0.4].into_iter();
    let lines = parts.map(|part| Line {
        start: from,
        end: from.offset(bearing_deg, part * settings.line_m),
    });
    lines.into_iter().find(|line| settings.area.contains(line.end, 0.0))
}

/// The places of a line that are measured when it is flown.
fn along(line: &Line, settings: &Settings) -> Vec<EastNorth> {
    let count = (line.length_m() / (APART * settings.kernel.length_m)).floor() as u32;
    let way = line.end - line.start;
    let points = (1..=count).map(|index| line.start + way * (f64::from(index) / f64::from(count)));
    points.collect()
}

/// How much variance a plan takes away at a place, and how much that counts there.
fn gain(settings: &Settings, map: &FieldMap, after: &FieldMap, place: EastNorth) -> f64 {
    let before = map.at(place);
    let left = after.at(place).deviation;
    let high = ((before.mean - map.mean()) / settings.kernel.deviation).max(0.0);
    (before.deviation * before.deviation - left * left) * (1.0 + settings.favour * high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(favour: f64) -> Settings {
        Settings {
            area: Rectangle::new(EastNorth::default(), 600.0, 400.0, 90.0),
            kernel: Kernel {
                length_m: 100.0,
                deviation: 1.0,
                noise: 0.05,
            },
            favour,
            line_m: 150.0,
        }
    }

    fn planned(settings: &Settings, process: &GaussianProcess, from: EastNorth) -> Line {
        let (map, places) = (process.fit().unwrap(), settings.places());
        let mut planner = Planner::new(from);
        let mut looks = 1;
        while planner.look(settings, &map, &places) {
            looks += 1;
        }
        assert_eq!(looks, 36);
        planner.best().unwrap()
    }

    #[test]
    fn it_goes_where_least_is_known() {
        let settings = settings(0.0);
        let mut process = settings.process().unwrap();
        // The western half is known.
        for east in [-280.0, -230.0, -180.0, -130.0, -80.0, -30.0, 0.0] {
            for north in [-150.0, -50.0, 50.0, 150.0] {
                process.add(EastNorth::new(east, north), 12.0);
            }
        }
        let line = planned(&settings, &process, EastNorth::new(0.0, 0.0));
        assert!(line.end.east_m > 100.0, "{line:?}");
        assert!(settings.area.contains(line.end, 0.0));
    }

    #[test]
    fn it_goes_where_the_field_is_high_if_that_counts() {
        let go_to = |favour| {
            let settings = settings(favour);
            let mut process = settings.process().unwrap();
            process.add(EastNorth::new(-200.0, 0.0), 14.0);
            process.add(EastNorth::new(0.0, 0.0), 12.0);
            process.add(EastNorth::new(100.0, 0.0), 12.0);
            process.add(EastNorth::new(200.0, 0.0), 10.0);
            planned(&settings, &process, EastNorth::new(-20.0, 0.0)).end.east_m
        };
        assert!(go_to(10.0) < -60.0, "{}", go_to(10.0));
    }

    #[test]
    fn the_places_cover_the_area_and_are_not_too_many() {
        let mut settings = settings(0.0);
        let places = settings.places();
        assert!((30..=60).contains(&places.len()), "{}", places.len());
        assert!(places.iter().all(|place| settings.area.contains(*place, 0.0)));
        settings.kernel.length_m = 10.0;
        assert!(settings.places().len() <= PLACES_MAX);
    }
}
