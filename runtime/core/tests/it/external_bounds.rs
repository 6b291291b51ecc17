//! How far the mission trusts an external source's figures.

use backseat_core::plugin::Request;
use backseat_core::{ConductivityUnit, ExternalBounds};
use backseat_spi::{AckStatus, PositionFix, ToVehicle};
use backseat_units::EastNorth;

use crate::course::modify;
use crate::external::{clock, fix, often, say, say_fix, sent_anything, statuses, told, under_way};

#[test]
fn figures_beyond_the_bounds_are_rejected_and_never_clamped() {
    let mut trial = under_way(often());
    trial.run_for(1.0);
    let recent = clock(&trial, 0.0);
    let ctd = |figures: &str| format!("BPCTD,081025.987,{figures},{recent}");
    let (old, ahead) = (clock(&trial, -11.0), clock(&trial, 3.0));
    for (body, rule) in [
        (ctd("-1,10,300"), "conductivity is -1;"),
        (ctd("100001,10,300"), "conductivity is 100001"),
        (ctd("40000,51,300"), "temperature is 51; expected -5 to 50 degC"),
        (ctd("40000,-6,300"), "temperature is -6"),
        (ctd("40000,10,-1"), "pressure is -1; expected 0 to"),
        (ctd("40000,10,130000"), "pressure is 130000"),
        (format!("BPCTD,081025.987,40000,10,300,{old}"), "age of the measurement"),
        (
            format!("BPCTD,081025.987,40000,10,300,{ahead}"),
            "age of the measurement",
        ),
        (
            "BPCTD,081025.987,40000,10,300,101010.000".to_owned(),
            "age of the measurement",
        ),
        ("BPRNS,081025.987,51,0,0".to_owned(), "x is 51; expected -50 to 50 m"),
        ("BPRNS,081025.987,0,-51,0".to_owned(), "y is -51"),
        ("BPRNS,081025.987,0,0,361".to_owned(), "bearing is 361"),
        (
            "BPRBO,081025.987,46".to_owned(),
            "offset of the bearing is 46; expected -45 to 45 deg",
        ),
        ("BPRBO,081025.987,-46".to_owned(), "offset of the bearing is -46"),
    ] {
        say(&mut trial, &body);
        let last = told(&trial).pop().unwrap();
        assert_eq!(last.2, AckStatus::Failed, "{body}");
        assert!(
            last.3.starts_with("limit: ") && last.3.contains(rule),
            "{body}: {}",
            last.3
        );
        trial.run_for(0.05);
    }
    let good = fix(&trial, EastNorth::new(30.0, 0.0));
    let far = fix(&trial, EastNorth::new(501.0, 0.0)).position;
    let away = backseat_units::Position::from_deg(43.0, -70.0).unwrap();
    for (fix, rule) in [
        (
            PositionFix {
                force: true,
                ..good.clone()
            },
            "force",
        ),
        (
            PositionFix {
                error_m: 0.0,
                ..good.clone()
            },
            "error of the fix is 0",
        ),
        (
            PositionFix {
                error_m: -1.0,
                ..good.clone()
            },
            "error of the fix is -1",
        ),
        (
            PositionFix {
                error_m: 101.0,
                ..good.clone()
            },
            "error of the fix is 101",
        ),
        (
            PositionFix {
                depth_m: -1.0,
                ..good.clone()
            },
            "depth of the fix is -1",
        ),
        (
            PositionFix {
                depth_m: 71.0,
                ..good.clone()
            },
            "depth of the fix is 71;",
        ),
        (
            PositionFix {
                position: far,
                ..good.clone()
            },
            "distance of the fix from navigation is 50",
        ),
        (
            PositionFix { position: away, ..good },
            "distance of the fix from the fence's middle is 111",
        ),
    ] {
        say_fix(&mut trial, fix);
        let last = told(&trial).pop().unwrap();
        assert!(
            last.2 == AckStatus::Failed && last.3.contains(rule),
            "{rule}: {}",
            last.3
        );
        trial.run_for(0.05);
    }
    assert!(!sent_anything(&trial));
    assert_eq!(trial.core.request_counts().rejected, 22);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn conductivity_leaves_in_the_unit_that_the_vehicle_is_set_to() {
    use ConductivityUnit::{MicrosiemensPerCentimetre as Micro, SiemensPerMetre as Siemens};
    for (conductivity_in, conductivity_out, says, leaves) in [
        (Micro, Micro, "42914", 42_914.0),
        (Micro, Siemens, "42914", 4.291),
        (Siemens, Micro, "4.2914", 42_914.0),
        (Siemens, Siemens, "4.291", 4.291),
    ] {
        let mut trial = under_way(ExternalBounds {
            conductivity_in,
            conductivity_out,
            ..often()
        });
        let recent = clock(&trial, 0.0);
        say(&mut trial, &format!("BPCTD,081025.987,{says},10.25,303.4,{recent}"));
        let Some((_, ToVehicle::PayloadCtd(ctd))) = trial.commands("CTD").pop() else {
            panic!("{:?}", told(&trial));
        };
        assert!((ctd.conductivity_us_per_cm - leaves).abs() < 1e-6, "{ctd:?}");
    }
}

#[test]
fn sr_021_a_sentence_that_moves_the_frame_leaves_after_the_lease_has_ended_and_takes_control_for_ten_seconds() {
    for forced in ["NPU", "RNS", "RBO"] {
        let mut trial = under_way(ExternalBounds {
            fix_force: true,
            ..often()
        });
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        assert!(trial.core.is_steering());
        let before = trial.now;
        match forced {
            "NPU" => {
                let fix = PositionFix {
                    force: true,
                    ..fix(&trial, EastNorth::new(5.0, 0.0))
                };
                say_fix(&mut trial, fix);
            }
            "RNS" => say(&mut trial, "BPRNS,081025.987,1.5,-2.25,90"),
            _ => say(&mut trial, "BPRBO,081025.987,-2.5"),
        }
        assert_eq!(trial.names_since(before), ["EMB", forced], "{:?}", told(&trial));
        assert!(!trial.core.is_steering() && !trial.core.has_control());
        trial.run_for(9.8);
        assert!(!trial.core.has_control(), "steady for too short a time");
        trial.run_for(0.5);
        assert!(trial.core.has_control());
        assert_eq!(statuses(&trial), [AckStatus::Succeeded]);
    }
    // The vehicle weighs a fix that is not forced by itself, so core only watches the navigation, as it always does.
    let mut trial = under_way(often());
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    let fix = fix(&trial, EastNorth::new(5.0, 0.0));
    say_fix(&mut trial, fix);
    trial.run_for(1.0);
    assert!(trial.core.is_steering());
}

#[test]
fn invalid_bounds_are_named() {
    assert_eq!(ExternalBounds::default().validate(), Ok(()));
    let broken = |bounds: ExternalBounds| bounds.validate().unwrap_err().key;
    let usual = ExternalBounds::default;
    assert_eq!(
        broken(ExternalBounds {
            rate_max_hz: 0.0,
            ..usual()
        }),
        "rate_max_hz"
    );
    assert_eq!(
        broken(ExternalBounds {
            fix_distance_max_m: f64::NAN,
            ..usual()
        }),
        "fix_distance_max_m"
    );
    assert_eq!(
        broken(ExternalBounds {
            offset_max_deg: 181.0,
            ..usual()
        }),
        "offset_max_deg"
    );
    assert_eq!(
        broken(ExternalBounds {
            measured_age_max_s: -1.0,
            ..usual()
        }),
        "measured_age_max_s"
    );
}
