use backseat_mvc::Activity;

use crate::files::{CALM, LIVELY};
use crate::payload::{ME, Payload};

#[test]
fn a_payload_receives_each_transition_of_a_mission_from_ready_to_completed() {
    let mut payload = Payload::connected(CALM, 1, &["CTL", "MIS", "MBS", "MBE"]);
    assert_eq!(payload.mvc.truth().activity, Activity::Waiting);
    payload.until(0.9);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.until(600.0);
    let heard: Vec<String> = payload
        .heard()
        .iter()
        .map(|line| line.replacen(&line[7..17], "T", 1))
        .collect();
    assert_eq!(
        heard,
        [
            "$BFMIS,T,survey.dive,Running /logs/survey,",
            "$BFMBS,T,survey.dive,1,,trackline",
            "$BFCTL,T,1",
            "$BFMBE,T,survey.dive,1,,trackline",
            "$BFMBS,T,survey.dive,2,,waypoint",
            "$BFCTL,T,0",
            "$BFMBE,T,survey.dive,2,,waypoint",
            "$BFMIS,T,survey.dive,Completed,",
        ]
    );
    assert!(payload.mvc.mission_over());
    assert_eq!(payload.mvc.truth().activity, Activity::Stopped);
}

#[test]
fn the_time_limit_aborts_the_mission_and_control_ends_with_it() {
    let text = CALM.replace("[mission]", "[mission]\ntime_limit_s = 60");
    let mut payload = Payload::connected(&text, 1, &["CTL", "MIS"]);
    payload.until(120.0);
    let heard = payload.heard();
    assert_eq!(
        heard[2..],
        [
            "$BFCTL,080101.000,0",
            "$BFMIS,080101.000,survey.dive,Aborted,time limit"
        ]
    );
}

#[test]
fn control_stays_between_two_dynamic_elements() {
    let text = CALM.replace("kind = \"waypoint\"", "kind = \"waypoint\"\ndynamic = true");
    let mut payload = Payload::connected(&text, 1, &["CTL"]);
    payload.until(600.0);
    let heard = payload.heard();
    assert_eq!(heard.len(), 2, "{heard:?}");
    assert!(heard[0].ends_with(",1") && heard[1].ends_with(",0"));
}

#[test]
fn every_kind_of_element_is_flown_over_midnight_in_a_lively_sea() {
    let mut payload = Payload::connected(LIVELY, 3, &["NVG"]);
    assert!(payload.until_that(1500.0, |truth| truth.activity == Activity::WrappingUp));
    assert!(payload.until_that(1600.0, |truth| truth.activity == Activity::Stopped));
    let log = payload.log();
    for number in 1..=5 {
        let ended = log
            .iter()
            .any(|line| line.contains(&format!(" {number} of the plan ended: done")));
        assert!(ended, "{number} {log:#?}");
    }
    assert!(!log.iter().any(|line| line.contains("seabed")), "{log:#?}");
    let heard = payload.heard();
    let stamps: Vec<&str> = heard
        .iter()
        .filter(|line| line.starts_with("$BFNVG"))
        .map(|line| &line[7..17])
        .collect();
    let midnight = stamps
        .iter()
        .position(|stamp| *stamp == "000000.000")
        .expect("midnight passes");
    assert_eq!(
        (stamps[midnight - 1], stamps[midnight + 1]),
        ("235959.900", "000000.100")
    );
}

#[test]
fn a_window_within_an_element_gives_control_and_takes_it_back() {
    let text = CALM.replace(
        "dynamic = true",
        "dynamic = true\ndynamic_from_s = 20\ndynamic_for_s = 30",
    );
    let mut payload = Payload::connected(&text, 1, &["CTL"]);
    payload.until(100.0);
    assert_eq!(payload.heard(), ["$BFCTL,080021.000,1", "$BFCTL,080051.000,0"]);
}

#[test]
fn shutdown_is_announced_a_minute_before_the_power_goes() {
    let text = CALM.replace("[mission]", "[mission]\nshutdown_after_s = 100");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(99.9);
    assert_eq!(payload.heard(), ["$BFSHT,080040.000"]);
    assert!(payload.cut_off.is_empty());
    payload.until(101.0);
    assert_eq!(payload.cut_off, [ME]);
    payload.connect(ME);
    assert_eq!((payload.heard().len(), payload.cut_off.len()), (0, 2));
}
