use proptest::prelude::*;

use backseat_mvc::ClientId;

use crate::files::CALM;
use crate::payload::{ME, Payload};

#[test]
fn the_vehicle_speaks_first_and_then_only_when_asked() {
    let mut payload = Payload::new(CALM, 1);
    payload.connect(ME);
    assert_eq!(payload.heard(), ["$BFVER,080000.000,1.12"]);
    payload.until(20.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

#[test]
fn the_field_profile_has_control_and_mission_on() {
    let mut payload = Payload::new(&CALM.replace("[spi]", "[spi]\nprofile = \"field\""), 1);
    payload.connect(ME);
    payload.until(20.0);
    let names: Vec<String> = payload.heard().iter().map(|line| line[..6].to_owned()).collect();
    assert_eq!(names, ["$BFVER", "$BFMIS", "$BFCTL"]);
}

#[test]
fn a_late_subscriber_misses_control_unless_it_is_replayed() {
    for (replay, expected) in [
        ("false", [].as_slice()),
        (
            "true",
            [
                "$BFCTL,080010.000,1",
                "$BFMIS,080010.000,survey.dive,Running /logs/survey,",
            ]
            .as_slice(),
        ),
    ] {
        let text = format!("{CALM}\n[interpretation]\ncontrol_replay = {replay}");
        let mut payload = Payload::connected(&text, 1, &[]);
        payload.until(10.0);
        payload.say("$BPLOG,CTL,ON");
        payload.say("$BPLOG,MIS,ON");
        assert_eq!(payload.heard(), expected, "{replay}");
    }
}

#[test]
fn subscriptions_belong_to_one_client_and_end_with_its_connection() {
    let other = ClientId(2);
    let mut payload = Payload::connected(CALM, 1, &["NVG", "CTD"]);
    payload.connect(other);
    payload.say_as(other, "$BPLOG,ALL,ON");
    payload.heard_by(other);
    payload.until(1.0);
    let names = |lines: Vec<String>| {
        let mut names: Vec<String> = lines.iter().map(|line| line[3..6].to_owned()).collect();
        names.sort();
        names.dedup();
        names
    };
    assert_eq!(names(payload.heard()), ["CTD", "NVG"]);
    assert_eq!(
        names(payload.heard_by(other)),
        [
            "BOY", "CTD", "CTL", "DV2", "DVL", "ERC", "IMU", "MBS", "MIS", "NVG", "NVR", "RBS", "RCM", "RDP", "RVL",
            "SVS"
        ]
    );
    payload.mvc.disconnect(payload.now, ME);
    payload.connect(ME);
    payload.until(3.0);
    assert_eq!(names(payload.heard()), ["VER"]);
    payload.say_as(other, "$BPLOG,ALL,OFF");
    payload.heard_by(other);
    payload.until(5.0);
    assert_eq!(payload.heard_by(other), Vec::<String>::new());
}

#[test]
fn a_client_that_never_reads_is_cut_off_and_the_others_go_on() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    let deaf = ClientId(2);
    payload.connect(deaf);
    // Nothing is drained in between, so everything that the deaf client asks for piles up.
    let flood = "$BPLOG,ACK,ON\r\n$BPMSG,070000.000,x\r\n".repeat(60_000);
    payload.mvc.receive(payload.now, deaf, flood.as_bytes());
    let mut out = Vec::new();
    let mut most = 0;
    while payload.mvc.poll_transmit(&mut out).is_some() {
        most = most.max(out.len());
    }
    assert!(most < 5 << 20, "{most}");
    assert_eq!(payload.mvc.poll_disconnect(), Some(deaf));
    payload.until(1.0);
    assert_eq!(payload.heard().len(), 10);
}

#[test]
fn too_many_clients_are_turned_away() {
    let mut payload = Payload::new(&CALM.replace("[spi]", "[spi]\nclients_max = 2"), 1);
    for client in 1..=3 {
        payload.connect(ClientId(client));
    }
    assert_eq!(payload.cut_off, [ClientId(3)]);
    assert_eq!(payload.heard_by(ClientId(3)), Vec::<String>::new());
}

#[test]
fn bytes_of_an_unknown_client_are_ignored() {
    let mut payload = Payload::new(CALM, 1);
    payload.bytes(ClientId(9), b"$BPLOG,ALL,ON\r\n");
    payload.until(2.0);
    assert_eq!(payload.heard_by(ClientId(9)), Vec::<String>::new());
}

/// Any value of a field: small, huge, negative, empty, no number.
fn field() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<i16>().prop_map(|value| value.to_string()),
        (0..6u8).prop_map(|value| value.to_string()),
        any::<f32>().prop_map(|value| format!("{value}")),
        Just(String::new()),
        Just("4218.1".to_owned()),
        Just("9000".to_owned()),
        "[ -~]{0,6}",
    ]
}

fn command() -> impl Strategy<Value = Vec<u8>> {
    let modify = prop::collection::vec(field(), 6).prop_map(|f| format!("$BPRMB,070000.000,{}\n", f.join(",")));
    let line = (0..4u32, 0..9000u32, 0..9000u32, field(), field(), 0..3u32, prop_oneof![Just(0), Just(4)]).prop_map(
        |(id, start, end, metres, speed, mode, interrupt)| {
            format!(
                "$BPRTK,070000.000,{id},{start:04}.5,N,07054.0,W,{end:04}.5,N,07054.0,W,{mode},{metres},{speed},0,{interrupt}\n"
            )
        },
    );
    let circle = (field(), field(), field(), field(), field()).prop_map(|(radius, orbits, metres, speed, angle)| {
        format!("$BPRTC,070000.000,9,4218.0,N,07054.0,W,{radius},{orbits},0,{metres},{speed},0,{angle},4\n")
    });
    let hit = (field(), field(), field(), 0..4u32)
        .prop_map(|(id, time, hits, mode)| format!("$BPRGP,070000.000,{id},4218.0,N,07054.0,W,{time},{hits},{mode}\n"));
    let ending = (0..4usize, field(), field()).prop_map(|(name, one, other)| {
        let name = ["RCB", "RCE", "SEM", "ABT"][name];
        format!("$BP{name},070000.000,{one},{other}\n")
    });
    prop_oneof![
        hit.prop_map(String::into_bytes),
        ending.prop_map(String::into_bytes),
        modify.prop_map(String::into_bytes),
        line.prop_map(String::into_bytes),
        circle.prop_map(String::into_bytes),
        Just(b"$BPRMP,070000.000\n$BPRCA,070000.000\n".to_vec()),
        prop::collection::vec(any::<u8>(), 0..300),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_that_a_client_sends_upsets_the_vehicle(commands in prop::collection::vec(command(), 1..40)) {
        let mut payload = Payload::connected(CALM, 1, &["ALL", "ACK"]);
        payload.until(5.0);
        payload.heard();
        for (second, bytes) in (6..).zip(&commands) {
            payload.bytes(ME, bytes);
            payload.until(f64::from(second));
            let truth = payload.mvc.truth();
            prop_assert!(truth.depth_m >= 0.0 && truth.altitude_m > 1.0 && truth.speed_mps.abs() <= 2.5, "{truth:?}");
            prop_assert!(truth.local.distance_m(backseat_units::EastNorth::default()) < 1000.0, "{truth:?}");
            let navigation = payload.heard().iter().filter(|line| line.starts_with("$BFNVG")).count();
            prop_assert_eq!(navigation, 10);
        }
        let log = payload.log();
        prop_assert!(!log.iter().any(|line| line.contains("could not be encoded")), "{log:?}");
    }
}
