//! Figures that have a range, and the refusal of one that is out of its range.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Refusal, Rule};

/// A row for each figure: its doc, its name in logs, its name in texts, its unit, its rule, and the mission's key that
/// sets its range, if there is one.
macro_rules! figures {
    ($($(#[$doc:meta])* $figure:ident $name:literal $spoken:literal $unit:literal $rule:ident $key:literal;)*) => {
        /// A figure of a request, or a count of what was sent before, that must stay within a range.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Figure {
            $($(#[$doc])* $figure,)*
        }

        impl Figure {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$figure),*];

            /// Its name in logs and for plugins: `modify-term`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$figure => $name,)* }
            }

            /// Its name in texts: `duration of a modify`.
            #[must_use]
            pub const fn spoken(self) -> &'static str {
                match self { $(Self::$figure => $spoken,)* }
            }

            /// Its unit; empty for a count.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$figure => $unit,)* }
            }

            /// The rule that bounds it.
            #[must_use]
            pub const fn rule(self) -> Rule {
                match self { $(Self::$figure => Rule::$rule,)* }
            }

            /// The mission's key that sets its range; empty if the range is fixed.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self { $(Self::$figure => $key,)* }
            }
        }
    };
}

figures! {
    /// A request's latitude.
    Latitude "latitude" "latitude" "deg" Limit "";
    /// A request's longitude.
    Longitude "longitude" "longitude" "deg" Limit "";
    /// A request's depth.
    Depth "depth" "depth" "m" Limit "";
    /// A request's altitude.
    Altitude "altitude" "altitude" "m" Limit "";
    /// A modify's heading.
    Heading "heading" "heading" "deg" Limit "";
    /// A request's speed.
    Speed "speed" "speed" "m/s" Limit "limits.speed_min_mps, limits.speed_max_mps";
    /// How long a modify lasts.
    ModifyTerm "modify-term" "duration of a modify (more than 0)" "s" Limit "limits.modify_term_max_s";
    /// The distance between a trackline's ends.
    TracklineLength "trackline-length" "length of a trackline" "m" Limit "";
    /// A circle's radius. The circle must not be tighter than the vehicle can turn.
    CircleRadius "circle-radius" "radius of a circle" "m" Limit "limits.turn_rate_dps";
    /// A circle's orbits. Their sign is the direction.
    CircleOrbits "circle-orbits" "number of orbits (not 0)" "" Limit "";
    /// The angle at which a circle is entered.
    EntryAngle "entry-angle" "entry angle of a circle" "deg" Limit "";
    /// How long station keeping lasts.
    StationTerm "station-term" "term of station keeping (more than 0)" "s" Limit "limits.station.term_max_s";
    /// The speed of a hovering vehicle.
    StationSpeed "station-speed" "speed of station keeping" "m/s" Limit "limits.station.speed_max_mps";
    /// The vehicle's own speed, which a move without a speed uses.
    DefaultSpeed "default-speed" "the vehicle's own speed (for a move without a speed)" "m/s" Limit "limits.station.speed_default_mps";
    /// The number of places at which the mission may have been suspended.
    Suspensions "suspensions" "places where the mission is suspended" "" Cap "";
    /// A sonar's angle.
    SonarAngle "sonar-angle" "angle of the sonar" "deg" Limit "limits.station.sonar_angle_min_deg, limits.station.sonar_angle_max_deg";
    /// A camera's pan.
    CameraPan "camera-pan" "pan of the camera" "tenths of a second" Limit "";
    /// A camera's tilt.
    CameraTilt "camera-tilt" "tilt of the camera" "tenths of a second" Limit "";
    /// A camera's zoom.
    CameraZoom "camera-zoom" "zoom of the camera" "tenths of a second" Limit "";
    /// A light's number.
    Light "light" "number of a light" "" Limit "";
    /// The range of a sonar.
    SonarRange "sonar-range" "range of a sonar (more than 0)" "m" Limit "";
    /// The power of a sonar.
    SonarPower "sonar-power" "power of a sonar" "%" Limit "";
    /// The time from ping to ping of a sonar.
    SonarPeriod "sonar-period" "period of a sonar (more than 0)" "ms" Limit "";
    /// A packet's telemetry mode (SPI 9.3).
    TelemetryMode "telemetry-mode" "telemetry mode" "" Limit "";
    /// The bytes of a packet's frames.
    FrameBytes "frame-bytes" "size of a packet's frames" "bytes" Limit "";
    /// The bytes of a message to the topside.
    TextBytes "text-bytes" "length of the text" "bytes" Text "";
    /// A plugin's requests in a second.
    Requests "requests" "requests in a second" "" Rate "limits.requests_per_s";
    /// Packets in a minute.
    Packets "packets" "packets in a minute" "" Rate "limits.packets_per_min";
    /// Messages to the topside in a minute.
    TopsideMessages "topside-messages" "messages to the topside in a minute" "" Rate "limits.topside_per_min";
    /// An external source's sentences in a second.
    Sentences "sentences" "sentences in a second" "" Rate "external.bounds.rate_max_hz";
    /// How long a plugin steers in the whole run.
    Steering "steering" "time that the plugin steers" "s" Cap "plugin.limits.steering_max_s";
    /// Open inserts of all plugins.
    OpenInserts "open-inserts" "open inserts" "" Cap "limits.inserts_open_max";
    /// Inserts of the whole mission.
    Inserts "inserts" "inserts of the mission" "" Cap "limits.inserts_total_max";
    /// GPS hits of the whole mission.
    GpsHits "gps-hits" "GPS hits of the mission" "" Cap "limits.gps_hits_total_max";
    /// How long the open inserts may fly.
    InsertsDuration "inserts-duration" "duration of all open inserts" "s" Cap "limits.inserts_duration_max_s";
    /// A plugin's own open inserts.
    OwnOpenInserts "own-open-inserts" "open inserts of the plugin" "" Cap "plugin.limits.inserts_open_max";
    /// A plugin's own inserts of the whole run.
    OwnInserts "own-inserts" "inserts of the plugin" "" Cap "plugin.limits.inserts_total_max";
    /// How long a plugin's own open inserts may fly.
    OwnInsertsDuration "own-inserts-duration" "duration of the plugin's open inserts" "s" Cap "plugin.limits.inserts_duration_max_s";
    /// Inserts that wait for the vehicle to answer.
    WaitingInserts "waiting-inserts" "inserts that wait for the vehicle to answer" "" Heard "";
    /// Silences of the whole mission.
    Silences "silences" "silences of the mission" "" Cap "limits.silences_total_max";
    /// Adjustments of trim and buoyancy in the whole mission.
    Adjustments "adjustments" "adjustments of the mission" "" Cap "limits.adjustments_total_max";
    /// How long an empty mission lasts.
    EmptyMission "empty-mission" "duration of the empty mission" "s" Limit "";
    /// The error of an external source's fix.
    FixError "fix-error" "error of the fix (more than 0)" "m" Limit "external.bounds.fix_error_max_m";
    /// How old an external source's measurement is.
    MeasuredAge "measured-age" "age of the measurement" "s" Limit "external.bounds.measured_age_max_s";
    /// An external source's conductivity.
    Conductivity "conductivity" "conductivity" "uS/cm" Limit "";
    /// An external source's temperature.
    Temperature "temperature" "temperature" "degC" Limit "";
    /// An external source's pressure.
    Pressure "pressure" "pressure" "kPa" Limit "";
    /// The depth of an external source's fix.
    FixDepth "fix-depth" "depth of the fix" "m" Limit "external.bounds.fix_depth_difference_max_m";
    /// The distance of an external source's fix from the middle of the fence.
    FixFromFence "fix-from-fence" "distance of the fix from the fence's middle" "m" Limit "";
    /// The distance of an external source's fix from navigation.
    FixFromNavigation "fix-from-navigation" "distance of the fix from navigation" "m" Limit "external.bounds.fix_distance_max_m";
    /// The x to which relative navigation is set.
    ResetX "reset-x" "x" "m" Limit "external.bounds.reset_max_m";
    /// The y to which relative navigation is set.
    ResetY "reset-y" "y" "m" Limit "external.bounds.reset_max_m";
    /// The bearing to which relative navigation is set.
    ResetBearing "reset-bearing" "bearing" "deg" Limit "";
    /// The offset of the heading.
    BearingOffset "bearing-offset" "offset of the bearing" "deg" Limit "external.bounds.offset_max_deg";
}

/// A value that JSON has no number for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotFinite {
    /// Not a number.
    Nan,
    /// Infinite.
    Infinity,
    /// Infinite, below zero.
    MinusInfinity,
}

impl NotFinite {
    /// What a value is; `None` if it is finite.
    const fn of(value: f64) -> Option<Self> {
        if value.is_nan() {
            Some(Self::Nan)
        } else if value == f64::INFINITY {
            Some(Self::Infinity)
        } else if value == f64::NEG_INFINITY {
            Some(Self::MinusInfinity)
        } else {
            None
        }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::Nan => "NaN",
            Self::Infinity => "infinite",
            Self::MinusInfinity => "minus infinite",
        }
    }
}

/// A figure that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FigureBreach {
    /// The figure.
    pub figure: Figure,
    /// Its value, or what that would be; `None` if it is not a finite number.
    pub value: Option<f64>,
    /// What it is if it is not a finite number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_finite: Option<NotFinite>,
    /// The least allowed value, if there is one.
    pub least: Option<f64>,
    /// The greatest allowed value, if there is one.
    pub most: Option<f64>,
}

impl Figure {
    /// Refuses a value outside a range with two ends.
    pub(crate) fn not_within(self, value: f64, least: f64, most: f64) -> Refusal {
        self.breach(value, Some(least), Some(most))
    }

    /// Refuses a value that is, or would be, greater than allowed.
    pub(crate) fn over(self, value: f64, most: f64) -> Refusal {
        self.breach(value, None, Some(most))
    }

    /// Refuses a value that is less than allowed.
    pub(crate) fn under(self, value: f64, least: f64) -> Refusal {
        self.breach(value, Some(least), None)
    }

    /// Refuses one thing more than allowed.
    pub(crate) fn one_over(self, most: u32) -> Refusal {
        self.over(f64::from(most) + 1.0, f64::from(most))
    }

    /// Refuses a value that its type does not accept.
    pub(crate) fn out_of_range(self) -> impl Fn(backseat_units::OutOfRange) -> Refusal {
        move |error| self.not_within(error.value, error.min, error.max)
    }

    fn breach(self, value: f64, least: Option<f64>, most: Option<f64>) -> Refusal {
        let finite = |value: f64| value.is_finite().then_some(value);
        Refusal::Figure(FigureBreach {
            figure: self,
            value: finite(value),
            not_finite: NotFinite::of(value),
            least: least.and_then(finite),
            most: most.and_then(finite),
        })
    }
}

impl fmt::Display for FigureBreach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            figure,
            value,
            not_finite,
            least,
            most,
        } = self;
        let (spoken, above_0) = match figure.spoken().strip_suffix(ABOVE_0) {
            Some(spoken) => (spoken, true),
            None => (figure.spoken(), false),
        };
        write!(f, "{spoken} is ")?;
        match (value, not_finite) {
            (Some(value), _) => Decimal(*value).fmt(f)?,
            (None, Some(what)) => f.write_str(what.text())?,
            (None, None) => f.write_str("not a finite number")?,
        }
        match (least, most) {
            (Some(0.0) | None, Some(most)) if above_0 => {
                write!(f, "; expected more than 0, at most {}", Decimal(*most))?
            }
            (Some(least), Some(most)) => write!(f, "; expected {} to {}", Decimal(*least), Decimal(*most))?,
            (Some(least), None) => write!(f, "; expected at least {}", Decimal(*least))?,
            (None, Some(most)) => write!(f, "; expected at most {}", Decimal(*most))?,
            (None, None) => {}
        }
        if !figure.unit().is_empty() {
            write!(f, " {}", figure.unit())?;
        }
        if !figure.key().is_empty() {
            write!(f, " ({})", figure.key())?;
        }
        Ok(())
    }
}

/// With this a figure's spoken name says that 0 itself is not allowed.
const ABOVE_0: &str = " (more than 0)";

/// A figure in a text: three decimals at most, and an exponent for what no figure ever is.
struct Decimal(f64);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() >= 1e9 {
            return write!(f, "{:e}", self.0);
        }
        let text = format!("{:.3}", self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_figure_is_printed_with_its_range_its_unit_and_its_key() {
        let told = |refusal: Refusal| refusal.to_string();
        assert_eq!(
            told(Figure::Speed.not_within(3.0, 1.0, 2.25)),
            "limit: speed is 3; expected 1 to 2.25 m/s (limits.speed_min_mps, limits.speed_max_mps)"
        );
        assert_eq!(
            told(Figure::OpenInserts.one_over(3)),
            "cap: open inserts is 4; expected at most 3 (limits.inserts_open_max)"
        );
        assert_eq!(
            told(Figure::Depth.under(f64::NAN, 0.0)),
            "limit: depth is NaN; expected at least 0 m"
        );
        assert_eq!(
            told(Figure::Depth.not_within(1e300, 0.0, 12_000.0)),
            "limit: depth is 1e300; expected 0 to 12000 m"
        );
        assert_eq!(
            told(Figure::ModifyTerm.not_within(3.0, 0.0, 2.0)),
            "limit: duration of a modify is 3; expected more than 0, at most 2 s (limits.modify_term_max_s)"
        );
    }

    #[test]
    fn names_are_unique_and_the_same_in_the_log() {
        for figure in Figure::ALL {
            assert_eq!(serde_json::to_value(figure).unwrap(), figure.name());
            let same = Figure::ALL.iter().filter(|other| other.name() == figure.name());
            assert_eq!(same.count(), 1);
        }
    }
}
