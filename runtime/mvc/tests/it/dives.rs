use backseat_mvc::{DiveError, MvcError, Status, WorldFile};

use crate::files::CALM;
use crate::payload::{ME, Payload};

const TWO: &str = "
[[dive]]
file = \"first.dive\"
load_after_s = 1
start_after_s = 1
end_after_s = 30
[[dive]]
file = \"second.dive\"
load_after_s = 20
start_after_s = 10
[[dive.plan]]
kind = \"waypoint\"
at = { east_m = 50, north_m = 20 }
depth_m = 5
speed_mps = 2
";

#[test]
fn an_operator_is_told_why_a_command_about_dives_is_refused() {
    let text = format!("{CALM}{TWO}").replace("starts_after_s = 1\n", "online_after_s = 5\n");
    let mut payload = Payload::new(&text, 1);
    assert_eq!(payload.mvc.dives().collect::<Vec<_>>(), ["first.dive", "second.dive"]);
    let said = |result: Result<(), DiveError>| result.unwrap_err().to_string();
    let unknown = payload.operate(|mvc, now| mvc.load_dive(now, "third.dive"));
    assert_eq!(
        said(unknown),
        "no dive third.dive, expected one of first.dive, second.dive"
    );
    let offline = payload.operate(|mvc, now| mvc.load_dive(now, "first.dive"));
    assert_eq!(said(offline), "the vehicle is offline");
    let unready = payload.operate(|mvc, now| mvc.start_dive(now));
    assert_eq!(said(unready), "no dive is ready: the mission is Offline");
    let idle = payload.operate(|mvc, now| mvc.abort_dive(now));
    assert_eq!(said(idle), "no dive is running: the mission is Offline");
    payload.until(8.0);
    assert_eq!(payload.mvc.mission_status(), Status::Running);
    for running in [
        payload.operate(|mvc, now| mvc.load_dive(now, "second.dive")),
        payload.operate(|mvc, now| mvc.start_dive(now)),
    ] {
        assert_eq!(said(running), "a mission is running: end or abort it first");
    }
    payload.operate(|mvc, now| mvc.end_dive(now)).expect("it runs");
    let over = payload.operate(|mvc, now| mvc.end_dive(now));
    assert_eq!(said(over), "no dive is running: the mission is Completed");
}

#[test]
fn the_run_goes_on_until_the_last_dive_and_the_vehicle_drifts_in_between() {
    let mut payload = Payload::connected(&format!("{CALM}{TWO}[current]\nspeed_mps = 0.3\n"), 1, &[]);
    payload.until(1.5);
    let held = payload.mvc.truth().local;
    payload.until(1.9);
    assert_eq!(payload.mvc.truth().local, held, "before its first dive it is held");
    payload.until(35.0);
    assert_eq!(payload.mvc.mission_status(), Status::Completed);
    assert!(!payload.mvc.mission_over(), "another dive is waiting");
    payload.until(55.0);
    assert_eq!(payload.mvc.mission_status(), Status::Ready);
    let (before, depth_m) = (payload.mvc.truth().local, payload.mvc.truth().depth_m);
    payload.until(60.0);
    assert_eq!(payload.mvc.mission_status(), Status::Ready);
    let drifted_m = payload.mvc.truth().local.distance_m(before);
    assert!((1.0..2.0).contains(&drifted_m), "{drifted_m}");
    assert!(payload.mvc.truth().depth_m < depth_m, "it floats up");
    payload.until(300.0);
    assert!(payload.mvc.mission_over());
    assert_eq!(payload.mvc.mission_status(), Status::Completed);
    let log = payload.log();
    let dives: Vec<&String> = log.iter().filter(|line| line.contains("is loaded")).collect();
    assert_eq!(
        dives,
        [
            "1.000 s: dive first.dive is loaded",
            "52.100 s: dive second.dive is loaded"
        ]
    );
}

#[test]
fn an_operator_who_loads_the_next_dive_loads_it_once() {
    let mut payload = Payload::connected(&format!("{CALM}{TWO}"), 1, &["MIS"]);
    payload
        .operate(|mvc, now| mvc.load_dive(now, "first.dive"))
        .expect("it is free");
    payload.until(300.0);
    let heard = payload.heard();
    let running = |file: &str| {
        heard
            .iter()
            .filter(|line| line.contains(&format!(",{file},Running")))
            .count()
    };
    assert_eq!((running("first.dive"), running("second.dive")), (1, 1), "{heard:#?}");
    // One that is loaded out of its order comes in between.
    let mut payload = Payload::connected(&format!("{CALM}{TWO}"), 1, &["MIS"]);
    payload
        .operate(|mvc, now| mvc.load_dive(now, "second.dive"))
        .expect("it is free");
    payload.until(500.0);
    let heard = payload.heard();
    let running = |file: &str| {
        heard
            .iter()
            .filter(|line| line.contains(&format!(",{file},Running")))
            .count()
    };
    assert_eq!((running("first.dive"), running("second.dive")), (1, 2), "{heard:#?}");
}

/// The time until the next dive is loaded begins when the empty mission is over.
#[test]
fn an_empty_mission_comes_before_the_dive_that_waits() {
    let text = format!("{CALM}{TWO}").replace("starts_after_s = 1\n[", "empty_allowed = true\n[");
    let text = text.replace("load_after_s = 1\n", "load_after_s = 8\n");
    let mut payload = Payload::connected(&text, 1, &["MIS"]);
    payload.until(5.0);
    payload.say("$BPSEM,070000.000,20,2");
    payload.until(40.0);
    let heard = payload.heard();
    assert_eq!(
        heard[..3],
        [
            "$BFMIS,080005.000,,Running /logs/survey,",
            "$BFMIS,080025.000,,Aborted,time limit",
            "$BFMIS,080033.100,first.dive,Ready,",
        ],
        "{heard:#?}"
    );
}

#[test]
fn the_mission_s_own_dive_can_be_loaded_again_and_then_waits_for_its_start() {
    let mut payload = Payload::connected(CALM, 1, &["MIS"]);
    assert_eq!(payload.mvc.dives().collect::<Vec<_>>(), ["survey.dive"]);
    payload.until(5.0);
    payload.operate(|mvc, now| mvc.abort_dive(now)).expect("it runs");
    assert!(payload.mvc.mission_over());
    payload
        .operate(|mvc, now| mvc.load_dive(now, "survey.dive"))
        .expect("it is free");
    payload.until(60.0);
    assert_eq!(payload.mvc.mission_status(), Status::Ready);
    payload.operate(|mvc, now| mvc.start_dive(now)).expect("it is ready");
    payload.until(70.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFMIS,080001.000,survey.dive,Running /logs/survey,",
            "$BFMIS,080005.000,survey.dive,Aborted,aborted by the operator",
            "$BFMIS,080005.000,survey.dive,Ready,",
            "$BFMIS,080100.000,survey.dive,Running /logs/survey,",
        ]
    );
}

#[test]
fn the_commands_of_the_mission_come_in_each_dive() {
    let text = format!("{CALM}{TWO}").replace("[spi]", "[[mission.commands]]\nat_s = 3\ntext = \"begin\"\n[spi]");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(80.0);
    let commands: Vec<String> = payload
        .heard()
        .into_iter()
        .filter(|line| line.contains("BFMSC"))
        .collect();
    assert_eq!(commands.len(), 2, "{commands:?}");
}

#[test]
fn a_client_that_comes_between_two_dives_hears_of_the_second() {
    let mut payload = Payload::new(
        &format!("{CALM}{TWO}").replace("[spi]", "[spi]\nprofile = \"field\""),
        1,
    );
    payload.until(40.0);
    payload.connect(ME);
    payload.until(65.0);
    let heard = payload.heard();
    assert_eq!(
        heard
            .iter()
            .filter(|line| line.starts_with("$BFMIS"))
            .collect::<Vec<_>>(),
        [
            "$BFMIS,080052.100,second.dive,Ready,",
            "$BFMIS,080102.100,second.dive,Running /logs/survey,",
        ]
    );
}

#[test]
fn a_dive_that_is_not_possible_is_named_with_its_number() {
    let fault = |from: &str, to: &str| {
        let text = format!("{CALM}{TWO}");
        assert!(text.contains(from), "{from}");
        let text = text.replace(from, to);
        let file = WorldFile::from_toml(&text);
        file.and_then(|file| backseat_mvc::Mvc::new(&file, 1).map(drop))
            .map_err(|error: MvcError| error.to_string())
            .expect_err(to)
    };
    for (from, to, said) in [
        (
            "file = \"second.dive\"",
            "file = \"first.dive\"",
            "dive 1: dive.file is \"first.dive\", expected a name that no other dive has",
        ),
        (
            "file = \"second.dive\"",
            "file = \"\"",
            "dive 2: dive.file is \"\", expected a name",
        ),
        (
            "load_after_s = 20",
            "load_after_s = -1",
            "dive 2: dive.load_after_s is -1, expected 0 to 1e6 s",
        ),
        (
            "load_after_s = 20",
            "invalid = \"dive\"",
            "dive 2: dive.start_after_s is set, expected no such key, because an invalid dive never starts",
        ),
        (
            "end_after_s = 30",
            "end_after_s = 30\nabort_after_s = 30",
            "dive 1: dive.abort_after_s is set, expected no such key beside end_after_s",
        ),
        (
            "depth_m = 5\n",
            "depth_m = 70\n",
            "dive 2: plan element 1: the water is 60.00 m deep at 50 m east, 20 m north",
        ),
        (
            "starts_after_s = 1\n",
            "starts_after_s = 1\nonline_after_s = 90000\n",
            "mission.online_after_s is 90000, expected 0 to 86400 s",
        ),
    ] {
        let fault = fault(from, to);
        assert!(fault.starts_with(said), "{fault}");
    }
    let text = CALM.replace("starts_after_s = 1\n", "starts_after_s = 1\nonline_after_s = 3\n");
    let error = WorldFile::from_toml(&text).unwrap_err().to_string();
    assert_eq!(
        error,
        "mission.starts_after_s is 1, expected mission.online_after_s or more"
    );
    let text = CALM.replace("starts_after_s = 1\n", "starts_after_s = 8\nonline_after_s = 3\n");
    let mut payload = Payload::connected(&text, 1, &["MIS"]);
    payload.until(10.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFMIS,080003.000,,Waiting,",
            "$BFMIS,080003.000,survey.dive,Ready,",
            "$BFMIS,080008.000,survey.dive,Running /logs/survey,",
        ]
    );
}
