//! It is unknown what the vehicle flies: the link was lost during a leg, or the process that knew was killed. No
//! vehicle reports its current behavior to a client that connects later (SPI 6.9), so the runtime must recognise it by
//! the line that the vehicle keeps to.

use backseat_core::plugin::{Request, RequestState};
use backseat_core::{Grant, Note};
use backseat_pair::{Dive, Setup, course_plugin, line, modify};

/// A client that connects later is told who has control, but not the current behavior.
const REPLAYS: &str = "[interpretation]\ncontrol_replay = true\n";

fn under_way() -> Dive {
    let mut dive = Dive::under_way(Setup {
        world: REPLAYS.to_owned(),
        replaced: vec![("kind = \"waypoint\"", "kind = \"waypoint\"\ndynamic = true")],
        plugin: course_plugin(&[Grant::Modify, Grant::Insert, Grant::Interrupt], &[]),
        ..Setup::default()
    });
    dive.run_for(30.0);
    dive
}

/// The plugin keeps requesting a modify to the north-east. Returns after how many seconds it steers; 400 s are too
/// many.
fn steers_after_s(dive: &mut Dive) -> Option<f64> {
    let asked = dive.now;
    for tag in 100..900 {
        dive.ask(Request::Modify(modify(tag, 45.0, 60)));
        dive.run_for(0.5);
        if dive.core.is_steering() {
            return Some(dive.now.since(asked).as_secs_f64());
        }
    }
    None
}

fn rejection(dive: &Dive, tag: u64) -> String {
    let of_tag = |(_, note): &(_, Note)| {
        let Note::Request(transition) = note else { return None };
        let RequestState::Rejected(refusal) = &transition.state else {
            return None;
        };
        (transition.tag == tag).then(|| refusal.to_string())
    };
    dive.notes.iter().find_map(of_tag).unwrap_or_default()
}

fn lost(dive: &mut Dive, killed: bool) {
    if killed {
        dive.kill(0);
    } else {
        dive.cut();
    }
}

/// On its line it takes ten seconds and the time to connect; away from its line, the vehicle first returns to it.
#[test]
fn sr_002_over_a_lost_link_or_a_killed_process_it_steers_again_once_the_line_is_seen() {
    for killed in [false, true] {
        for (led, within_s) in [(false, 10.5..20.0), (true, 20.0..90.0)] {
            let mut dive = under_way();
            if led {
                dive.ask(Request::Modify(modify(1, 45.0, 60)));
                dive.run_for(20.0);
                assert!(dive.core.is_steering());
            }
            lost(&mut dive, killed);
            let after_s = steers_after_s(&mut dive).expect("it is seen by then");
            println!("killed: {killed}, led away: {led}: {after_s} s");
            assert!(within_s.contains(&after_s), "{killed} {led}: {after_s} s");
        }
    }
}

#[test]
fn sr_002_an_insert_waits_until_a_begin_is_heard() {
    for killed in [false, true] {
        let mut dive = under_way();
        lost(&mut dive, killed);
        steers_after_s(&mut dive).expect("it is seen by then");
        // What was seen is enough for a modify, but not for an insert.
        let ask = |dive: &mut Dive, tag, interrupt| {
            dive.ask(Request::Trackline(line(tag, (0.0, 200.0), (200.0, 200.0), interrupt)));
            dive.run_for(3.0);
            dive.states(tag).last().copied()
        };
        for (tag, interrupt) in [(2, false), (3, true)] {
            assert_eq!(ask(&mut dive, tag, interrupt), Some("rejected"));
            assert!(
                rejection(&dive, tag).contains("current behavior unknown"),
                "{}",
                rejection(&dive, tag)
            );
        }
        let begins = |dive: &Dive| {
            let begun = |(_, note): &&(_, Note)| matches!(note, Note::Behavior { began: true, .. });
            dive.notes.iter().filter(begun).count()
        };
        let before = begins(&dive);
        assert!(
            dive.run_until(1500.0, |dive| begins(dive) > before),
            "the next leg begins"
        );
        assert_eq!(ask(&mut dive, 4, false), Some("accepted"), "{}", rejection(&dive, 4));
    }
}

/// On a heading without a line there is nothing to recognise it by.
#[test]
fn sr_002_who_keeps_to_no_line_of_the_plan_is_not_steered() {
    let mut dive = Dive::under_way(Setup {
        world: REPLAYS.to_owned(),
        replaced: vec![(
            "kind = \"trackline\"\nstart = { east_m = -600, north_m = 0 }\nend = { east_m = 600, north_m = 0 }\n",
            "kind = \"setpoint\"\nheading_deg = 70\nduration_s = 700\n",
        )],
        plugin: course_plugin(&[Grant::Modify], &[]),
        ..Setup::default()
    });
    dive.ask(Request::Modify(modify(1, 45.0, 5)));
    dive.run_for(30.0);
    assert!(dive.states(1).contains(&"accepted"), "{:?}", dive.states(1));
    lost(&mut dive, true);
    assert_eq!(steers_after_s(&mut dive), None);
    assert!(
        rejection(&dive, 899).contains("followed a line"),
        "{}",
        rejection(&dive, 899)
    );
}
