//! The values that an external source may send, compared with the mission's bounds and with present navigation.

use backseat_spi::{BearingOffset, PayloadCtd, PositionFix, RelativeReset, ToVehicle};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay};
use serde::{Deserialize, Serialize};

use crate::monitor::limits::LimitError;
use crate::plugin::{NavigationSample, Refusal};
use crate::refusal::{Figure, Reason};

/// A measurement may be ahead of our clock by this, seconds, because the external source's instrument has a clock of
/// its own.
const AHEAD_MAX_S: f64 = 0.5;
/// Sea water has about 60,000 uS/cm at most.
const CONDUCTIVITY_MAX_US_PER_CM: f64 = 100_000.0;
const TEMPERATURE_MIN_C: f64 = -5.0;
const TEMPERATURE_MAX_C: f64 = 50.0;
/// The deepest sea has about 112,000 kPa.
const PRESSURE_MAX_KPA: f64 = 120_000.0;

/// A unit of conductivity. The specification says uS/cm (SPI 7.15), but there is a client that sends S/m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ConductivityUnit {
    /// Microsiemens per centimetre.
    #[default]
    #[serde(rename = "uS/cm")]
    MicrosiemensPerCentimetre,
    /// Siemens per metre.
    #[serde(rename = "S/m")]
    SiemensPerMetre,
}

impl ConductivityUnit {
    /// How many uS/cm one of this unit is.
    const fn us_per_cm(self) -> f64 {
        match self {
            Self::MicrosiemensPerCentimetre => 1.0,
            Self::SiemensPerMetre => 10_000.0,
        }
    }
}

/// The values that an external source may send, and how often: the `[external.bounds]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExternalBounds {
    /// How many sentences of all kinds pass in a second, above 0 and at most 100. As many may come at once, but at
    /// least one.
    pub rate_max_hz: f64,
    /// How old a measurement may be, by its own time and our clock, seconds (BPNPU, BPCTD).
    pub measured_age_max_s: f64,
    /// How far a fix may be from present navigation, metres (BPNPU).
    pub fix_distance_max_m: f64,
    /// The largest radius of a fix's error, metres (BPNPU).
    pub fix_error_max_m: f64,
    /// How far a fix's depth may be from present navigation's, metres (BPNPU).
    pub fix_depth_difference_max_m: f64,
    /// Whether a fix may be forced upon the vehicle (BPNPU). That ends leases and station keeping.
    pub fix_force: bool,
    /// How far relative navigation may be reset along each axis, metres (BPRNS).
    pub reset_max_m: f64,
    /// The largest bearing offset, degrees to either side (BPRBO).
    pub offset_max_deg: f64,
    /// The unit of conductivity that the external source sends (BPCTD).
    pub conductivity_in: ConductivityUnit,
    /// The unit of conductivity that the runtime sends to the vehicle (BPCTD).
    pub conductivity_out: ConductivityUnit,
}

impl Default for ExternalBounds {
    fn default() -> Self {
        Self {
            rate_max_hz: 2.0,
            measured_age_max_s: 10.0,
            fix_distance_max_m: 500.0,
            fix_error_max_m: 100.0,
            fix_depth_difference_max_m: 50.0,
            fix_force: false,
            reset_max_m: 50.0,
            offset_max_deg: 45.0,
            conductivity_in: ConductivityUnit::default(),
            conductivity_out: ConductivityUnit::default(),
        }
    }
}

impl ExternalBounds {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`LimitError`] names the first key whose value is not.
    pub fn validate(&self) -> Result<(), LimitError> {
        let figures = [
            ("rate_max_hz", self.rate_max_hz, 100.0, "above 0, at most 100"),
            (
                "measured_age_max_s",
                self.measured_age_max_s,
                3600.0,
                "above 0, at most 3600",
            ),
            (
                "fix_distance_max_m",
                self.fix_distance_max_m,
                50_000.0,
                "above 0, at most 50000",
            ),
            (
                "fix_error_max_m",
                self.fix_error_max_m,
                50_000.0,
                "above 0, at most 50000",
            ),
            (
                "fix_depth_difference_max_m",
                self.fix_depth_difference_max_m,
                12_000.0,
                "above 0, at most 12000",
            ),
            ("reset_max_m", self.reset_max_m, 50_000.0, "above 0, at most 50000"),
            ("offset_max_deg", self.offset_max_deg, 180.0, "above 0, at most 180"),
        ];
        for (key, value, most, expected) in figures {
            if !(value > 0.0 && value <= most) {
                return Err(LimitError { key, value, expected });
            }
        }
        Ok(())
    }

    /// How many sentences may come at once.
    pub(crate) fn burst(&self) -> f64 {
        self.rate_max_hz.max(1.0)
    }

    /// Checks a CTD sample, and converts it to the vehicle's unit.
    pub(crate) fn ctd(&self, ctd: PayloadCtd, utc: TimeOfDay) -> Result<PayloadCtd, Refusal> {
        self.recent(ctd.measured, utc)?;
        let us_per_cm = ctd.conductivity_us_per_cm * self.conductivity_in.us_per_cm();
        within(Figure::Conductivity, us_per_cm, 0.0, CONDUCTIVITY_MAX_US_PER_CM)?;
        within(
            Figure::Temperature,
            ctd.temperature_c,
            TEMPERATURE_MIN_C,
            TEMPERATURE_MAX_C,
        )?;
        within(Figure::Pressure, ctd.pressure_kpa, 0.0, PRESSURE_MAX_KPA)?;
        Ok(PayloadCtd {
            conductivity_us_per_cm: us_per_cm / self.conductivity_out.us_per_cm(),
            ..ctd
        })
    }

    pub(crate) fn fix(
        &self,
        fix: &PositionFix,
        utc: TimeOfDay,
        frame: &LocalFrame,
        navigation: &NavigationSample,
    ) -> Result<(), Refusal> {
        self.recent(fix.measured, utc)?;
        if fix.force && !self.fix_force {
            return Err(Reason::FixForced.into());
        }
        if fix.error_m == 0.0 {
            return Err(Figure::FixError.not_within(0.0, 0.0, self.fix_error_max_m));
        }
        within(Figure::FixError, fix.error_m, 0.0, self.fix_error_max_m)?;
        let (depth_m, off_m) = (navigation.depth.as_m(), self.fix_depth_difference_max_m);
        within(
            Figure::FixDepth,
            fix.depth_m,
            (depth_m - off_m).max(0.0),
            depth_m + off_m,
        )?;
        let local = frame.to_local(fix.position);
        let out_m = local.distance_m(EastNorth::default());
        within(Figure::FixFromFence, out_m, 0.0, LocalFrame::RADIUS_M)?;
        let way_m = local.distance_m(navigation.local);
        within(Figure::FixFromNavigation, way_m, 0.0, self.fix_distance_max_m)
    }

    pub(crate) fn reset(&self, reset: &RelativeReset) -> Result<(), Refusal> {
        within(Figure::ResetX, reset.x_m, -self.reset_max_m, self.reset_max_m)?;
        within(Figure::ResetY, reset.y_m, -self.reset_max_m, self.reset_max_m)?;
        within(Figure::ResetBearing, reset.bearing_deg, -180.0, 360.0)
    }

    pub(crate) fn bearing(&self, offset: &BearingOffset) -> Result<(), Refusal> {
        within(
            Figure::BearingOffset,
            offset.offset_deg,
            -self.offset_max_deg,
            self.offset_max_deg,
        )
    }

    /// Compares a measurement's own time with our clock. The time of the sentence does not count, because the clock of
    /// its sender may be hours off. What the vehicle does with a measurement depends on when it was made.
    fn recent(&self, measured: TimeOfDay, utc: TimeOfDay) -> Result<(), Refusal> {
        let age_s = utc.nanos_since(measured) as f64 / 1e9;
        if (-AHEAD_MAX_S..=self.measured_age_max_s).contains(&age_s) {
            return Ok(());
        }
        Err(Figure::MeasuredAge.not_within(age_s, -AHEAD_MAX_S, self.measured_age_max_s))
    }
}

fn within(figure: Figure, value: f64, least: f64, most: f64) -> Result<(), Refusal> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(figure.not_within(value, least, most))
}

/// Whether a message moves the frame in which the monitor judges: a message that the vehicle cannot ignore.
pub(crate) fn moves_frame(message: &ToVehicle) -> bool {
    resets_relative(message) || matches!(message, ToVehicle::PositionFix(fix) if fix.force)
}

/// Whether a message resets relative navigation.
pub(crate) const fn resets_relative(message: &ToVehicle) -> bool {
    matches!(message, ToVehicle::RelativeReset(_) | ToVehicle::BearingOffset(_))
}

/// The same message, made at `created`.
pub(crate) fn stamped(message: ToVehicle, created: TimeOfDay) -> ToVehicle {
    #[expect(clippy::wildcard_enum_match_arm, reason = "no other message is an external source's")]
    match message {
        ToVehicle::TopsideRelay(relay) => ToVehicle::TopsideRelay(backseat_spi::TopsideRelay { created, ..relay }),
        ToVehicle::PayloadCtd(ctd) => ToVehicle::PayloadCtd(PayloadCtd { created, ..ctd }),
        ToVehicle::PositionFix(fix) => ToVehicle::PositionFix(PositionFix { created, ..fix }),
        ToVehicle::RelativeReset(reset) => ToVehicle::RelativeReset(RelativeReset { created, ..reset }),
        ToVehicle::BearingOffset(offset) => ToVehicle::BearingOffset(BearingOffset { created, ..offset }),
        other => other,
    }
}
