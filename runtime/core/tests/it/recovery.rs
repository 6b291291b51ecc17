use std::time::Duration;

use backseat_core::plugin::{Request, RequestState};
use backseat_core::{Grant, Limits, Note, Operator, Recovery, RequestKind, Settings};
use backseat_spi::{AckStatus, ToVehicle};
use backseat_units::{EastNorth, Timestamp};

use crate::course::{LIFTED, good_line, interrupting, limits, line, modify};
use crate::trial::{Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

fn ladder() -> Recovery {
    Recovery {
        outside_for_s: 1.0,
        cancel_after_s: 3.0,
        tell_after_s: 6.0,
        back_by_m: 5.0,
        back_for_s: 4.0,
        ..Recovery::default()
    }
}

fn setup(recovery: Recovery) -> Setup {
    Setup {
        settings: Settings {
            recovery,
            ..Settings::default()
        },
        limits: Limits {
            integrity: LIFTED,
            ..limits()
        },
        ..granted(&[Grant::Topside], &[])
    }
}

/// What recovery has reported, and when.
fn said(trial: &Trial) -> Vec<(Timestamp, String)> {
    let recovery = |(at, note)| match note {
        Note::Recovery { text } => Some((at, text)),
        _ => None,
    };
    trial.notes().into_iter().filter_map(recovery).collect()
}

fn said_of(trial: &Trial, what: &str) -> Timestamp {
    let said = said(trial);
    let mut named = said.iter().filter(|(_, text)| text.contains(what));
    let first = named.next().unwrap_or_else(|| panic!("{what}: {said:#?}"));
    assert_eq!(named.next(), None, "{what} is reported twice");
    first.0
}

/// The first insert flies and the second waits; then navigation puts the vehicle north of the box.
fn outside_with_inserts(setup: Setup) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    trial.ask(0, [interrupting(21), good_line(22)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(21)), ["sent", "accepted", "started"]);
    trial.vehicle.jump = EastNorth::new(0.0, 2100.0);
    trial
}

#[test]
fn sr_020_recovery_takes_each_step_at_its_time_and_reports_it_once() {
    let mut trial = outside_with_inserts(setup(Recovery {
        abort_after_s: Some(15.0),
        ..ladder()
    }));
    let left = trial.now;
    trial.run_for(20.0);
    let after = |at: Timestamp| at.since(left).as_secs_f64();
    let near = |at: Timestamp, seconds: f64| (seconds..seconds + 0.2).contains(&after(at));
    for (what, seconds) in [
        ("leases end", 1.0),
        ("inserts are cancelled", 3.0),
        ("the current insert continues", 3.0),
        ("the topside is told", 6.0),
        ("the mission is aborted", 15.0),
    ] {
        let at = said_of(&trial, what);
        assert!(near(at, seconds), "{what} after {} s", after(at));
    }
    assert!(
        said(&trial)[0].1.contains("outside keep-in zone 'box'"),
        "{:?}",
        said(&trial)[0]
    );
    let cancelled = trial.sent_since("RCN", left);
    assert!(cancelled.len() == 1 && near(cancelled[0], 3.0), "{cancelled:?}");
    assert_eq!(trial.states(22).last(), Some(&RequestState::Cancelled));
    let aborted = trial.sent_since("ABT", left);
    assert!(aborted.len() == 1 && near(aborted[0], 15.0), "{aborted:?}");
    let told: Vec<String> = ["MSG", "TOP"]
        .iter()
        .flat_map(|name| trial.commands(name))
        .filter(|(at, _)| near(*at, 6.0) || near(*at, 10.0))
        .map(|(_, command)| match command {
            ToVehicle::LogMessage(message) => message.text.as_str().to_owned(),
            ToVehicle::TopsideText(message) => message.text.as_str().to_owned(),
            other => panic!("{other:?}"),
        })
        .collect();
    // The vehicle's log has it at once; the topside has it once control is back, ten seconds after the jump. Both say
    // by how much and where: the box ends some 2000 m north, and navigation says some 2100 m.
    assert!(
        told.len() == 2 && told[1].starts_with("outside the fence by 1"),
        "{told:?}"
    );
    assert!(
        told[0].starts_with("outside the fence by 1") && told[0].contains("42.018"),
        "{told:?}"
    );
}

#[test]
fn sr_012_unless_configured_recovery_aborts_nothing_and_ends_no_flown_insert() {
    let mut trial = outside_with_inserts(setup(ladder()));
    trial.run_for(60.0);
    said_of(&trial, "the topside is told");
    for name in ["ABT", "KIL", "RCB", "RCA", "RCE"] {
        assert!(trial.commands(name).is_empty(), "{name}");
    }
}

#[test]
fn sr_020_a_configured_end_of_the_flown_insert_is_refused_without_a_good_way_on() {
    let allowed = || {
        setup(Recovery {
            cancel_current: true,
            ..ladder()
        })
    };
    let mut trial = outside_with_inserts(allowed());
    trial.run_for(20.0);
    // Navigation says that the vehicle is outside, and no way from there is good.
    assert!(trial.commands("RCB").is_empty());
    let refused = trial.notes().into_iter().any(|(_, note)| {
        matches!(note, Note::Request(transition) if transition.kind == RequestKind::CancelCurrent
            && matches!(transition.state, RequestState::Rejected(_)))
    });
    assert!(refused);
}

#[test]
fn sr_020_an_insert_whose_cancel_would_leave_a_worse_way_stays_and_the_next_step_follows_at_once() {
    let mut trial = Trial::with(setup(ladder()));
    trial.vehicle.moved = Some((3, EastNorth::new(-500.0, -1000.0)));
    trial.run_for(2.0);
    trial.ask(
        0,
        [
            interrupting(21),
            Request::Trackline(line(22, (800.0, -1300.0), (800.0, -1150.0))),
            Request::Trackline(line(23, (700.0, -900.0), (900.0, -900.0))),
        ],
    );
    trial.run_for(0.5);
    // The front seat goes on to its next waypoint. From the end of the second insert, the wreck bars the way to what
    // follows that waypoint.
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.2);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(21)), ["sent", "accepted", "started"]);
    // The vehicle is now outside without a jump of navigation: it is too near to the seabed.
    trial.vehicle.altitude_m = Some(1.0);
    trial.run_for(15.0);
    assert_eq!(shorts(&trial.states(22)), ["sent", "accepted", "cancelled"]);
    assert_eq!(
        shorts(&trial.states(23)),
        ["sent", "accepted"],
        "the way without it would be worse"
    );
    assert_eq!(trial.commands("RCN").len(), 1);
    let step = said_of(&trial, "inserts are cancelled");
    assert_eq!(said_of(&trial, "the way without it would be refused"), step);
    assert_eq!(said_of(&trial, "the topside is told"), step);
}

#[test]
fn no_request_is_accepted_until_the_vehicle_is_well_inside_for_long_enough() {
    let mut trial = outside_with_inserts(setup(ladder()));
    trial.run_for(1.5);
    trial.ask(1, [good_line(7)]);
    trial.run_for(0.3);
    // The jump of navigation has taken control, and the refusal names that first.
    assert!(trial.rejection(7).starts_with("control"), "{}", trial.rejection(7));
    trial.run_for(12.0);
    trial.ask(1, [good_line(8), Request::Modify(modify(9))]);
    trial.run_for(0.3);
    for tag in [8, 9] {
        assert!(
            trial.rejection(tag).starts_with("recovery: "),
            "{}",
            trial.rejection(tag)
        );
    }
    // The vehicle is back inside, but not by enough: the box ends some 1999 m north. After 10 m of margin and 5 m of
    // navigation error, 2 m of the 5 m in `back_by_m` are left.
    trial.vehicle.jump = EastNorth::new(0.0, 1982.0);
    trial.run_for(15.0);
    trial.ask(1, [good_line(10)]);
    trial.run_for(0.3);
    assert!(trial.rejection(10).starts_with("recovery: "), "{}", trial.rejection(10));
    trial.vehicle.jump = EastNorth::new(0.0, 1974.0);
    let back = trial.now;
    trial.run_for(6.0);
    let inside = said_of(&trial, "inside the fence again").since(back);
    assert!((4.0..4.3).contains(&inside.as_secs_f64()), "{inside:?}");
    trial.vehicle.jump = EastNorth::default();
    trial.run_for(12.0);
    trial.ask(1, [good_line(11)]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(11)), ["sent", "accepted"]);
}

#[test]
fn a_moment_outside_does_not_count_as_an_excursion() {
    let mut trial = outside_with_inserts(setup(ladder()));
    trial.run_for(0.8);
    trial.vehicle.jump = EastNorth::default();
    trial.run_for(20.0);
    assert!(said(&trial).is_empty(), "{:?}", said(&trial));
    assert!(trial.commands("RCN").is_empty());
}

#[test]
fn an_excursion_by_the_front_seat_itself_is_reported_once_and_causes_no_action() {
    let mut trial = Trial::with_under_way(setup(Recovery {
        abort_after_s: Some(9.0),
        ..ladder()
    }));
    // An insert that waits is not active.
    trial.ask(0, [good_line(1)]);
    trial.run_for(1.0);
    let before = trial.now;
    trial.vehicle.jump = EastNorth::new(0.0, 2100.0);
    trial.run_for(30.0);
    let said = said(&trial);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].1.contains("nothing of ours is active"), "{said:?}");
    for name in ["RCN", "TOP", "ABT", "EMB"] {
        assert!(trial.sent_since(name, before).is_empty(), "{name}");
    }
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
}

#[test]
fn an_excursion_just_after_a_lease_counts_as_caused_by_it() {
    let mut trial = Trial::with_under_way(setup(ladder()));
    trial.ask(0, [Request::Modify(modify(1)), good_line(2)]);
    trial.run_for(1.0);
    // The jump ends the lease before the excursion counts.
    trial.vehicle.jump = EastNorth::new(0.0, 2100.0);
    trial.run_for(15.0);
    said_of(&trial, "inserts are cancelled");
    assert_eq!(trial.states(2).last(), Some(&RequestState::Cancelled));
}

#[test]
fn too_deep_and_too_near_to_the_seabed_count_as_outside() {
    type Leave = fn(&mut Trial);
    let ways: [(&str, Leave); 2] = [
        ("deeper", |trial| trial.vehicle.depth_m = 64.0),
        ("altitude", |trial| trial.vehicle.altitude_m = Some(1.0)),
    ];
    for (what, leave) in ways {
        let mut trial = Trial::with_under_way(setup(ladder()));
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(1.0);
        leave(&mut trial);
        trial.run_for(3.0);
        let said = said(&trial);
        assert!(said[0].1.contains(what), "{said:?}");
        assert!(trial.core.has_control() && !trial.core.is_steering());
        trial.ask(0, [good_line(3)]);
        trial.run_for(0.3);
        assert!(trial.rejection(3).starts_with("recovery"), "{}", trial.rejection(3));
    }
}

#[test]
fn recovery_waits_while_the_link_is_lost_and_continues_when_it_is_back() {
    let mut trial = outside_with_inserts(setup(ladder()));
    trial.run_for(1.5);
    said_of(&trial, "leases end");
    trial.unreachable = true;
    trial.cut();
    trial.run_for(10.0);
    assert!(!said(&trial).iter().any(|(_, text)| text.contains("cancelled")));
    trial.unreachable = false;
    let back = trial.now;
    trial.run_for(30.0);
    assert!(said_of(&trial, "inserts are cancelled") > back);
    assert_eq!(trial.sent_since("RCN", back).len(), 1);
}

#[test]
fn the_runtimes_own_cancel_is_sent_five_times_at_most_if_it_is_not_answered() {
    let failing = |answer: Reply| {
        let mut setup = Setup::default();
        setup.plugins[0].on_failure = backseat_core::FailAction::Cancel;
        let mut trial = Trial::with_under_way(setup);
        trial.ask(0, [good_line(1)]);
        trial.run_for(0.5);
        trial.vehicle.replies.insert("RCN", answer);
        trial.fail(0, backseat_core::plugin::FaultKind::Error);
        trial.run_for(60.0);
        trial
    };
    let trial = failing(Reply::Silent);
    let sent = trial.sent("RCN");
    assert_eq!(sent.len(), 5);
    for (pair, least_s) in sent.windows(2).zip([3, 4, 6, 10]) {
        assert_eq!(pair[1].since(pair[0]), Duration::from_secs(least_s));
    }
    let given_up =
        |(_, note): &(Timestamp, Note)| matches!(note, Note::Text { text } if text.contains("carried out none of 5"));
    assert_eq!(trial.notes().iter().filter(|note| given_up(note)).count(), 1);
    let trial = failing(Reply::Late(Duration::from_millis(1800), AckStatus::Succeeded));
    assert_eq!(trial.commands("RCN").len(), 1);
    assert_eq!(trial.states(1).last(), Some(&RequestState::Cancelled));
    let trial = failing(Reply::Refuse);
    assert_eq!(trial.commands("RCN").len(), 1, "a refusal is an answer");
}

#[test]
fn an_insert_that_has_begun_is_not_cancelled_again() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.operator(Operator::Hold);
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(30.0);
    assert_eq!(trial.commands("RCN").len(), 1);
}

#[test]
fn sr_020_a_fail_action_keeps_an_insert_whose_cancel_would_leave_a_worse_way() {
    let mut setup = Setup {
        limits: backseat_core::Limits {
            inserts_duration_max_s: 20_000.0,
            ..limits()
        },
        ..Setup::default()
    };
    setup.plugins[1].on_failure = backseat_core::FailAction::Cancel;
    let mut trial = Trial::with_under_way(setup);
    // The inserts lead past the wreck in the west, south and east: without the southern one the way leads through the
    // wreck.
    trial.ask(0, [Request::Trackline(line(1, (-400.0, -700.0), (-400.0, -1000.0)))]);
    trial.run_for(0.3);
    trial.ask(1, [Request::Trackline(line(2, (-300.0, -1400.0), (300.0, -1400.0)))]);
    trial.run_for(0.3);
    trial.ask(0, [Request::Trackline(line(3, (400.0, -1000.0), (600.0, -1000.0)))]);
    trial.run_for(0.3);
    for tag in 1..=3 {
        assert_eq!(
            shorts(&trial.states(tag)),
            ["sent", "accepted"],
            "{tag}: {:?}",
            trial.states(tag)
        );
    }
    trial.fail(1, backseat_core::plugin::FaultKind::Error);
    trial.run_for(5.0);
    assert!(trial.commands("RCN").is_empty());
    let told = |(_, note): (Timestamp, Note)| matches!(note, Note::Text { text } if text.contains("the way without it would be refused"));
    assert!(trial.notes().into_iter().any(told));
}
