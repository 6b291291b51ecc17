//! Hovering vehicles: the suspension and its 2 s (SPI 8.1 to 8.3), and an answer to each of their commands.

use backseat_mvc::{Activity, ClientId, HoveringTruth};
use backseat_units::Timestamp;

use crate::files::CALM;
use crate::payload::{ME, Payload};

/// Calm water with a ship: its bow points east, its starboard side is south, and the plan has a line along it. The
/// vehicle starts 7 m off that side, amidships, and faces it: x is north, y is east.
pub(crate) const HARBOUR: &str = r#"
[start]
utc = 2026-06-01T08:00:00Z
north_m = -12
depth_m = 3
[origin]
latitude_deg = 42.3
longitude_deg = -70.9
[seabed]
depth_m = 15
slope = 0
meanders = 0
[vehicle]
class = "hovering"
altitude_min_m = 1
[hovering]
drift_m_per_sqrt_h = 0
bearing_drift_deg_per_sqrt_h = 0
position_noise_m = 0
range_noise_m = 0
[hovering.hull]
east_m = 0
north_m = 0
heading_deg = 90
length_m = 60
beam_m = 10
draft_m = 5
[mission]
starts_after_s = 1
[spi]
acknowledge = "immediate"
[[plan]]
kind = "trackline"
start = { east_m = 0, north_m = -12 }
end = { east_m = 25, north_m = -12 }
depth_m = 3
speed_mps = 0.5
dynamic = true
[[plan]]
kind = "setpoint"
heading_deg = 0
duration_s = 20
depth_m = 3
speed_mps = 0
"#;

/// The same world with a single setpoint of 20 s, which allows dynamic requests from 5 s to 15 s.
fn station() -> String {
    let plan = HARBOUR.find("[[plan]]").expect("a file has a plan");
    format!(
        "{}[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 20\ndepth_m = 3\nspeed_mps = 0\ndynamic = \
         true\ndynamic_from_s = 5\ndynamic_for_s = 10\n",
        &HARBOUR[..plan]
    )
}

pub(crate) fn hovering(payload: &Payload) -> HoveringTruth {
    payload.mvc.hovering_truth().expect("the vehicle hovers")
}

fn suspended(payload: &Payload) -> bool {
    let suspended = payload.mvc.truth().activity == Activity::Suspended;
    assert_eq!(suspended, hovering(payload).suspended_until.is_some());
    suspended
}

/// Sends this sentence every second until then, so that the suspension lasts.
pub(crate) fn keep(payload: &mut Payload, until_s: f64, sentence: &str) {
    let mut now_s = payload.now.as_secs_f64();
    while now_s < until_s {
        payload.say(sentence);
        now_s = (now_s + 1.0).min(until_s);
        payload.until(now_s);
    }
}

fn at_ms(payload: &mut Payload, millis: u64) {
    payload.until(millis as f64 / 1000.0);
    payload.now = Timestamp::from_millis(millis);
}

/// Each sentence and the answer to it, five seconds into the mission.
const TABLE: &[(&str, &str)] = &[
    // 8.2, 8.3, 8.6, 8.7 without a suspension.
    ("$BPCON,070000.000", "CON,070000.000,0,1,0,no mission is suspended"),
    ("$BPRES,070000.000", "RES,070000.000,0,1,0,no mission is suspended"),
    (
        "$BPGHP,070000.000,1,2,3",
        "GHP,070000.000,0,1,0,ignored: no mission is suspended",
    ),
    (
        "$BPGBP,070000.000,1,2,D,3",
        "GBP,070000.000,0,1,0,ignored: no mission is suspended",
    ),
    // 8.1; a second one only restarts the time.
    ("$BPSUS,070000.000", "SUS,070000.000,0,2,0,"),
    ("$BPSUS,070000.001", "SUS,070000.001,0,2,0,"),
    ("$BPSUS,now", "SUS,000000.000,0,0,0,"),
    ("$BPCON,070000.000", "CON,070000.000,0,2,0,"),
    ("$BPGHP,070000.000,2,2,3", "GHP,070000.000,0,2,0,"),
    (
        "$BPGHP,070000.000,2,2,0.4",
        "GHP,070000.000,0,1,0,the distance must be 0.5 to 1000 m",
    ),
    (
        "$BPGHP,070000.000,2,-1,3",
        "GHP,070000.000,0,1,0,the depth must be 0 to 60 m",
    ),
    (
        "$BPGHP,070000.000,2000,2,3",
        "GHP,070000.000,0,1,0,the place is over 1000 m from the relative origin",
    ),
    ("$BPGHP,070000.000,2,2", "GHP,070000.000,0,0,0,"),
    ("$BPGBP,070000.000,-8,2,D,4", "GBP,070000.000,0,2,0,"),
    ("$BPGBP,070000.000,-8,2,A,4", "GBP,070000.000,0,2,0,"),
    (
        "$BPGBP,070000.000,-8,2,D,99",
        "GBP,070000.000,0,1,0,the depth must be 0 to 60 m",
    ),
    (
        "$BPGBP,070000.000,-8,2,A,0.5",
        "GBP,070000.000,0,1,0,the altitude must be 1 to 1000 m",
    ),
    (
        "$BPGBP,070000.000,-8,-1001,D,4",
        "GBP,070000.000,0,1,0,the place is over 1000 m from the relative origin",
    ),
    ("$BPGBP,070000.000,-8,2,X,4", "GBP,070000.000,0,0,0,"),
    // 8.4
    ("$BPSPD,070000.000,0.5", "SPD,070000.000,0,2,0,"),
    (
        "$BPSPD,070000.000,0",
        "SPD,070000.000,0,0,0,speed_mps 0: expected more than 0",
    ),
    ("$BPSPD,070000.000,slow", "SPD,070000.000,0,0,0,"),
    // 8.5
    ("$BPSAN,070000.000,-30", "SAN,070000.000,0,2,0,"),
    (
        "$BPSAN,070000.000,91",
        "SAN,070000.000,0,1,0,the sonar turns from -90 to 90 degrees",
    ),
    // 8.8, 8.9
    ("$BPRNS,070000.000,-7,0,0", "RNS,070000.000,0,2,0,"),
    (
        "$BPRNS,070000.000,-7,0,400",
        "RNS,070000.000,0,0,0,bearing_deg 400: expected -360 to 360",
    ),
    (
        "$BPRNS,070000.000,-7000,0,0",
        "RNS,070000.000,0,1,0,the place is over 1000 m from the relative origin",
    ),
    ("$BPRBO,070000.000,-2.5", "RBO,070000.000,0,2,0,"),
    (
        "$BPRBO,070000.000,361",
        "RBO,070000.000,0,0,0,offset_deg 361: expected -360 to 360",
    ),
    // 8.10, 8.11
    ("$BPPTZ,070000.000,-9,0,9", "PTZ,070000.000,0,2,0,"),
    ("$BPPTZ,070000.000,-10,0,9", "PTZ,070000.000,0,0,0,"),
    ("$BPLIT,070000.000,0,1", "LIT,070000.000,0,2,0,"),
    ("$BPLIT,070000.000,0,2", "LIT,070000.000,0,0,0,"),
    // 8.3
    ("$BPRES,070000.000", "RES,070000.000,0,2,0,"),
    ("$BPRES,070000.001", "RES,070000.001,0,1,0,no mission is suspended"),
];

#[test]
fn each_command_has_its_answer() {
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    payload.until(6.0);
    for (said, answer) in TABLE {
        payload.say(said);
        let heard = payload.heard();
        let expected = format!("$BFACK,080006.000,{answer}");
        // The answer to a sentence that does not parse also names its field.
        let rest = if answer.ends_with(",0,0,0,") { 1 } else { 0 };
        assert!(
            heard.len() == 1 && heard[0].starts_with(&expected) && heard[0].len() >= expected.len() + rest,
            "{said}: {heard:?}"
        );
        assert!(rest > 0 || heard[0] == expected, "{said}: {heard:?}");
    }
    assert!(hovering(&payload).light_on);
}

#[test]
fn vehicles_that_do_not_hover_refuse_the_commands_of_those_that_do() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(5.0);
    for (said, _) in TABLE.iter().filter(|(_, answer)| !answer.ends_with(",0,0,0,")) {
        payload.say(said);
        let name = &said[3..6];
        let heard = payload.heard();
        assert!(
            heard.len() == 1
                && heard[0].contains(&format!(",{name},07"))
                && heard[0].ends_with(",0,1,0,this vehicle does not hover"),
            "{said}: {heard:?}"
        );
    }
    assert_eq!(payload.mvc.hovering_truth(), None);
}

#[test]
fn cameras_and_lights_must_be_installed() {
    let text = HARBOUR.replace("[hovering]", "[hovering]\ncamera = false\nlight = false");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.say("$BPPTZ,070000.000,1,0,0");
    payload.say("$BPLIT,070000.000,0,1");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080000.000,PTZ,070000.000,0,1,0,no camera is installed",
            "$BFACK,080000.000,LIT,070000.000,0,1,0,no light is installed",
        ]
    );
    assert!(!hovering(&payload).light_on);
}

#[test]
fn a_suspension_lapses_exactly_two_seconds_after_the_last_refresh() {
    // SPI 8.1, 8.2, 8.6, 8.7: each of the four commands restarts the 2 s, even if its target is refused. The first 8.1
    // starts them.
    for (keeps, said) in [
        (true, "$BPSUS,070000.000"),
        (true, "$BPCON,070000.000"),
        (true, "$BPGHP,070000.000,1,3,4"),
        (true, "$BPGHP,070000.000,1,3,0.1"),
        (true, "$BPGBP,070000.000,-8,1,D,3"),
        (true, "$BPGBP,070000.000,-8,1,D,99"),
        (false, "$BPSPD,070000.000,0.5"),
        (false, "$BPSAN,070000.000,10"),
        (false, "$BPRNS,070000.000,-7,0,0"),
        (false, "$BPLOG,NVG,ON"),
        (false, "$BPGHP,070000.000,1,3"),
    ] {
        let mut payload = Payload::connected(HARBOUR, 1, &[]);
        at_ms(&mut payload, 5003);
        payload.say("$BPSUS,070000.000");
        // This is the last millisecond.
        at_ms(&mut payload, 7002);
        assert!(suspended(&payload), "{said}");
        payload.say(said);
        let lapses = if keeps { 9002 } else { 7003 };
        assert_eq!(
            payload.mvc.hovering_truth().and_then(|truth| truth.suspended_until),
            Some(Timestamp::from_millis(lapses))
        );
        at_ms(&mut payload, lapses - 1);
        assert!(suspended(&payload), "{said}");
        at_ms(&mut payload, lapses);
        assert!(!suspended(&payload), "{said}");
        let line = format!(
            "{}.{:03} s: suspension ended: 2 s without a refresh",
            lapses / 1000,
            lapses % 1000
        );
        assert!(payload.log().contains(&line), "{said}");
    }
}

#[test]
fn a_refresh_at_the_end_of_the_two_seconds_is_too_late() {
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    at_ms(&mut payload, 5003);
    payload.say("$BPSUS,070000.000");
    payload.heard();
    // The driver woke late: it handled no timeout before.
    payload.now = Timestamp::from_millis(7003);
    payload.say("$BPCON,070000.000");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080007.003,CON,070000.000,0,1,0,no mission is suspended"]
    );
    assert!(
        payload
            .log()
            .contains(&"7.003 s: suspension ended: 2 s without a refresh".to_owned())
    );
}

#[test]
fn after_a_lost_link_the_mission_goes_on_within_two_seconds() {
    let mut payload = Payload::connected(HARBOUR, 1, &[]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    payload.mvc.disconnect(payload.now, ME);
    payload.until(7.999);
    assert!(suspended(&payload));
    payload.until(8.0);
    assert!(!suspended(&payload));
    payload.until(120.0);
    assert!(payload.mvc.mission_over(), "{:?}", payload.mvc.truth());
}

#[test]
fn any_client_can_refresh_and_end_a_suspension() {
    let mut payload = Payload::connected(HARBOUR, 1, &[]);
    payload.connect(ClientId(2));
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    payload.until(7.5);
    payload.say_as(ClientId(2), "$BPCON,070000.000");
    payload.until(9.0);
    assert!(suspended(&payload));
    payload.say_as(ClientId(2), "$BPRES,070000.000");
    assert!(!suspended(&payload));
}

#[test]
fn only_a_running_mission_can_be_suspended() {
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    payload.until(0.5);
    payload.say("$BPSUS,070000.000");
    payload.until(150.0);
    assert!(payload.mvc.mission_over());
    payload.say("$BPSUS,070000.001");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080000.500,SUS,070000.000,0,1,0,no mission is running",
            "$BFACK,080230.000,SUS,070000.001,0,1,0,no mission is running",
        ]
    );
}

#[test]
fn whether_a_suspension_needs_control_is_a_setting() {
    for needs in [false, true] {
        let text = format!("{}\n[interpretation]\nsuspend_needs_control = {needs}", station());
        let mut payload = Payload::connected(&text, 1, &["ACK", "CTL"]);
        // Dynamic requests are allowed from 6 s to 16 s.
        payload.until(3.0);
        payload.say("$BPSUS,070000.000");
        assert_eq!(suspended(&payload), !needs);
        let answer = if needs {
            "1,0,dynamic requests are not allowed now"
        } else {
            "2,0,"
        };
        assert_eq!(
            payload.heard(),
            [format!("$BFACK,080003.000,SUS,070000.000,0,{answer}")]
        );
    }
}

#[test]
fn the_missions_time_and_the_window_for_requests_stand_still_during_a_suspension() {
    let mut payload = Payload::connected(&station(), 1, &["CTL", "MIS"]);
    payload.until(10.0);
    // The suspension lasts ten seconds, and 2 s until it lapses: everything else comes 12 s later. The mission began at
    // 1 s.
    keep(&mut payload, 20.0, "$BPSUS,070000.000");
    payload.say("$BPSUS,070000.000");
    payload.until(60.0);
    let heard = payload.heard();
    let times: Vec<(&str, &str)> = heard
        .iter()
        .filter_map(|line| {
            let mut fields = line.split(',');
            Some((fields.next()?, fields.next()?))
        })
        .collect();
    assert_eq!(
        times,
        [
            ("$BFMIS", "080001.000"),
            ("$BFCTL", "080006.000"),
            ("$BFCTL", "080028.000"),
            ("$BFMIS", "080033.000"),
        ],
        "{heard:?}"
    );
}

#[test]
fn a_modify_is_refused_during_a_suspension_and_the_five_seconds_of_an_earlier_one_go_on() {
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    payload.until(10.0);
    payload.say("$BPRMB,070000.000,90,3,0,0.5,1,0");
    payload.until(11.0);
    payload.heard();
    payload.say("$BPSUS,070000.000");
    payload.say("$BPRMB,070000.000,0,3,0,0.5,1,0");
    assert!(
        payload
            .heard()
            .contains(&"$BFACK,080011.000,RMB,070000.000,0,1,0,the mission is suspended".to_owned())
    );
    keep(&mut payload, 16.0, "$BPCON,070000.000");
    assert!(suspended(&payload));
    assert!(
        payload
            .log()
            .contains(&"15.000 s: modify ended: 5 s without a refresh".to_owned())
    );
}

#[test]
fn an_insert_during_a_suspension_is_flown_afterwards() {
    // Also one that interrupts: the payload has the vehicle until it gives it back.
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    payload.until(10.0);
    payload.say("$BPSUS,070000.000");
    payload.say("$BPRTK,070000.000,7,4218.0,N,07054.0,W,4217.99,N,07054.0,W,0,3,0.5,0,4");
    assert!(payload.heard().iter().any(|line| line.contains(",RTK,070000.000,7,2,")));
    keep(&mut payload, 15.0, "$BPCON,070000.000");
    assert!(suspended(&payload));
    payload.say("$BPRES,070000.000");
    // The insert began during the suspension, so there is no place to return to.
    assert!(
        matches!(payload.mvc.truth().activity, Activity::Insert { id } if id.get() == 7),
        "{:?}",
        payload.mvc.truth()
    );
    assert!(!payload.log().iter().any(|line| line.contains("back to where")));
}

#[test]
fn the_end_of_the_mission_ends_the_suspension() {
    let text = HARBOUR.replace("[mission]", "[mission]\ntime_limit_s = 10");
    let mut payload = Payload::connected(&text, 1, &["MIS", "ACK"]);
    payload.until(9.0);
    keep(&mut payload, 11.5, "$BPSUS,070000.000");
    assert!(!suspended(&payload));
    assert_eq!(payload.mvc.truth().activity, Activity::Stopped);
    assert!(
        payload
            .log()
            .contains(&"11.000 s: suspension ended: the mission ended".to_owned())
    );
    payload.say("$BPCON,070000.000");
    let heard = payload.heard();
    assert!(heard.last().is_some_and(|line| line.contains(",CON,070000.000,0,1,0,")));
}

#[test]
fn the_mission_goes_on_from_where_it_was_suspended_or_from_where_the_vehicle_is() {
    // SPI 8.3: depending on the behavior. By default a line returns, and a setpoint does not.
    let line = HARBOUR.to_owned();
    for (text, setting, returns) in [
        (line.clone(), "behavior", true),
        (line.clone(), "return", true),
        (line, "here", false),
        (station(), "behavior", false),
        (station(), "return", true),
    ] {
        let text = format!("{text}\n[interpretation]\nafter_suspension = \"{setting}\"");
        let mut payload = Payload::connected(&text, 1, &[]);
        payload.until(12.0);
        let left = payload.mvc.truth().local;
        payload.say("$BPSUS,070000.000");
        keep(&mut payload, 80.0, "$BPGBP,070000.000,-20,-3,D,4");
        let away = payload.mvc.truth().local.distance_m(left);
        assert!(away > 10.0, "{setting}: {away}");
        payload.say("$BPRES,070000.000");
        assert!(!suspended(&payload));
        let mut nearest = f64::INFINITY;
        for tenths in 801..1600 {
            payload.until(f64::from(tenths) / 10.0);
            nearest = nearest.min(payload.mvc.truth().local.distance_m(left));
        }
        assert_eq!(nearest < 1.5, returns, "{setting}: {nearest}");
        let says = payload
            .log()
            .iter()
            .any(|line| line.ends_with("the vehicle is back where the mission was suspended: the mission goes on"));
        assert_eq!(says, returns, "{setting}");
    }
}
