//! Two dives in one process of the vehicle, each with its own dive file and plan: the runtime steers in the second by
//! the second's plan alone (SR-025).

use backseat_core::Note;
use backseat_core::plugin::Request;
use backseat_mvc::Status;
use backseat_pair::{Dive, Setup, line, modify};
use backseat_units::Timestamp;

/// The first dive flies the course. The operator ends it after a minute, and half a minute later the second starts, with
/// a line 150 m further to the north.
const TWO: &str = "
[[dive]]
file = \"first.dive\"
load_after_s = 0
start_after_s = 1
end_after_s = 60
[[dive]]
file = \"second.dive\"
load_after_s = 20
start_after_s = 10
[[dive.plan]]
kind = \"trackline\"
start = { east_m = -450, north_m = 150 }
end = { east_m = 600, north_m = 150 }
depth_m = 20
speed_mps = 1.5
dynamic = true
";

fn setup() -> Setup {
    Setup {
        world: TWO.to_owned(),
        ..Setup::default()
    }
}

/// The status that core has heard, if it is that.
fn status((_, note): &(Timestamp, Note)) -> Option<&str> {
    let Note::Mission { status } = note else { return None };
    Some(status.as_str())
}

fn statuses(dive: &Dive) -> Vec<&str> {
    dive.notes.iter().filter_map(status).collect()
}

fn second_runs(dive: &Dive) -> bool {
    dive.mvc.mission_status() == Status::Running && dive.now.as_secs_f64() > 70.0
}

#[test]
fn sr_025_core_steers_in_the_second_dive_after_it_has_asked_for_its_plan() {
    let mut dive = Dive::under_way(setup());
    dive.ask(Request::Modify(modify(1, 90.0, 60)));
    dive.run_for(20.0);
    assert!(dive.core.is_steering());
    let plans = dive.count("$BPRMP");
    // The first dive ends, and with it the lease.
    assert!(dive.run_until(60.0, |dive| dive.mvc.mission_status() == Status::Completed));
    dive.run_for(1.0);
    assert!(!dive.core.is_steering() && !dive.core.has_control());
    let sent = dive.count("$BPRMB");
    dive.ask(Request::Modify(modify(2, 45.0, 60)));
    assert!(dive.run_until(60.0, second_runs));
    assert_eq!(dive.count("$BPRMB"), sent, "{:?}", dive.sent);
    assert_eq!(dive.states(2), ["rejected"]);
    // The second dive's plan is asked for, and comes whole.
    dive.run_for(5.0);
    assert!(dive.count("$BPRMP") > plans, "{:?}", dive.sent);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    dive.ask(Request::Modify(modify(3, 0.0, 60)));
    dive.ask(Request::Trackline(line(4, (-300.0, 250.0), (-200.0, 250.0), false)));
    dive.run_for(25.0);
    assert_eq!(dive.states(3), ["sent", "accepted"]);
    assert!(dive.core.is_steering());
    let heading_deg = dive.mvc.truth().heading_deg;
    assert!(!(10.0..350.0).contains(&heading_deg), "{heading_deg}");
    assert_eq!(dive.states(4), ["sent", "pending", "accepted"]);
    assert_eq!(
        statuses(&dive),
        [
            "Ready",
            "Running /logs/survey",
            "Completed",
            "Ready",
            "Running /logs/survey"
        ]
    );
}

#[test]
fn sr_025_without_the_second_dive_s_plan_nothing_steers_in_it() {
    let mut dive = Dive::under_way(setup());
    assert!(dive.run_until(80.0, |dive| dive.mvc.mission_status() == Status::Completed));
    dive.unheard.push("$BFPLN");
    assert!(dive.run_until(60.0, second_runs));
    dive.run_for(5.0);
    dive.ask(Request::Modify(modify(3, 0.0, 60)));
    dive.run_for(20.0);
    assert_eq!(dive.count("$BPRMB"), 0, "{:?}", dive.sent);
    assert_eq!(dive.states(3), ["rejected"]);
    dive.unheard.clear();
    assert!(
        dive.run_until(60.0, |dive| dive.core.has_control()),
        "{:#?}",
        dive.notes
    );
}

#[test]
fn sr_025_nothing_steers_under_a_dive_that_cannot_start() {
    let mut dive = Dive::new(Setup {
        world: TWO.replace("start_after_s = 1\nend_after_s = 60\n", "invalid = \"wrapup\"\n"),
        ..Setup::default()
    });
    dive.run_for(15.0);
    assert_eq!(statuses(&dive), ["Invalid Wrapup File"]);
    dive.ask(Request::Modify(modify(1, 0.0, 60)));
    dive.run_for(2.0);
    assert_eq!(dive.states(1), ["rejected"]);
    assert!(
        dive.run_until(60.0, |dive| dive.core.has_control()),
        "{:#?}",
        dive.notes
    );
    // Until the plan of the dive that runs is known.
    dive.run_for(5.0);
    dive.ask(Request::Modify(modify(2, 0.0, 60)));
    dive.run_for(2.0);
    assert_eq!(dive.states(2), ["sent", "accepted"], "{:#?}", dive.notes);
}
