use backseat_core::plugin::Request;
use backseat_core::{Grant, Note, Recovery, Settings};
use backseat_pair::{Dive, Setup, course_plugin, line, modify};

/// Half a minute after the start navigation reports for a minute that the vehicle is far north of the box.
const JUMP: &str = "
[[faults.fault]]
at_s = 30
for_s = 60
kind = \"navigation_jump\"
east_m = 0
north_m = 2100
";

fn setup(recovery: Recovery) -> Setup {
    Setup {
        world: JUMP.to_owned(),
        settings: Settings {
            recovery,
            ..Settings::default()
        },
        plugin: course_plugin(&[Grant::Modify, Grant::Insert, Grant::Interrupt], &[]),
        ..Setup::default()
    }
}

fn said(dive: &Dive, what: &str) -> bool {
    let said = |note: &Note| matches!(note, Note::Recovery { text } if text.contains(what));
    dive.notes.iter().any(|(_, note)| said(note))
}

fn logged(dive: &Dive, what: &str) -> bool {
    dive.log.iter().any(|event| event.to_string().contains(what))
}

#[test]
fn sr_020_a_vehicle_that_is_outside_loses_the_lease_and_what_waits_and_gets_its_own_way_back() {
    let mut dive = Dive::under_way(setup(Recovery::default()));
    dive.ask(Request::Trackline(line(1, (0.0, 200.0), (200.0, 200.0), false)));
    dive.ask(Request::Modify(modify(2, 45.0, 60)));
    dive.run_for(20.0);
    assert!(dive.core.is_steering());
    assert_eq!(dive.states(1).last(), Some(&"accepted"));
    assert!(
        dive.run_until(30.0, |dive| said(dive, "leases end")),
        "{:#?}",
        dive.notes
    );
    assert!(!dive.core.is_steering());
    assert!(dive.run_until(10.0, |dive| dive.states(1).last() == Some(&"cancelled")));
    assert!(dive.run_until(20.0, |dive| said(dive, "the topside is told")));
    dive.run_for(15.0);
    assert_eq!(dive.count("$BPTOP"), 1);
    assert_eq!(dive.count("$BPABT"), 0);
    // The vehicle has understood all of it.
    assert_eq!(dive.count("$BPRCN"), 1);
    dive.run_for(90.0);
    assert!(said(&dive, "inside the fence again"), "{:#?}", dive.notes);
    dive.ask(Request::Modify(modify(3, 90.0, 10)));
    dive.run_for(3.0);
    assert_eq!(dive.states(3), ["sent", "accepted"]);
}

#[test]
fn sr_012_sr_020_the_mission_is_aborted_where_the_operators_table_says_so() {
    let mut dive = Dive::under_way(setup(Recovery {
        abort_after_s: Some(15.0),
        ..Recovery::default()
    }));
    dive.ask(Request::Modify(modify(2, 45.0, 60)));
    dive.run_for(60.0);
    assert!(said(&dive, "the mission is aborted"), "{:#?}", dive.notes);
    assert_eq!(dive.count("$BPABT"), 1);
    assert!(logged(&dive, "abort"), "{:#?}", dive.log);
}
