//! Hovering commands at random: nothing panics, the vehicle stays out of the ship and off the bottom, and no suspension
//! lasts longer than 2 s after the last command that may prolong it (SPI 8.1, 8.2, 8.6, 8.7).

use std::time::Duration;

use backseat_mvc::Activity;
use backseat_units::Timestamp;
use proptest::prelude::*;

use crate::hovering::{HARBOUR, hovering};
use crate::payload::Payload;

fn command() -> impl Strategy<Value = String> {
    let metres = -40.0..40.0f64;
    prop_oneof![
        4 => Just("$BPSUS,070000.000".to_owned()),
        3 => Just("$BPCON,070000.000".to_owned()),
        1 => Just("$BPRES,070000.000".to_owned()),
        1 => (-1.0..3.0f64).prop_map(|mps| format!("$BPSPD,070000.000,{mps:.2}")),
        1 => (-100.0..100.0f64).prop_map(|deg| format!("$BPSAN,070000.000,{deg:.1}")),
        5 => (metres.clone(), -2.0..20.0f64, -1.0..15.0f64)
            .prop_map(|(h, v, d)| format!("$BPGHP,070000.000,{h:.2},{v:.2},{d:.2}")),
        4 => (metres.clone(), metres.clone(), any::<bool>(), -1.0..20.0f64).prop_map(|(x, y, depth, metres)| {
            let reference = if depth { 'D' } else { 'A' };
            format!("$BPGBP,070000.000,{x:.2},{y:.2},{reference},{metres:.2}")
        }),
        1 => (metres.clone(), metres, -400.0..400.0f64)
            .prop_map(|(x, y, deg)| format!("$BPRNS,070000.000,{x:.2},{y:.2},{deg:.1}")),
        1 => (-400.0..400.0f64).prop_map(|deg| format!("$BPRBO,070000.000,{deg:.1}")),
        1 => (-12..12, -12..12, -12..12).prop_map(|(p, t, z)| format!("$BPPTZ,070000.000,{p},{t},{z}")),
        1 => (0..3, 0..3).prop_map(|(light, on)| format!("$BPLIT,070000.000,{light},{on}")),
        1 => Just("$BPRMB,070000.000,0,2,0,0.7,1,0".to_owned()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_payload_says_the_vehicle_stays_clear_and_the_suspension_lapses(
        said in prop::collection::vec((command(), 1u64..3000), 1..60),
        seed in 0u64..1000,
        current_mps in 0.0..0.5f64,
        current_deg in 0.0..360.0f64,
        water_m in 6.0..15.0f64,
        downslope_deg in 0.0..360.0f64,
    ) {
        let text = HARBOUR.replace("drift_m_per_sqrt_h = 0", "drift_m_per_sqrt_h = 20")
            .replace("depth_m = 15\nslope = 0", &format!("depth_m = {water_m}\nslope = 0.1\ndownslope_deg = {downslope_deg}"));
        let text = format!(
            "{text}\n[current]\nspeed_mps = {current_mps}\ntowards_deg = {current_deg}\n[interpretation]\nafter_suspension \
             = \"seed\"\nhull_vertical = \"seed\"\nsuspend_needs_control = \"seed\""
        );
        let mut payload = Payload::connected(&text, seed, &["ALL"]);
        payload.until(2.0);
        let mut kept_until = Timestamp::ZERO;
        for (sentence, wait_ms) in &said {
            payload.say(sentence);
            if ["$BPSUS", "$BPCON", "$BPGHP", "$BPGBP"].iter().any(|name| sentence.starts_with(name)) {
                kept_until = payload.now + Duration::from_secs(2);
            }
            let end = payload.now + Duration::from_millis(*wait_ms);
            loop {
                let at = payload.mvc.poll_timeout().expect("a vehicle always has a next step");
                if at > end {
                    break;
                }
                payload.until(at.as_secs_f64());
                payload.now = at;
                let (truth, hover) = (payload.mvc.truth(), hovering(&payload));
                let suspended = truth.activity == Activity::Suspended;
                prop_assert!(!suspended || at < kept_until, "suspended at {at}, kept until {kept_until}");
                prop_assert!(hover.suspended_until.is_none_or(|until| until <= kept_until));
                // When the vehicle drifts after its mission, only the hull itself keeps it off the ship, and nothing
                // keeps it off a shore.
                let adrift = truth.activity == Activity::Stopped;
                let least_m = if adrift { -1e-9 } else { 0.49 };
                prop_assert!(hover.clearance_m.is_some_and(|metres| metres >= least_m), "{hover:?} {truth:?}");
                prop_assert!(adrift || truth.altitude_m > 0.5, "{truth:?}");
            }
            payload.until(end.as_secs_f64());
            payload.now = end;
        }
        payload.heard();
        payload.until(payload.now.as_secs_f64() + 2.0);
        prop_assert!(payload.mvc.truth().activity != Activity::Suspended);
    }
}
