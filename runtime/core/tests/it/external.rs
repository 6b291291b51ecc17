//! External sources: what they may send, what core sends for them, and how core answers them.

use std::time::Duration;

use backseat_core::plugin::{Request, RequestState};
use backseat_core::{
    ExternalBounds, ExternalId, ExternalSentence, ExternalSetup, Input, Note, Operator, Owner, RequestKind, Settings,
};
use backseat_spi::{AckStatus, FromVehicle, PositionFix, RelayedText, Sentence, ToVehicle, TopsideRelay, Transport};
use backseat_units::{EastNorth, Timestamp, Utc};

use crate::course::{self, modify};
use crate::trial::{Seen, Setup, Trial, short, shorts};
use crate::vehicle::Reply;

const ALL: [ExternalSentence; 5] = [
    ExternalSentence::Relay,
    ExternalSentence::PayloadCtd,
    ExternalSentence::PositionFix,
    ExternalSentence::RelativeReset,
    ExternalSentence::BearingOffset,
];

/// How control is lost.
type Loss = fn(&mut Trial);

pub(crate) fn source(name: &str, sends: &[ExternalSentence], bounds: ExternalBounds) -> ExternalSetup {
    ExternalSetup {
        name: name.to_owned(),
        sends: sends.to_vec(),
        bounds,
    }
}

pub(crate) fn setup(bounds: ExternalBounds) -> Setup {
    Setup {
        settings: Settings {
            externals: vec![source("pod", &ALL, bounds)],
            ..Settings::default()
        },
        ..Setup::default()
    }
}

/// Bounds with a rate that is high enough for a test that sends many sentences in a row.
pub(crate) fn often() -> ExternalBounds {
    ExternalBounds {
        rate_max_hz: 50.0,
        ..ExternalBounds::default()
    }
}

pub(crate) fn under_way(bounds: ExternalBounds) -> Trial {
    Trial::with_under_way(setup(bounds))
}

/// The source sends a line as real payloads do: without a checksum, and with a line feed alone at its end.
pub(crate) fn say(trial: &mut Trial, body: &str) {
    trial.feed(Input::External(ExternalId(0), format!("${body}\n").as_bytes()));
}

/// Our clock, this many seconds from now, as a field.
pub(crate) fn clock(trial: &Trial, seconds: f64) -> String {
    let now = Utc::from_unix_nanos(1_700_000_000_000_000_000) + Duration::from_nanos(trial.now.as_nanos());
    let nanos = now.as_unix_nanos().wrapping_add_signed((seconds * 1e9) as i64);
    let (hour, minute, second, nanos) = Utc::from_unix_nanos(nanos).time_of_day().hms_nano();
    format!("{hour:02}{minute:02}{second:02}.{:03}", nanos / 1_000_000)
}

pub(crate) fn line(message: &ToVehicle) -> String {
    let mut out = Vec::new();
    message.encode(&mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// A fix that is this far from navigation.
pub(crate) fn fix(trial: &Trial, off: EastNorth) -> PositionFix {
    let here = trial.core.navigation().unwrap().local;
    let now = Utc::from_unix_nanos(1_700_000_000_000_000_000) + Duration::from_nanos(trial.now.as_nanos());
    PositionFix {
        created: "01:02:03.456".parse().unwrap(),
        position: course::fence().frame().to_position(here + off),
        error_m: 12.5,
        depth_m: 20.0,
        force: false,
        measured: now.time_of_day().truncated_to_millis(),
    }
}

pub(crate) fn say_fix(trial: &mut Trial, fix: PositionFix) {
    let bytes = line(&fix.into());
    trial.feed(Input::External(ExternalId(0), bytes.as_bytes()));
}

/// The acknowledgements that source 0 has received: name, echoed time, status, text.
pub(crate) fn told(trial: &Trial) -> Vec<(String, String, AckStatus, String)> {
    told_to(trial, 0)
}

pub(crate) fn told_to(trial: &Trial, source: usize) -> Vec<(String, String, AckStatus, String)> {
    let ack = |(_, seen): &(Timestamp, Seen)| match seen {
        Seen::Told(to, bytes) if *to == source => {
            let line = std::str::from_utf8(bytes).unwrap();
            assert!(line.ends_with("\r\n"), "{line:?}");
            let FromVehicle::Acknowledgement(ack) = FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
            else {
                panic!("{line} is not an acknowledgement");
            };
            let (name, echoed) = (ack.command.to_string(), ack.command_created.time().to_string());
            Some((name, echoed, ack.status, ack.text.as_str().to_owned()))
        }
        _ => None,
    };
    trial.seen.iter().filter_map(ack).collect()
}

pub(crate) fn statuses(trial: &Trial) -> Vec<AckStatus> {
    told(trial).into_iter().map(|(_, _, status, _)| status).collect()
}

/// The states of the external source's requests of a kind.
pub(crate) fn states(trial: &Trial, kind: RequestKind) -> Vec<RequestState> {
    let state = |(_, note)| match note {
        Note::Request(transition) if transition.kind == kind => {
            assert_eq!(transition.owner, Owner::External(ExternalId(0)));
            Some(transition.state)
        }
        _ => None,
    };
    trial.notes().into_iter().filter_map(state).collect()
}

pub(crate) fn sent_anything(trial: &Trial) -> bool {
    ["TMR", "CTD", "NPU", "RNS", "RBO"]
        .iter()
        .any(|name| !trial.sent(name).is_empty())
}

#[test]
fn each_sentence_leaves_with_our_time_and_its_answer_returns_with_the_sources_time() {
    let mut trial = under_way(often());
    for body in [
        "BPTMR,081025.987,3,abort",
        "BPCTD,081025.987,42914,10.25,303.4,RECENT",
        "BPRNS,081025.987,1.5,-2.25,90",
        "BPRBO,081025.987,-2.5",
    ] {
        // A sentence that moves the frame takes control for ten seconds.
        trial.run_for(11.0);
        let body = body.replace("RECENT", &clock(&trial, -0.5));
        let at = clock(&trial, 0.0);
        say(&mut trial, &body);
        let name = &body[2..5];
        let sent = trial.commands(name);
        assert_eq!(sent.len(), 1, "{:?}", told(&trial));
        let expected = body.replacen("081025.987", &at, 1);
        let checksum = expected.bytes().fold(0, |sum, byte| sum ^ byte);
        assert_eq!(line(&sent[0].1), format!("${expected}*{checksum:02X}\r\n"));
        trial.run_for(0.1);
        let last = told(&trial).pop().unwrap();
        assert_eq!(
            (last.0.as_str(), last.1.as_str(), last.2),
            (name, "08:10:25.987", AckStatus::Succeeded)
        );
    }
    trial.run_for(11.0);
    let fix = fix(&trial, EastNorth::new(30.0, 0.0));
    trial.run_for(0.3);
    let at = clock(&trial, 0.0);
    say_fix(&mut trial, fix.clone());
    let sent = line(&trial.commands("NPU").pop().unwrap().1);
    let body = |line: &str| line.split_once('*').unwrap().0.to_owned();
    assert_eq!(body(&sent), body(&line(&fix.into())).replacen("010203.456", &at, 1));
    trial.run_for(0.1);
    assert_eq!(told(&trial).len(), 5);
    for kind in [
        RequestKind::Relay,
        RequestKind::PayloadCtd,
        RequestKind::PositionFix,
        RequestKind::RelativeReset,
        RequestKind::BearingOffset,
    ] {
        assert_eq!(shorts(&states(&trial, kind)), ["sent", "accepted", "ended"], "{kind:?}");
    }
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn the_source_learns_of_the_vehicles_refusal_silence_and_pending() {
    for (reply, ends, said) in [
        (Reply::Refuse, vec!["sent", "failed"], vec![AckStatus::Failed]),
        (Reply::Silent, vec!["sent", "timed out"], vec![AckStatus::Failed]),
        (Reply::Nak, vec!["sent", "failed"], vec![AckStatus::Failed]),
        (
            Reply::Pending(Duration::from_secs(1), AckStatus::Succeeded),
            vec!["sent", "pending", "accepted", "ended"],
            vec![AckStatus::Pending, AckStatus::Succeeded],
        ),
        (
            Reply::PendingForEver,
            vec!["sent", "pending", "timed out"],
            vec![AckStatus::Pending, AckStatus::Failed],
        ),
        // After the deadline an answer changes nothing.
        (
            Reply::Late(Duration::from_secs(3), AckStatus::Succeeded),
            vec!["sent", "timed out"],
            vec![AckStatus::Failed],
        ),
    ] {
        let mut trial = under_way(often());
        trial.vehicle.replies.insert("NPU", reply);
        let fix = fix(&trial, EastNorth::new(0.0, 10.0));
        say_fix(&mut trial, fix);
        trial.run_for(10.0);
        assert_eq!(shorts(&states(&trial, RequestKind::PositionFix)), ends, "{reply:?}");
        assert_eq!(statuses(&trial), said, "{reply:?}");
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_a_link_loss_ends_the_open_request_and_nothing_is_sent_twice() {
    let mut trial = under_way(often());
    trial
        .vehicle
        .replies
        .insert("NPU", Reply::Pending(Duration::from_secs(2), AckStatus::Succeeded));
    let fix = fix(&trial, EastNorth::new(0.0, 10.0));
    say_fix(&mut trial, fix.clone());
    trial.run_for(0.5);
    trial.cut();
    assert_eq!(
        shorts(&states(&trial, RequestKind::PositionFix)),
        ["sent", "pending", "timed out"]
    );
    assert_eq!(statuses(&trial), [AckStatus::Pending, AckStatus::Failed]);
    // Without a link nothing is kept for later.
    say_fix(&mut trial, fix);
    say(&mut trial, "BPTMR,081025.987,3,abort");
    assert_eq!(statuses(&trial)[2..], [AckStatus::Failed, AckStatus::Failed]);
    trial.run_for(10.0);
    assert_eq!((trial.sent("NPU").len(), trial.sent("TMR").len()), (1, 0));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn repeated_and_unrelated_answers_change_nothing() {
    let mut trial = under_way(often());
    trial.vehicle.replies.insert("RBO", Reply::Silent);
    say(&mut trial, "BPRBO,081025.987,2.5");
    let now = trial.now;
    let created = trial.commands("RBO")[0].1.created().unwrap();
    let other = created + Duration::from_millis(1);
    trial.vehicle.acknowledge(now, ("RBO", other, None, AckStatus::Failed));
    trial
        .vehicle
        .acknowledge(now, ("RNS", created, None, AckStatus::Failed));
    trial
        .vehicle
        .acknowledge(now, ("RBO", created, None, AckStatus::Succeeded));
    trial
        .vehicle
        .acknowledge(now, ("RBO", created, None, AckStatus::Failed));
    trial
        .vehicle
        .acknowledge(now, ("RBO", created, None, AckStatus::Succeeded));
    trial.run_for(3.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::BearingOffset)),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(statuses(&trial), [AckStatus::Succeeded]);
}

#[test]
fn forbidden_and_invalid_sentences_are_refused_and_counted() {
    let mut trial = Trial::with_under_way(Setup {
        settings: Settings {
            externals: vec![source("ctd", &[ExternalSentence::PayloadCtd], often())],
            ..Settings::default()
        },
        ..Setup::default()
    });
    for (body, name, echoed) in [
        ("BPTMR,081025.987,3,abort", "TMR", "08:10:25.987"),
        ("BPABT,081025.987,for no reason,1", "ABT", "08:10:25.987"),
        ("BPRMB,081025.987,90,3,0,1.5,1,0", "RMB", "08:10:25.987"),
        ("BPLOG,NVG,ON", "LOG", "00:00:00.000"),
        ("BPXYZ,081025.987,1", "NAK", "00:00:00.000"),
        ("BFCTL,081025.987,1", "NAK", "00:00:00.000"),
        ("BPCTD,081025.987,salty,1,2,081025.987", "CTD", "00:00:00.000"),
        ("BPCTD,081025.987,nan,1,2,081025.987", "CTD", "00:00:00.000"),
        ("BPCTD,081025.987,1e400,1,2,081025.987", "CTD", "00:00:00.000"),
        ("BPCTD,,,,,", "CTD", "00:00:00.000"),
        ("BPCTD", "CTD", "00:00:00.000"),
        (
            "BPCTD,081025.987,42914,10.25,303.4,081025.900*00",
            "NAK",
            "00:00:00.000",
        ),
        (",", "NAK", "00:00:00.000"),
    ] {
        trial.run_for(0.1);
        say(&mut trial, body);
        let last = told(&trial).pop().unwrap();
        assert_eq!(
            (last.0.as_str(), last.1.as_str(), last.2),
            (name, echoed, AckStatus::Invalid),
            "{body}"
        );
    }
    assert_eq!(told(&trial).len(), 13);
    let counted = trial
        .notes()
        .into_iter()
        .filter(|(_, note)| note.to_string().contains("external source ctd"));
    let counted: Vec<String> = counted.map(|(_, note)| note.to_string()).collect();
    assert_eq!(
        counted,
        [
            "external source ctd: 1 lines were refused",
            "external source ctd: 10 lines were refused"
        ]
    );
    assert!(!sent_anything(&trial));
    assert_eq!(
        trial.core.request_counts().proposed,
        0,
        "a forbidden sentence is not a request"
    );
}

#[test]
fn a_source_may_begin_with_bpver_and_bplog_as_on_a_vehicle() {
    let mut trial = under_way(often());
    let (versions, subscriptions) = (trial.sent("VER").len(), trial.sent("LOG").len());
    say(&mut trial, "BPVER,081025.987,1.12");
    say(&mut trial, "BPLOG,ACK,ON");
    assert_eq!(statuses(&trial), [AckStatus::Succeeded; 2]);
    trial.run_for(1.0);
    assert_eq!(
        (trial.sent("VER").len(), trial.sent("LOG").len()),
        (versions, subscriptions)
    );
}

#[test]
fn a_modem_line_is_relayed_unchanged_and_one_that_contains_a_command_is_refused() {
    let mut trial = under_way(often());
    let relay = |text: &str| {
        let created = "01:02:03.456".parse().unwrap();
        line(&ToVehicle::from(TopsideRelay {
            created,
            transport: Transport::Ethernet,
            text: RelayedText::cleaned(text),
        }))
    };
    let modem = "$CCRXD,3,9,1,0a0b*4C";
    let bytes = relay(modem);
    trial.feed(Input::External(ExternalId(0), bytes.as_bytes()));
    let Some((_, ToVehicle::TopsideRelay(sent))) = trial.commands("TMR").pop() else {
        panic!("it was not relayed: {:?}", told(&trial))
    };
    assert_eq!(sent.text.as_str(), modem);
    // The line is written by hand, because encoding it already fails.
    let body = "BPTMR,010203.456,$CCRXD,$BPKIL,1";
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let count = trial.sent("TMR").len();
    trial.feed(Input::External(
        ExternalId(0),
        format!("${body}*{sum:02X}\r\n").as_bytes(),
    ));
    assert_eq!(trial.sent("TMR").len(), count);
    let (_, _, status, text) = told(&trial).pop().unwrap();
    assert_ne!(status, AckStatus::Succeeded, "{text}");
}

#[test]
fn sr_014_without_control_only_the_relay_passes() {
    let cases: [(&str, Loss); 4] = [
        ("the vehicle has control", |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        }),
        ("the mission is not running", |trial| {
            let now = trial.now;
            trial.vehicle.set_status(now, "Ready");
        }),
        ("the operator's hold is set", |trial| trial.operator(Operator::Hold)),
        ("navigation is stale", |trial| trial.vehicle.navigates = false),
    ];
    for (reason, lose) in cases {
        let mut trial = under_way(often());
        let recent = clock(&trial, 0.0);
        let fix = fix(&trial, EastNorth::default());
        lose(&mut trial);
        trial.run_for(1.5);
        say_fix(&mut trial, fix);
        for body in [
            format!("BPCTD,081025.987,42914,10.25,303.4,{recent}"),
            "BPRNS,081025.987,1.5,-2.25,90".to_owned(),
            "BPRBO,081025.987,-2.5".to_owned(),
        ] {
            say(&mut trial, &body);
        }
        for (name, _, status, text) in told(&trial) {
            assert_eq!(
                (status, text.as_str()),
                (AckStatus::Failed, format!("control: {reason}").as_str()),
                "{name}"
            );
        }
        assert_eq!(told(&trial).len(), 4);
        assert!(!sent_anything(&trial));
        say(&mut trial, "BPTMR,081025.987,3,abort");
        trial.run_for(0.1);
        assert_eq!(trial.sent("TMR").len(), 1);
        assert_eq!(told(&trial).pop().unwrap().2, AckStatus::Succeeded);
    }
}

#[test]
fn sr_001_an_unarmed_runtime_sends_nothing_of_an_external_source() {
    let mut setup = setup(often());
    setup.start.armed = false;
    let mut trial = Trial::with_under_way(setup);
    let fix = fix(&trial, EastNorth::default());
    say_fix(&mut trial, fix);
    say(&mut trial, "BPTMR,081025.987,3,abort");
    trial.run_for(0.5);
    assert!(!sent_anything(&trial));
    for (_, _, status, text) in told(&trial) {
        assert_eq!(
            (status, text.as_str()),
            (AckStatus::Failed, "control: the runtime is not armed")
        );
    }
}

#[test]
fn sr_019_each_external_source_has_its_own_rate_limit() {
    let mut trial = Trial::with_under_way(Setup {
        settings: Settings {
            externals: vec![
                source("modem", &ALL, ExternalBounds::default()),
                source(
                    "other",
                    &ALL,
                    ExternalBounds {
                        rate_max_hz: 0.2,
                        ..ExternalBounds::default()
                    },
                ),
            ],
            ..Settings::default()
        },
        ..Setup::default()
    });
    for _ in 0..20 {
        say(&mut trial, "BPTMR,081025.987,3,hello");
        trial.feed(Input::External(ExternalId(1), b"$BPTMR,081026.987,3,hello\n"));
        trial.run_for(0.1);
    }
    let passed = |source| {
        let told = told_to(&trial, source).into_iter();
        told.filter(|(_, _, status, _)| *status == AckStatus::Succeeded).count()
    };
    // The first source may send two at once, then two a second for two seconds. The second may send one at once, and
    // the next after five seconds.
    assert_eq!((passed(0), passed(1)), (5, 1));
    assert!(
        told(&trial)
            .iter()
            .any(|ack| ack.3.starts_with("rate: sentences in a second is 3"))
    );
    assert!(
        told_to(&trial, 1).iter().all(|ack| ack.1 == "08:10:26.987"),
        "each source gets the answers to its own sentences"
    );
}

#[test]
fn sr_006_sr_013_a_flood_and_garbage_from_an_external_source_disturb_nobody() {
    let mut trial = under_way(ExternalBounds::default());
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    for flood in [
        "$BPTMR,081025.987,3,abort\n".repeat(10_000).into_bytes(),
        "$\n".repeat(10_000).into_bytes(),
        "$BPXYZ\n".repeat(10_000).into_bytes(),
        vec![b'x'; 10_000_000],
        [b"$BPCTD,".to_vec(), vec![b'9'; 10_000_000]].concat(),
        vec![0xff; 100_000],
    ] {
        let before = trial.seen.len();
        trial.feed(Input::External(ExternalId(0), &flood));
        assert!(trial.seen.len() - before < 200, "{} outputs", trial.seen.len() - before);
        trial.run_for(1.1);
        assert!(trial.core.is_steering());
    }
    let modifies = trial.sent("RMB");
    assert!(
        modifies
            .windows(2)
            .all(|pair| pair[1].since(pair[0]) <= Duration::from_millis(1100))
    );
    // Core reads the sentence that follows the garbage.
    trial.run_for(1.0);
    say(&mut trial, "");
    let relayed = trial.sent("TMR").len();
    say(&mut trial, "BPTMR,081025.987,3,home");
    assert_eq!(trial.sent("TMR").len(), relayed + 1);
}

#[test]
fn an_external_sources_sentences_may_arrive_split_or_cut() {
    let mut trial = under_way(often());
    let mut checked = Vec::new();
    ToVehicle::decode(&Sentence::parse("$BPTMR,081025.987,3,come home").unwrap())
        .unwrap()
        .encode(&mut checked)
        .unwrap();
    for byte in &checked {
        trial.feed(Input::External(ExternalId(0), &[*byte]));
    }
    trial.run_for(0.1);
    assert_eq!(statuses(&trial), [AckStatus::Succeeded]);
    // The next sentence does not complete one that was cut.
    trial.feed(Input::External(ExternalId(0), b"$BPTMR,081025.987,3,abo"));
    trial.feed(Input::External(ExternalId(0), b"$\n"));
    trial.run_for(0.1);
    assert_eq!(trial.sent("TMR").len(), 1);
    assert_eq!(statuses(&trial), [AckStatus::Succeeded, AckStatus::Invalid]);
}

#[test]
fn an_external_source_that_is_not_in_the_mission_is_ignored() {
    let mut trial = under_way(often());
    trial.feed(Input::External(ExternalId(1), b"$BPTMR,081025.987,3,abort\n"));
    trial.run_for(0.5);
    assert!(!sent_anything(&trial) && told_to(&trial, 1).is_empty());
}

#[test]
fn an_open_request_gets_its_answer_even_if_a_plugin_fails_or_control_is_lost() {
    let mut trial = under_way(often());
    trial
        .vehicle
        .replies
        .insert("RBO", Reply::Late(Duration::from_secs(1), AckStatus::Succeeded));
    say(&mut trial, "BPRBO,081025.987,2.5");
    trial.fail(0, backseat_core::plugin::FaultKind::Trap);
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(3.0);
    assert_eq!(statuses(&trial), [AckStatus::Succeeded]);
    assert_eq!(
        states(&trial, RequestKind::BearingOffset).last().map(short),
        Some("ended")
    );
}
