use std::collections::BTreeMap;

use proptest::prelude::*;

use backseat_mvc::{Activity, MvcEventKind, Source};

use crate::files::CALM;
use crate::payload::{Payload, line};

/// What happened to an insert, according to the log.
#[derive(Debug, Default)]
struct Fate {
    accepted: u32,
    began: u32,
    ended: u32,
    cancelled: u32,
}

#[derive(Clone, Debug)]
enum Said {
    Line(u32, bool),
    Hit(u32, u32),
    Cancel(u32),
    Text(&'static str),
}

impl Said {
    fn sentence(&self) -> String {
        match self {
            Self::Line(id, interrupt) => line(*id, 5 + id, if *interrupt { 4 } else { 0 }),
            Self::Hit(id, mode) => format!("$BPRGP,070000.000,{id},4218.06,N,07053.95,W,,,{mode}"),
            Self::Cancel(id) => format!("$BPRCN,070000.000,{id}"),
            Self::Text(text) => (*text).to_owned(),
        }
    }
}

fn said() -> impl Strategy<Value = Said> {
    prop_oneof![
        6 => (1..30u32, any::<bool>()).prop_map(|(id, interrupt)| Said::Line(id, interrupt)),
        2 => (1..30u32, 0..3u32).prop_map(|(id, mode)| Said::Hit(id, mode)),
        2 => (1..30u32).prop_map(Said::Cancel),
        1 => Just(Said::Text("$BPRCA,070000.000")),
        3 => Just(Said::Text("$BPRCB,070000.000,0")),
        1 => Just(Said::Text("$BPRCE,070000.000,0")),
        2 => Just(Said::Text("$BPRMB,070000.000,5,-4,3,1.2,1,1")),
        1 => Just(Said::Text("$BPRMP,070000.000")),
    ]
}

const READINGS: [&str; 3] = [
    "",
    "after_interrupt = \"resume\"\ninsert_place = \"current\"\nmodify_survives = false\ninsert_logging = true",
    "inserts_after_control = \"drop\"\ncancel_all_gps = true\nafter_interrupt = \"resume\"\ninterruption = \"behavior\"",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Every accepted insert begins and ends, or is cancelled, and never both; control implies a running mission; every
    /// BFBDL has its BFSDL; every acknowledged identifier is used once.
    #[test]
    fn the_queue_the_identifiers_and_the_log_agree(
        commands in prop::collection::vec((0..25u32, said()), 1..40),
        reading in 0..READINGS.len(),
        pending in any::<bool>(),
        last in prop_oneof![
            Just("$BPABT,070000.000,x,1"), Just("$BPABT,070000.000,x,0"), Just("$BPKIL,070000.000,x"), Just("$BPMSG,070000.000,x")
        ],
    ) {
        let text = CALM.replace("kind = \"waypoint\"", "kind = \"waypoint\"\ndynamic = true\ndynamic_for_s = 40")
            .replace("[mission]", "[mission]\ngps_fix_s = 5\ngps_within_s = 60\ntime_limit_s = 3000")
            .replace("acknowledge = \"immediate\"", if pending { "pending_s = [0, 1.9]" } else { "acknowledge = \"immediate\"" });
        let text = format!("{text}\n[interpretation]\n{}", READINGS[reading]);
        let mut payload = Payload::connected(&text, 1, &["ACK", "MIS", "CTL"]);
        let mut second = 2.0;
        for (pause, said) in &commands {
            second += f64::from(*pause);
            payload.until(second);
            payload.say(&said.sentence());
            let truth = payload.mvc.truth();
            let running = matches!(truth.activity, Activity::Plan { .. } | Activity::Insert { .. } | Activity::Modified { .. });
            prop_assert!(!truth.control || running, "{:?}", truth);
        }
        payload.say(last);
        payload.until_that(5000.0, |truth| truth.activity == Activity::Stopped);
        payload.until(payload.now.as_secs_f64() + 3.0);
        prop_assert!(payload.mvc.mission_over());
        let mut fates: BTreeMap<u32, Fate> = BTreeMap::new();
        let mut running = None;
        for event in &payload.events {
            #[expect(clippy::wildcard_enum_match_arm, reason = "the rest is not about behaviors")]
            match &event.kind {
                MvcEventKind::InsertAccepted(_, id) => fates.entry(id.get()).or_default().accepted += 1,
                MvcEventKind::InsertCancelled(id, _) => fates.entry(id.get()).or_default().cancelled += 1,
                MvcEventKind::BehaviorBegan(behavior) => {
                    prop_assert_eq!(running.replace(*behavior), None, "one at a time");
                    if let Source::Insert(id) = behavior.source {
                        fates.entry(id.get()).or_default().began += 1;
                    }
                }
                MvcEventKind::BehaviorEnded(behavior, _) => {
                    prop_assert_eq!(running.take(), Some(*behavior));
                    if let Source::Insert(id) = behavior.source {
                        fates.entry(id.get()).or_default().ended += 1;
                    }
                }
                _ => {}
            }
        }
        prop_assert_eq!(running, None);
        for (id, fate) in &fates {
            prop_assert_eq!(fate.accepted, 1, "{} {:?}", id, fate);
            prop_assert_eq!(fate.began, fate.ended, "{} {:?}", id, fate);
            prop_assert!((fate.began >= 1) != (fate.cancelled == 1) && fate.cancelled <= 1, "{} {:?}", id, fate);
            prop_assert!(fate.began <= 1 || reading > 0, "only a resumed one begins twice: {} {:?}", id, fate);
        }
        let heard = payload.heard();
        let told = |name: &str| heard.iter().filter(|line| line.starts_with(name)).count();
        prop_assert_eq!(told("$BFBDL"), told("$BFSDL"));
        let control: Vec<&str> = heard.iter().filter(|line| line.starts_with("$BFCTL")).map(|line| &line[18..]).collect();
        for (index, granted) in control.iter().enumerate() {
            prop_assert_eq!(*granted, if index % 2 == 0 { "1" } else { "0" }, "on transitions only: {:?}", &control);
        }
        let accepted = heard.iter().filter(|line| {
            (line.contains(",RTK,") || line.contains(",RGP,")) && line.ends_with(",2,0,")
        });
        prop_assert_eq!(accepted.count(), fates.len());
    }
}
