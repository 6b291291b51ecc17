pub(crate) mod integrity;
pub(crate) mod plugin;
pub(crate) mod station;

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::monitor::limits::integrity::IntegrityLimits;
use crate::monitor::limits::station::StationLimits;

/// A limit with an invalid value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} is {value}: expected {expected}")]
pub struct LimitError {
    /// The key of the `limits` table.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// The values that it may have.
    pub expected: &'static str,
}

/// Which north the vehicle counts BPRMB's heading from: the specification does not say (7.12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeadingFrame {
    /// True north.
    #[default]
    True,
    /// The north of the UTM grid, as BFNVG counts it (6.1).
    Grid,
}

/// What the operator allows, and what the vehicle and the water are known to do at worst: the `[limits]` table of a
/// mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// The least speed that may be asked for, m/s.
    pub speed_min_mps: f64,
    /// The greatest speed that may be asked for, m/s.
    pub speed_max_mps: f64,
    /// The turn rate that the vehicle always reaches, degrees per second.
    pub turn_rate_dps: f64,
    /// How much longer a turn takes than it would at that rate throughout, seconds, because the rate has to build up
    /// and decay.
    #[serde(default = "default::turn_lag_s")]
    pub turn_lag_s: f64,
    /// The greatest speed of the vehicle's own plan, m/s. SPI does not report how fast a plan is flown. If absent: the
    /// greater of `speed_max_mps` and the greatest speed over ground that was seen in this dive while the plan was
    /// flown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan_speed_max_mps: Option<f64>,
    /// The shallowest angle at which the vehicle climbs to the surface, degrees. It decides how far the vehicle travels
    /// from the place of a GPS hit while it climbs.
    #[serde(default = "default::climb_angle_min_deg")]
    pub climb_angle_min_deg: f64,
    /// The strongest current, m/s.
    pub current_max_mps: f64,
    /// The shallowest water depth inside the fence, metres. Without it only bottom lock shows the water depth.
    #[serde(default)]
    pub water_depth_min_m: Option<f64>,
    /// The greatest water depth inside the fence, metres. Without it only bottom lock shows the water depth.
    #[serde(default)]
    pub water_depth_max_m: Option<f64>,
    /// The steepest seabed, metres per metre. It decides what a bottom lock shows about the water depth around it.
    #[serde(default = "default::seabed_slope_max")]
    pub seabed_slope_max: f64,
    /// Navigation older than this is stale, seconds.
    #[serde(default = "default::navigation_age_max_s")]
    pub navigation_age_max_s: f64,
    /// How wrong navigation may be, metres.
    #[serde(default = "default::navigation_error_m")]
    pub navigation_error_m: f64,
    /// How long a sentence and its answer may take together, seconds.
    #[serde(default = "default::link_delay_max_s")]
    pub link_delay_max_s: f64,
    /// How far the vehicle strays from a line that it follows, metres.
    #[serde(default = "default::tracking_error_m")]
    pub tracking_error_m: f64,
    /// How far the vehicle strays from a depth or altitude that it holds, metres.
    #[serde(default = "default::vertical_error_m")]
    pub vertical_error_m: f64,
    /// The longest lead-in or lead-out that the vehicle flies before and after a trackline, metres (SPI 7.5, 5.3).
    #[serde(default = "default::lead_max_m")]
    pub lead_max_m: f64,
    /// The longest duration of one modify request, seconds. The plugin must ask again before it is over.
    #[serde(default = "default::modify_term_max_s")]
    pub modify_term_max_s: f64,
    /// How many inserts may be open at once.
    #[serde(default = "default::inserts_open_max")]
    pub inserts_open_max: u32,
    /// How many inserts may be sent in the whole mission.
    #[serde(default = "default::inserts_total_max")]
    pub inserts_total_max: u32,
    /// How long the open inserts together may fly unattended, seconds.
    #[serde(default = "default::inserts_duration_max_s")]
    pub inserts_duration_max_s: f64,
    /// How many requests of one plugin the runtime takes in a second.
    #[serde(default = "default::requests_per_s")]
    pub requests_per_s: u32,
    /// How many GPS hits may be sent in the whole mission.
    #[serde(default = "default::gps_hits_total_max")]
    pub gps_hits_total_max: u32,
    /// How long a GPS hit takes at most, from surfacing to the next behavior, seconds.
    #[serde(default = "default::gps_hit_duration_max_s")]
    pub gps_hit_duration_max_s: f64,
    /// How many trim and buoyancy adjustments may be sent in the whole mission.
    #[serde(default = "default::adjustments_total_max")]
    pub adjustments_total_max: u32,
    /// How often silent mode may be entered in the whole mission.
    #[serde(default = "default::silences_total_max")]
    pub silences_total_max: u32,
    /// After how long the vehicle leaves silent mode by itself, seconds. The vehicle's configuration sets this (SPI
    /// 7.22).
    #[serde(default = "default::silent_term_s")]
    pub silent_term_s: f64,
    /// How many messages may be sent to the topside in a minute. An acoustic modem carries only a few.
    #[serde(default = "default::topside_per_min")]
    pub topside_per_min: u32,
    /// How many acoustic packets may be sent in a minute.
    #[serde(default = "default::packets_per_min")]
    pub packets_per_min: u32,
    /// Whether a modify needs the vehicle's plan (BPRMP), so that the way back to it can be checked.
    #[serde(default = "default::modify_needs_plan")]
    pub modify_needs_plan: bool,
    /// What navigation may report from one sample to the next before it counts as impossible.
    #[serde(default)]
    pub integrity: IntegrityLimits,
    /// What plugins may ask of a hovering vehicle. Without it they may ask nothing.
    #[serde(default)]
    pub station: Option<StationLimits>,
}

mod default {
    pub(super) const fn turn_lag_s() -> f64 {
        2.0
    }
    pub(super) const fn climb_angle_min_deg() -> f64 {
        15.0
    }
    pub(super) const fn seabed_slope_max() -> f64 {
        0.15
    }
    pub(super) const fn navigation_age_max_s() -> f64 {
        1.0
    }
    pub(super) const fn navigation_error_m() -> f64 {
        5.0
    }
    pub(super) const fn link_delay_max_s() -> f64 {
        1.0
    }
    pub(super) const fn tracking_error_m() -> f64 {
        5.0
    }
    pub(super) const fn vertical_error_m() -> f64 {
        1.0
    }
    pub(super) const fn lead_max_m() -> f64 {
        50.0
    }
    pub(super) const fn modify_term_max_s() -> f64 {
        60.0
    }
    pub(super) const fn inserts_open_max() -> u32 {
        4
    }
    pub(super) const fn inserts_total_max() -> u32 {
        100
    }
    pub(super) const fn inserts_duration_max_s() -> f64 {
        3600.0
    }
    pub(super) const fn requests_per_s() -> u32 {
        20
    }
    pub(super) const fn gps_hits_total_max() -> u32 {
        10
    }
    pub(super) const fn gps_hit_duration_max_s() -> f64 {
        900.0
    }
    pub(super) const fn adjustments_total_max() -> u32 {
        10
    }
    pub(super) const fn silences_total_max() -> u32 {
        20
    }
    pub(super) const fn silent_term_s() -> f64 {
        300.0
    }
    pub(super) const fn topside_per_min() -> u32 {
        6
    }
    pub(super) const fn packets_per_min() -> u32 {
        12
    }
    pub(super) const fn modify_needs_plan() -> bool {
        true
    }
}

impl Limits {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`LimitError`] names the first key whose value is not.
    pub fn validate(&self) -> Result<(), LimitError> {
        let positive = [
            ("speed_min_mps", self.speed_min_mps),
            ("speed_max_mps", self.speed_max_mps),
            ("turn_rate_dps", self.turn_rate_dps),
            ("climb_angle_min_deg", self.climb_angle_min_deg),
            ("plan_speed_max_mps", self.plan_speed_max_mps.unwrap_or(1.0)),
            ("navigation_age_max_s", self.navigation_age_max_s),
            ("link_delay_max_s", self.link_delay_max_s),
            ("modify_term_max_s", self.modify_term_max_s),
            ("inserts_duration_max_s", self.inserts_duration_max_s),
            ("gps_hit_duration_max_s", self.gps_hit_duration_max_s),
            ("silent_term_s", self.silent_term_s),
            ("water_depth_min_m", self.water_depth_min_m.unwrap_or(1.0)),
            ("water_depth_max_m", self.water_depth_max_m.unwrap_or(1.0)),
        ];
        for (key, value) in positive {
            if !(value > 0.0 && value < 1e6) {
                return Err(LimitError {
                    key,
                    value,
                    expected: "a number above 0",
                });
            }
        }
        let not_negative = [
            ("current_max_mps", self.current_max_mps),
            ("turn_lag_s", self.turn_lag_s),
            ("seabed_slope_max", self.seabed_slope_max),
            ("navigation_error_m", self.navigation_error_m),
            ("tracking_error_m", self.tracking_error_m),
            ("vertical_error_m", self.vertical_error_m),
            ("lead_max_m", self.lead_max_m),
        ];
        for (key, value) in not_negative {
            if !(0.0..1e6).contains(&value) {
                return Err(LimitError {
                    key,
                    value,
                    expected: "0 or more",
                });
            }
        }
        if self.climb_angle_min_deg > 90.0 {
            return Err(LimitError {
                key: "climb_angle_min_deg",
                value: self.climb_angle_min_deg,
                expected: "at most 90: straight up",
            });
        }
        if self.speed_max_mps < self.speed_min_mps {
            return Err(LimitError {
                key: "speed_max_mps",
                value: self.speed_max_mps,
                expected: "at least speed_min_mps",
            });
        }
        if self.speed_min_mps <= self.current_max_mps {
            return Err(LimitError {
                key: "speed_min_mps",
                value: self.speed_min_mps,
                expected: "more than current_max_mps, so that the vehicle can hold its course",
            });
        }
        if self.navigation_age_max_s > 4.0 {
            return Err(LimitError {
                key: "navigation_age_max_s",
                value: self.navigation_age_max_s,
                expected: "at most 4: a modify lapses after 5 s",
            });
        }
        if let (Some(min), Some(max)) = (self.water_depth_min_m, self.water_depth_max_m)
            && max < min
        {
            return Err(LimitError {
                key: "water_depth_max_m",
                value: max,
                expected: "at least water_depth_min_m",
            });
        }
        if self.requests_per_s == 0 {
            return Err(LimitError {
                key: "requests_per_s",
                value: 0.0,
                expected: "at least 1",
            });
        }
        self.integrity.validate()?;
        self.station.as_ref().map_or(Ok(()), StationLimits::validate)
    }

    pub(crate) fn navigation_age_max(&self) -> Duration {
        seconds(self.navigation_age_max_s)
    }

    /// A hovering vehicle's own speed limit, m/s; `None` without `[limits.station]`.
    pub(crate) fn speed_default_mps(&self) -> Option<f64> {
        self.station.as_ref().map(|station| station.speed_default_mps)
    }

    pub(crate) fn link_delay_max(&self) -> Duration {
        seconds(self.link_delay_max_s)
    }

    pub(crate) fn silent_term(&self) -> Duration {
        seconds(self.silent_term_s)
    }

    pub(crate) fn modify_term_max(&self) -> Duration {
        seconds(self.modify_term_max_s)
    }
}

/// A validated limit in seconds as a duration. An invalid value becomes zero, which allows nothing.
pub(crate) fn seconds(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::ZERO)
}

/// What the operator lets a plugin do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Grant {
    /// BPRMB leases.
    Modify,
    /// BPRTK and BPRTC inserts, and cancelling its own.
    Insert,
    /// Inserts that interrupt what is being flown. Such an insert cannot be taken back (SPI 7.8).
    Interrupt,
    /// BPMSG lines in the vehicle's log.
    Message,
    /// BPRGP: surfacing, where the fence allows it.
    Surface,
    /// BPTOP messages.
    Topside,
    /// The payload's part in triggering the DVL (BPDVR).
    Dvl,
    /// BPSIL.
    Silent,
    /// BPTRM.
    Trim,
    /// BPBOY.
    Buoyancy,
    /// BPCPD packets, in the windows that the vehicle opens.
    Acoustic,
    /// Station keeping of a hovering vehicle (BPSUS, BPCON, BPGHP, BPGBP, BPSPD, BPRES).
    Station,
    /// Sonar angle, camera and light of a hovering vehicle (BPSAN, BPPTZ, BPLIT).
    Devices,
    /// Settings and logging of the sonars behind the payload controller (7k format).
    Sonar,
}

impl Grant {
    /// Its name in the mission.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Modify => "modify",
            Self::Insert => "insert",
            Self::Interrupt => "interrupt",
            Self::Message => "message",
            Self::Surface => "surface",
            Self::Topside => "topside",
            Self::Dvl => "dvl",
            Self::Silent => "silent",
            Self::Trim => "trim",
            Self::Buoyancy => "buoyancy",
            Self::Acoustic => "acoustic",
            Self::Station => "station",
            Self::Devices => "devices",
            Self::Sonar => "sonar",
        }
    }
}

/// What the runtime does when a plugin fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FailAction {
    /// Its lease ends. Its inserts are flown.
    #[default]
    Yield,
    /// Its lease ends, and its inserts that have not begun are cancelled, one by one by their identifiers.
    Cancel,
    /// As `cancel`, and the vehicle's mission is aborted (BPABT, SPI 7.16).
    Abort,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn limits() -> Limits {
        Limits {
            speed_min_mps: 1.0,
            speed_max_mps: 2.0,
            turn_rate_dps: 8.0,
            turn_lag_s: 0.0,
            plan_speed_max_mps: None,
            climb_angle_min_deg: 90.0,
            current_max_mps: 0.3,
            water_depth_min_m: None,
            water_depth_max_m: None,
            seabed_slope_max: 0.1,
            navigation_age_max_s: 1.0,
            navigation_error_m: 5.0,
            link_delay_max_s: 1.0,
            integrity: IntegrityLimits::default(),
            tracking_error_m: 5.0,
            vertical_error_m: 1.0,
            lead_max_m: 50.0,
            modify_term_max_s: 60.0,
            inserts_open_max: 4,
            inserts_total_max: 100,
            inserts_duration_max_s: 3600.0,
            requests_per_s: 20,
            gps_hits_total_max: 10,
            gps_hit_duration_max_s: 900.0,
            adjustments_total_max: 10,
            silences_total_max: 20,
            silent_term_s: 300.0,
            topside_per_min: 6,
            packets_per_min: 12,
            modify_needs_plan: true,
            station: None,
        }
    }

    #[test]
    fn an_invalid_limit_is_named() {
        assert_eq!(limits().validate(), Ok(()));
        for (key, broken) in [
            (
                "speed_max_mps",
                Limits {
                    speed_max_mps: 0.5,
                    ..limits()
                },
            ),
            (
                "speed_min_mps",
                Limits {
                    current_max_mps: 1.5,
                    ..limits()
                },
            ),
            (
                "turn_rate_dps",
                Limits {
                    turn_rate_dps: f64::NAN,
                    ..limits()
                },
            ),
            (
                "silent_term_s",
                Limits {
                    silent_term_s: 0.0,
                    ..limits()
                },
            ),
            (
                "lead_max_m",
                Limits {
                    lead_max_m: -1.0,
                    ..limits()
                },
            ),
            (
                "navigation_age_max_s",
                Limits {
                    navigation_age_max_s: 10.0,
                    ..limits()
                },
            ),
            (
                "requests_per_s",
                Limits {
                    requests_per_s: 0,
                    ..limits()
                },
            ),
        ] {
            assert_eq!(broken.validate().unwrap_err().key, key);
        }
    }
}
