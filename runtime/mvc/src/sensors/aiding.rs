use backseat_spi::{AckStatus, PayloadCtd, PositionFix};
use backseat_units::{LocalFrame, TimeOfDay};

use super::{FixOutcome, Sensors};
use crate::context::Context;
use crate::event::MvcEventKind;
use crate::server::answers::Regarding;

/// The greatest error of a fix, metres. A fix with a greater error is useless.
const FIX_ERROR_MAX_M: f64 = 100_000.0;
/// The ranges that a CTD can measure in the sea: microsiemens a centimetre, degrees Celsius, kilopascals.
const CONDUCTIVITY_US_PER_CM: core::ops::RangeInclusive<f64> = 0.0..=100_000.0;
const TEMPERATURE_C: core::ops::RangeInclusive<f64> = -5.0..=50.0;
const PRESSURE_KPA: core::ops::RangeInclusive<f64> = 0.0..=150_000.0;
/// The same where the pressure counts from the atmosphere's.
const GAUGE_PRESSURE_KPA: core::ops::RangeInclusive<f64> = -100.0..=150_000.0;

/// Measurements that a payload makes for the vehicle: fixes and CTD data (SPI 7.15, 7.21).
impl Sensors {
    /// BPNPU: moves the navigation towards the fix, by as much as the accuracy and the age of the fix allow.
    ///
    /// The depth of the fix is not used, because the vehicle's own is better.
    pub(crate) fn position_fix(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &PositionFix) {
        let error_m = request.error_m;
        if !(0.0..=FIX_ERROR_MAX_M).contains(&error_m) {
            let text = format!("circular error probability {error_m}: expected 0 to 100000 m");
            return ctx.invalid(re, &text);
        }
        let place = ctx.frame().to_local(request.position);
        if place.east_m.abs().max(place.north_m.abs()) > LocalFrame::RADIUS_M {
            let text = "the fix is over 50 km from the origin";
            return refuse_fix(ctx, re, text);
        }
        // Both times are from the payload's clock, which may differ from the vehicle's.
        let age_s = age_s(request.created, request.measured);
        match self.fix(ctx.now, place, error_m, age_s, request.force) {
            FixOutcome::Moved(moved_m) => {
                ctx.note(MvcEventKind::PositionFix(re.client, moved_m));
                let text = format!("the navigation moved by {moved_m:.2} m");
                ctx.acknowledge(re, AckStatus::Succeeded, &text);
            }
            FixOutcome::TooOld(age_s) => refuse_fix(ctx, re, &format!("the fix is {age_s:.1} s old")),
            FixOutcome::Outlier { off_m, limit_m } => {
                let text = format!("the fix is an outlier: {off_m:.1} m off where at most {limit_m:.1} m are likely");
                refuse_fix(ctx, re, &text);
            }
        }
    }

    /// BPCTD: the data is logged, and used for the speed of sound.
    pub(crate) fn payload_ctd(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &PayloadCtd) {
        let (pressure_kpa, expected_kpa) = if ctx.interpretation.ctd_pressure_is_gauge {
            (GAUGE_PRESSURE_KPA, "-100 to 150000 kPa")
        } else {
            (PRESSURE_KPA, "0 to 150000 kPa")
        };
        for (what, value, range, expected) in [
            (
                "conductivity",
                request.conductivity_us_per_cm,
                CONDUCTIVITY_US_PER_CM,
                "0 to 100000 uS/cm",
            ),
            ("temperature", request.temperature_c, TEMPERATURE_C, "-5 to 50 degC"),
            ("pressure", request.pressure_kpa, pressure_kpa, expected_kpa),
        ] {
            if !range.contains(&value) {
                return ctx.invalid(re, &format!("{what} {value}: expected {expected}"));
            }
        }
        self.heed_payload_ctd(ctx.now, request);
        ctx.note(MvcEventKind::PayloadCtd {
            client: re.client,
            conductivity_us_per_cm: request.conductivity_us_per_cm,
            temperature_c: request.temperature_c,
            pressure_kpa: request.pressure_kpa,
        });
        ctx.acknowledge(re, AckStatus::Succeeded, "");
    }
}

fn refuse_fix(ctx: &mut Context<'_>, re: Regarding, text: &str) {
    ctx.note(MvcEventKind::PositionFixRefused(re.client, text.into()));
    ctx.acknowledge(re, AckStatus::Failed, text);
}

/// Time from a measurement to the message that carries it, seconds, also across midnight. It is zero if the measurement
/// is later than its message.
fn age_s(created: TimeOfDay, measured: TimeOfDay) -> f64 {
    const DAY_S: f64 = 86_400.0;
    let age_s = created.nanos_since(measured) as f64 / 1e9;
    if age_s < -DAY_S / 2.0 {
        age_s + DAY_S
    } else {
        age_s.max(0.0)
    }
}
