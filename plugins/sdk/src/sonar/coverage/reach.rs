use serde::{Deserialize, Serialize};

use super::look::{Band, Strip};

/// The most strips that are kept for a line. Beyond it, every second one is dropped.
const STRIPS_MAX: usize = 2048;

/// What each side has seen along a line, strip by strip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LineReach {
    strips: Vec<Reached>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Reached {
    length_m: f32,
    port: [f32; 2],
    starboard: [f32; 2],
}

impl LineReach {
    /// Takes in a strip.
    pub fn note(&mut self, strip: &Strip) {
        if self.strips.len() >= STRIPS_MAX {
            let mut keep = false;
            self.strips.retain(|_| {
                keep = !keep;
                keep
            });
        }
        let band = |band: Band| [band.inner_m as f32, band.outer_m.max(band.inner_m) as f32];
        self.strips.push(Reached {
            length_m: strip.length_m() as f32,
            port: band(strip.to.port),
            starboard: band(strip.to.starboard),
        });
    }

    /// How many strips it keeps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.strips.len()
    }

    /// Whether it has no strip.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.strips.is_empty()
    }

    /// The worst that port and starboard have seen: the bands that all strips have seen but those of a part of the
    /// length, 0 to 1, at each edge. `None` without a strip.
    #[must_use]
    pub fn worst(&self, but: f64) -> Option<(Band, Band)> {
        let side = |of: fn(&Reached) -> [f32; 2]| {
            Some(Band {
                inner_m: self.quantile(1.0 - but, |strip| of(strip)[0])?,
                outer_m: self.quantile(but, |strip| of(strip)[1])?,
            })
        };
        Some((side(|strip| strip.port)?, side(|strip| strip.starboard)?))
    }

    /// The value that a part of the length is at or below.
    fn quantile(&self, part: f64, of: impl Fn(&Reached) -> f32) -> Option<f64> {
        let mut values: Vec<(f32, f64)> = self
            .strips
            .iter()
            .map(|strip| (of(strip), f64::from(strip.length_m)))
            .collect();
        values.sort_by(|one, other| one.0.total_cmp(&other.0));
        let whole: f64 = values.iter().map(|(_, length_m)| length_m).sum();
        let mut below = 0.0;
        for (value, length_m) in &values {
            below += length_m;
            // A little more, because the sum of all lengths may round to less than the whole.
            if below >= part * whole * (1.0 - 1e-12) && below > 0.0 {
                return Some(f64::from(*value));
            }
        }
        values.last().map(|(value, _)| f64::from(*value))
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::EastNorth;

    use super::super::look::Look;
    use super::*;

    fn strip(length_m: f64, port_m: f64, starboard_m: f64) -> Strip {
        let look = |north_m| Look {
            at_ns: 0,
            at: EastNorth::new(0.0, north_m),
            bearing_deg: 0.0,
            port: Band {
                inner_m: 60.0 - port_m,
                outer_m: port_m,
            },
            starboard: Band {
                inner_m: 8.0,
                outer_m: starboard_m,
            },
        };
        Strip {
            from: look(0.0),
            to: look(length_m),
        }
    }

    #[test]
    fn the_worst_leaves_out_a_part_of_the_length() {
        let mut reach = LineReach::default();
        assert_eq!(reach.worst(0.0), None);
        for _ in 0..19 {
            reach.note(&strip(10.0, 50.0, 52.0));
        }
        reach.note(&strip(10.0, 30.0, 52.0));
        let worst = reach.worst(0.0).unwrap();
        assert_eq!(
            worst,
            (
                Band {
                    inner_m: 30.0,
                    outer_m: 30.0
                },
                Band {
                    inner_m: 8.0,
                    outer_m: 52.0
                }
            )
        );
        let most = reach.worst(0.1).unwrap();
        assert_eq!(
            most,
            (
                Band {
                    inner_m: 10.0,
                    outer_m: 50.0
                },
                Band {
                    inner_m: 8.0,
                    outer_m: 52.0
                }
            )
        );
    }

    #[test]
    fn a_long_line_is_thinned_and_keeps_its_worst_within_reason() {
        let mut reach = LineReach::default();
        for index in 0..20_000 {
            reach.note(&strip(5.0, if index % 4000 < 2000 { 40.0 } else { 50.0 }, 50.0));
        }
        assert!(reach.len() <= STRIPS_MAX, "{}", reach.len());
        assert_eq!(reach.worst(0.05).unwrap().0.outer_m, 40.0);
    }
}
