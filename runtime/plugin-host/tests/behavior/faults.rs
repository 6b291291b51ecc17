use backseat_core::plugin::{FaultKind, Request, StationTarget, VerticalRequest};
use backseat_plugin_host::Budget;

use crate::fixture::{fault_kind, faulty, input, only_modify, template};

/// Every fault that loses the instance, with its kind.
const LOST: [(&str, FaultKind); 9] = [
    ("trap", FaultKind::Trap),
    ("loop", FaultKind::OutOfFuel),
    ("grow", FaultKind::Memory),
    ("flood", FaultKind::TooMuch),
    ("huge_string", FaultKind::TooMuch),
    ("nine_frames", FaultKind::TooMuch),
    ("long_frame", FaultKind::TooMuch),
    ("long_topside", FaultKind::TooMuch),
    ("recursion", FaultKind::Trap),
];

/// A budget with room for everything that the faults do.
fn roomy() -> Budget {
    Budget {
        fuel_per_step: 100_000_000,
        ..Budget::default()
    }
}

#[test]
fn each_fault_is_reported_by_its_kind_and_takes_the_whole_budget() {
    for (fault, kind) in LOST {
        let mut plugin = faulty(fault, 1, roomy());
        only_modify(&plugin.step(&input(0)));
        let returned = plugin.step(&input(1));
        assert_eq!(fault_kind(&returned), Some(kind), "{fault}: {returned:?}");
        assert_eq!(returned.fuel, roomy().fuel_per_step, "{fault}");
        assert!(!plugin.is_running(), "{fault}");
        let text = &returned.result.as_ref().unwrap_err().text;
        assert!(
            !text.is_empty() && text.len() < 400 && !text.contains('\n'),
            "{fault}: {text}"
        );
    }
}

#[test]
fn recursion_without_end_is_told_as_what_it_is() {
    let returned = faulty("recursion", 0, roomy()).step(&input(0));
    let fault = returned.result.expect_err("its stack has an end");
    assert_eq!(fault.kind, FaultKind::Trap);
    assert!(fault.text.contains("as recursion without end does"), "{}", fault.text);
}

#[test]
fn a_lost_plugin_answers_start_until_it_is_started_again() {
    for (fault, _) in LOST {
        let mut plugin = faulty(fault, 1, roomy());
        plugin.step(&input(0));
        plugin.step(&input(1));
        let dead = plugin.step(&input(2));
        assert_eq!((fault_kind(&dead), dead.fuel), (Some(FaultKind::Start), 0), "{fault}");
        let restarted = plugin.restart();
        assert_eq!(restarted.result, Ok(()), "{fault}");
        // No snapshot was taken, so the new instance counts its seconds from the start.
        only_modify(&plugin.step(&input(3)));
    }
}

#[test]
fn no_fault_affects_another_plugin() {
    let alone: Vec<_> = {
        let mut sibling = template();
        (0..6).map(|second| sibling.step(&input(second))).collect()
    };
    for (fault, _) in LOST
        .into_iter()
        .chain([("log_flood", FaultKind::Trap), ("error", FaultKind::Error)])
    {
        let (mut sibling, mut plugin) = (template(), faulty(fault, 2, roomy()));
        let beside: Vec<_> = (0..6)
            .map(|second| {
                plugin.step(&input(second));
                sibling.step(&input(second))
            })
            .collect();
        assert_eq!(beside, alone, "{fault}");
    }
}

#[test]
fn an_error_that_the_plugin_returns_keeps_the_instance() {
    let mut plugin = faulty("error", 1, Budget::default());
    only_modify(&plugin.step(&input(0)));
    let failed = plugin.step(&input(1));
    let fault = failed.result.unwrap_err();
    assert_eq!(
        (fault.kind, &*fault.text),
        (FaultKind::Error, "faulty was told to fail")
    );
    assert!(
        failed.fuel < 1_000_000,
        "only the fuel used is charged: {}",
        failed.fuel
    );
    assert!(plugin.is_running());
}

#[test]
fn the_log_says_where_a_panic_was() {
    let returned = faulty("trap", 0, Budget::default()).step(&input(0));
    let text = &returned.log[0].text;
    assert!(
        text.starts_with("panicked at plugins/faulty/src/lib.rs:") && text.contains("faulty was told to panic"),
        "{text}"
    );
}

#[test]
fn invalid_numbers_reach_core_unchanged() {
    for (fault, matches) in [
        ("nan", (|value| value.is_nan()) as fn(f64) -> bool),
        ("infinite", |value| value == f64::INFINITY),
        ("huge", |value| value == f64::MAX),
    ] {
        let returned = faulty(fault, 0, Budget::default()).step(&input(0));
        let requests = returned.result.unwrap();
        let [
            Request::Modify(modify),
            Request::Trackline(line),
            Request::GpsHit(hit),
            Request::Station(hull),
            Request::Station(bottom),
            Request::SonarAngle(sonar),
        ] = &requests[..]
        else {
            panic!("{fault}: {requests:?}");
        };
        let (
            VerticalRequest::DepthM(depth_m),
            StationTarget::Hull { distance_m, .. },
            StationTarget::Bottom {
                y_m,
                vertical: VerticalRequest::AltitudeM(altitude_m),
                ..
            },
        ) = (line.vertical, hull.target, bottom.target)
        else {
            panic!("{fault}: {requests:?}")
        };
        for value in [
            modify.heading_deg,
            modify.speed_mps,
            line.start.latitude_deg,
            line.end.longitude_deg,
            depth_m,
            hit.position.longitude_deg,
            distance_m,
            hull.speed_mps.unwrap(),
            y_m,
            altitude_m,
            sonar.angle_deg,
        ] {
            assert!(matches(value), "{fault}: {value}");
        }
    }
    let requests = faulty("latitude_91", 0, Budget::default())
        .step(&input(0))
        .result
        .unwrap();
    assert!(
        matches!(&requests[..], [Request::Trackline(line)] if line.start.latitude_deg == 91.0),
        "{requests:?}"
    );
}

#[test]
fn misbehavior_within_the_bounds_is_left_to_core() {
    let mut stale = faulty("stale", 0, Budget::default());
    assert!(only_modify(&stale.step(&input(0))).duration.as_secs() > 300 * 86_400);
    assert_eq!(stale.step(&input(1)).result, Ok(vec![]));
    let contradictory = faulty("contradict", 0, Budget::default())
        .step(&input(0))
        .result
        .unwrap();
    assert_eq!(contradictory.len(), 6);
    assert!(contradictory.contains(&Request::EndModify));
}

#[test]
fn floods_within_the_bounds_and_odd_texts_are_left_to_core() {
    let asked = |fault| faulty(fault, 0, Budget::default()).step(&input(0)).result.unwrap();
    let all = |fault, is: fn(&Request) -> bool| {
        let requests = asked(fault);
        assert_eq!((requests.len(), requests.iter().all(is)), (200, true), "{fault}");
    };
    all("topside_flood", |request| matches!(request, Request::Topside(_)));
    all("packet_flood", |request| matches!(request, Request::Packet(_)));
    all(
        "gps_flood",
        |request| matches!(request, Request::GpsHit(hit) if hit.position.latitude_deg == 42.0),
    );
    all("light_flood", |request| matches!(request, Request::Light(_)));
    let texts: Vec<String> = asked("reserved_text")
        .into_iter()
        .filter_map(|request| {
            if let Request::Topside(message) = request {
                Some(message.text)
            } else {
                None
            }
        })
        .collect();
    assert!(texts.iter().any(|text| text.contains("\r\n$BPKIL,")), "{texts:?}");
    assert!(texts.iter().any(|text| text.ends_with("\u{e9}\0")), "{texts:?}");
    assert!(matches!(&asked("camera_1000")[..], [Request::Camera(camera)] if camera.tilt == -1000));
    assert!(matches!(&asked("no_frames")[..], [Request::Packet(packet)] if packet.frames.is_empty()));
    assert_eq!(asked("uninvited").len(), 5);
}

#[test]
fn a_bound_that_is_broken_is_named() {
    for (fault, text) in [
        ("nine_frames", "a packet of 9 frames, expected at most 8"),
        ("long_frame", "a frame of 10240 bytes, expected at most 1024"),
        ("long_topside", "a message of 257 bytes, expected at most 256"),
    ] {
        let returned = faulty(fault, 0, Budget::default()).step(&input(0));
        assert_eq!(returned.result.unwrap_err().text, text);
    }
}

#[test]
fn the_fence_answers_from_the_judge_with_this_steps_input() {
    let returned = faulty("cross_fence", 0, Budget::default()).step(&input(0));
    assert_eq!(
        returned.log[0].text,
        "the fence says keep-in: outside keep-in zone 'box' with its margin of 5 m by 12.5 m at polygon 3 hole 2 edge 1 \
             (latitude 42.500000 longitude -70.250000)"
    );
    let requests = returned.result.unwrap();
    let [Request::Trackline(line), Request::Modify(modify)] = &requests[..] else {
        panic!("{requests:?}")
    };
    // The point 20 km north-east of the frame's origin, in an input 100 m east and 200 m north of it.
    assert!(
        (line.end.latitude_deg - 42.178).abs() < 0.01 && (line.end.longitude_deg + 69.76).abs() < 0.01,
        "{line:?}"
    );
    assert!((modify.heading_deg - 45.0).abs() < 1.0, "{modify:?}");
    assert!(
        returned.fuel > backseat_plugin_host::FENCE_FUEL,
        "the question is charged"
    );
}
