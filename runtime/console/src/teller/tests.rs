use std::time::Duration;

use super::*;
use crate::item::{Beat, Steering};

fn teller() -> Teller {
    Teller::new([("isobath".to_owned(), Some(1000)), ("echo".to_owned(), None)])
}

/// The items of some messages, each with its time in milliseconds.
fn told(teller: &mut Teller, messages: &[(u64, &str, &str)]) -> Vec<(Item, bool)> {
    let mut items = Vec::new();
    for (millis, topic, data) in messages {
        let now = Timestamp::ZERO + Duration::from_millis(*millis);
        teller.hear(now, topic, data.as_bytes(), |_, item, keep| items.push((item, keep)));
    }
    items
}

fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!(r#"{{"text":"${body}*{sum:02X}\r\n"}}"#)
}

fn beats(items: &[(Item, bool)]) -> Vec<Beat> {
    items
        .iter()
        .filter_map(|(item, _)| if let Item::Beat(beat) = item { Some(*beat) } else { None })
        .collect()
}

#[test]
fn an_acknowledgement_is_a_round_trip_and_a_lease_is_steering() {
    let mut teller = teller();
    let sent = r#"{"text":"","request":1,"owner":"plugin","plugin":0,"tag":1,"kind":"modify","state":"sent"}"#;
    let modify = |second: u32, heading: f64| sentence(&format!("BPRMB,0810{second:02}.500,{heading},3,0,1.5,1,0"));
    let ack = sentence("BFACK,081020.700,RMB,081020.500,0,2,0,accepted");
    let status = sentence("BPSTS,081020.500,1,steering; sonar ok");
    let end = sentence("BPEMB,081024.000");
    let items = told(
        &mut teller,
        &[
            (0, "/link/to_vehicle", &modify(20, 90.0)),
            (0, "/requests", sent),
            (10, "/link/to_vehicle", &status),
            (250, "/link/from_vehicle", &ack),
            (1200, "/link/to_vehicle", &modify(21, 90.0)),
            (2100, "/link/to_vehicle", &modify(22, 91.0)),
            (3000, "/link/to_vehicle", &end),
            (4000, "/link/to_vehicle", &end),
        ],
    );
    let steering: Vec<&Steering> = items
        .iter()
        .filter_map(|(item, _)| {
            if let Item::Steering(steering) = item {
                Some(steering)
            } else {
                None
            }
        })
        .collect();
    let owners: Vec<_> = steering.iter().map(|steering| steering.owner.as_deref()).collect();
    assert_eq!(owners, [Some("isobath"), Some("isobath"), None]);
    assert_eq!((steering[0].heading_deg, steering[0].depth_m), (Some(90.0), Some(3.0)));
    assert_eq!(
        (steering[1].heading_deg, steering[1].speed_mps),
        (Some(91.0), Some(1.5))
    );
    assert!(items.contains(&(
        Item::Status {
            text: "steering".to_owned()
        },
        true
    )));
    let beats = beats(&items);
    let steered = *beats.iter().rev().find(|beat| beat.refreshed.is_some()).unwrap();
    assert_eq!((steered.refreshed, steered.worst_gap_s), (Some(2.1), 1.2));
    let last = *beats.last().unwrap();
    assert_eq!((last.round_trip_s, last.acknowledged), (Some(0.25), Some(0.25)));
    assert_eq!((last.refreshed, last.worst_gap_s), (None, 1.2));
}

#[test]
fn a_hold_before_the_start_is_told() {
    for held in [true, false] {
        let start = format!(r#"{{"input":"start","start":{{"utc":0,"armed":true,"held":{held},"jitter":1}}}}"#);
        let items = told(&mut teller(), &[(0, "/core/input", &start)]);
        let hold = Item::Operator {
            act: "hold".to_owned(),
            who: None,
        };
        assert_eq!(items.contains(&(hold, true)), held, "{items:?}");
    }
}

#[test]
fn a_hold_has_its_name_and_a_loss_of_control_its_newest_reason() {
    let status = |text: &str| sentence(&format!("BPSTS,081020.500,1,{text}"));
    let items = told(
        &mut teller(),
        &[
            (
                0,
                "/control",
                r#"{"granted":false,"reason":"the vehicle does not answer in time"}"#,
            ),
            (100, "/link/to_vehicle", &status("the vehicle has control")),
            (
                200,
                "/log",
                r#"{"level":2,"name":"operator","message":"Ann at the console: hold"}"#,
            ),
            (200, "/notes", r#"{"note":"operator","act":"hold"}"#),
            (300, "/notes", r#"{"note":"operator","act":"release"}"#),
        ],
    );
    let reason = Some("the vehicle has control".to_owned());
    assert!(
        items.contains(&(Item::Control { granted: false, reason }, true)),
        "{items:?}"
    );
    let act = |act: &str, who: Option<&str>| Item::Operator {
        act: act.to_owned(),
        who: who.map(str::to_owned),
    };
    assert!(items.contains(&(act("hold", Some("Ann")), true)) && items.contains(&(act("release", None), true)));
}

#[test]
fn navigation_reaches_who_listens_and_each_second_the_history() {
    let row = r#"{"time_s":1.0,"latitude_deg":42.0,"longitude_deg":-70.0,"depth_m":3.0,"heading_deg":90.0,
        "roll_deg":0.0,"pitch_deg":0.0,"east_mps":1.0,"north_mps":0.0,"yaw_rate_dps":0.0,"gps":false}"#;
    let messages: Vec<(u64, &str, &str)> = (0..50).map(|place| (100 * place, "/navigation", row)).collect();
    let items = told(&mut teller(), &messages);
    let kept: Vec<bool> = items
        .iter()
        .filter(|(item, _)| matches!(item, Item::Navigation { .. }))
        .map(|(_, keep)| *keep)
        .collect();
    assert_eq!((kept.len(), kept.iter().filter(|keep| **keep).count()), (50, 5));
    let Some((
        Item::Navigation {
            course_deg, speed_mps, ..
        },
        _,
    )) = items.first()
    else {
        panic!("{items:?}")
    };
    assert_eq!((*course_deg, *speed_mps), (90.0, 1.0));
}

#[test]
fn what_happened_has_names_and_reasons() {
    let items = told(
        &mut teller(),
        &[
            (
                0,
                "/notes",
                r#"{"text":"x","note":"plugin-failed","plugin":1,"fault":{"kind":"trap","text":"unreachable"},"then":"restart"}"#,
            ),
            (0, "/notes", r#"{"text":"x","note":"plugin-restarted","plugin":1}"#),
            (
                0,
                "/requests",
                r#"{"text":"x","request":7,"owner":"plugin","plugin":0,"tag":1,"kind":"modify","state":"rejected","reason":"1.2 m outside"}"#,
            ),
            (
                0,
                "/control",
                r#"{"text":"x","granted":false,"reason":"the operator's hold is set"}"#,
            ),
            (
                0,
                "/log",
                r#"{"level":3,"name":"plugin isobath","message":"no bottom lock"}"#,
            ),
            (0, "/measures/isobath/slope", r#"{"value":2.5,"unit":"%"}"#),
            (100, "/measures/isobath/slope", r#"{"value":2.6,"unit":"%"}"#),
            (
                100,
                "/core/input",
                r#"{"input":"returned","plugin":0,"returned":{"fuel":250,"log":[]}}"#,
            ),
            (100, "/notes", "not JSON"),
            (100, "/measures/isobath", r#"{"value":2.6}"#),
        ],
    );
    let shown: Vec<String> = items
        .iter()
        .filter(|(item, _)| !matches!(item, Item::Beat(_)))
        .map(|(item, _)| serde_json::to_string(item).unwrap())
        .collect();
    assert_eq!(
        shown,
        [
            r#"{"kind":"plugin","plugin":"echo","state":"failed","text":"unreachable","failures":1}"#,
            r#"{"kind":"plugin","plugin":"echo","state":"running","failures":1}"#,
            r#"{"kind":"request","request":7,"owner":"isobath","request_kind":"modify","state":"rejected","tag":1,"reason":"1.2 m outside"}"#,
            r#"{"kind":"counts","rejected":1,"sent":0,"accepted":0,"failed":0,"by":{"isobath":{"rejected":1,"sent":0,"accepted":0,"failed":0}}}"#,
            r#"{"kind":"control","granted":false,"reason":"the operator's hold is set"}"#,
            r#"{"kind":"line","level":"warn","who":"plugin isobath","text":"no bottom lock"}"#,
            r#"{"kind":"measure","plugin":"isobath","name":"slope","value":2.5,"unit":"%"}"#,
            r#"{"kind":"plugin","plugin":"isobath","state":"running","failures":0}"#,
            r#"{"kind":"headroom","plugin":"isobath","fuel":0.25,"steps":1}"#,
        ]
    );
}

#[test]
fn what_the_vehicle_says_again_is_of_little_interest_and_a_contact_is_a_place() {
    let mut teller = teller();
    let line = |who: &str, text: &str| format!(r#"{{"level":2,"name":"{who}","message":"{text}"}}"#);
    let items = told(
        &mut teller,
        &[
            (
                0,
                "/log",
                &line("vehicle", "3943.013 s: client 1 reports status ok: has control"),
            ),
            (
                1000,
                "/log",
                &line("vehicle", "3944.008 s: client 1 reports status ok: has control"),
            ),
            (
                2000,
                "/log",
                &line("vehicle", "3945.008 s: client 1 reports status ok: steering"),
            ),
            (3000, "/log", &line("plugin echo", "contact 7 confirmed at 42.3 -70.7")),
        ],
    );
    let levels: Vec<&str> = items
        .iter()
        .filter_map(|(item, _)| {
            if let Item::Line { level, .. } = item {
                Some(*level)
            } else {
                None
            }
        })
        .collect();
    assert_eq!(levels, ["info", "debug", "info", "info"]);
    let contact = |(item, kept): &(Item, bool)| {
        *kept && matches!(item, Item::Contact { name, plugin, .. } if name == "7" && plugin == "echo")
    };
    assert!(items.iter().any(contact), "{items:?}");
}

#[test]
fn a_log_that_is_no_longer_written_is_told() {
    let ended = r#"{"written":false,"text":"the log ends here"}"#;
    let items = told(&mut teller(), &[(0, "/recording", ended)]);
    let text = "the log ends here".to_owned();
    assert!(
        items.contains(&(Item::Recording { written: false, text }, true)),
        "{items:?}"
    );
}
