use backseat_core::plugin::Request;
use backseat_core::{Grant, Identifiers, Input, Limits, Operator, Start};
use backseat_spi::{BehaviorBegin, BehaviorId, FromVehicle, Text, ToVehicle};

use crate::course::{good_line, interrupting, modify, turn};
use crate::scene::hands_over;
use crate::trial::{Seen, Setup, Trial, granted, short, shorts};
use crate::vehicle::Reply;

fn begin(trial: &mut Trial, identifier: u32) {
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(identifier));
    trial.run_for(0.3);
}

fn end(trial: &mut Trial, identifier: u32) {
    let now = trial.now;
    trial.vehicle.end(now, None, Some(identifier));
    trial.run_for(0.3);
}

/// The plan goes on with its second behavior, which nobody has interrupted.
fn goes_on(trial: &mut Trial) {
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.3);
}

/// The identifiers of the tracklines that were sent, in order.
fn identifiers(trial: &Trial) -> Vec<u32> {
    let of = |(_, message): &(_, ToVehicle)| match message {
        ToVehicle::Trackline(line) => Some(line.identifier.get()),
        _ => None,
    };
    trial.commands("RTK").iter().filter_map(of).collect()
}

/// The identifiers of the inserts that were cancelled, in order.
fn cancelled(trial: &Trial) -> Vec<u32> {
    let of = |(_, message): &(_, ToVehicle)| match message {
        ToVehicle::CancelBehavior(cancel) => Some(cancel.identifier.get()),
        _ => None,
    };
    trial.commands("RCN").iter().filter_map(of).collect()
}

#[test]
fn sr_009_sr_019_an_interrupted_insert_stays_open_until_core_knows_whether_it_is_resumed() {
    for resumed in [true, false] {
        let mut trial = Trial::under_way();
        trial.ask(0, [good_line(1)]);
        trial.run_for(0.5);
        let first = identifiers(&trial)[0];
        begin(&mut trial, first);
        trial.ask(0, [interrupting(2)]);
        trial.run_for(0.5);
        let second = identifiers(&trial)[1];
        end(&mut trial, first);
        begin(&mut trial, second);
        assert_eq!(
            shorts(&trial.states(1)).last(),
            Some(&"started"),
            "{:?}",
            trial.states(1)
        );
        end(&mut trial, second);
        let now = trial.now;
        if resumed {
            begin(&mut trial, first);
            assert_eq!(
                shorts(&trial.states(1)).last(),
                Some(&"started"),
                "{:?}",
                trial.states(1)
            );
            end(&mut trial, first);
        } else {
            trial.vehicle.begin(now, Some(2), None);
            trial.run_for(0.3);
        }
        assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"), "{:?}", trial.states(1));
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_010_a_refused_insert_that_is_flown_anyway_is_not_interrupted() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    let first = identifiers(&trial)[0];
    trial.vehicle.replies.remove("RTK");
    begin(&mut trial, first);
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(2).contains("may be one that no other may interrupt"),
        "{}",
        trial.rejection(2)
    );
    end(&mut trial, first);
    goes_on(&mut trial);
    trial.ask(0, [interrupting(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{:?}", trial.states(3));
}

/// A process that follows one that used the identifiers 1 to 9 and sent this many inserts.
fn successor(inserts: u32, limits: impl FnOnce(&mut Limits)) -> Trial {
    let mut setup = Setup::default().after(inserts, 0);
    limits(&mut setup.limits);
    Trial::with(setup)
}

#[test]
fn sr_019_a_flown_insert_of_a_killed_process_counts_although_the_plan_does_not_name_it() {
    let mut trial = successor(9, |limits| limits.inserts_open_max = 1);
    trial.run_for(2.0);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(4));
    trial.run_for(0.5);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).starts_with("cap: "), "{:?}", trial.states(1));
    // A damaged sentence does not end it either.
    trial.hear_bytes(b"$BFMBE,221325.000,,,9,trackline*00\r\n");
    trial.ask(0, [good_line(3)]);
    trial.run_for(0.5);
    assert!(trial.rejection(3).starts_with("cap: "), "{:?}", trial.states(3));
    let now = trial.now;
    trial.vehicle.end(now, None, Some(4));
    // The behavior that begins first may be one that the vehicle takes up again.
    trial.vehicle.begin(now, Some(2), None);
    trial.vehicle.begin(now, Some(3), None);
    trial.run_for(0.5);
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
}

#[test]
fn sr_002_a_possible_gps_hit_of_a_killed_process_is_not_modified() {
    let successor = |gps_hits| {
        let setup = granted(&[Grant::Modify, Grant::Insert, Grant::Surface], &[]);
        let mut trial = Trial::with(setup.after(3, gps_hits));
        // The vehicle says what it flies only as that begins, and not to a client that connects later.
        trial.vehicle.replays = false;
        trial.run_for(1.0);
        trial
    };
    let in_control = |trial: &mut Trial| {
        let now = trial.now;
        trial.vehicle.set_status(now, "Running");
        trial.vehicle.set_control(now, true);
        trial.run_for(12.0);
    };
    let refused = |trial: &mut Trial, tag| {
        in_control(trial);
        trial.ask(0, [turn(tag, 90.0)]);
        trial.run_for(0.5);
        let states = trial.states(tag);
        states.iter().any(|state| short(state) == "rejected") && trial.rejection(tag).starts_with("gps-hit: ")
    };
    let begins = |trial: &mut Trial, identifier, kind| {
        let created = trial.vehicle.clock(trial.now);
        trial.hear_now([FromVehicle::BehaviorBegin(BehaviorBegin {
            created,
            dive_file: Text::cleaned(""),
            number: None,
            identifier: Some(BehaviorId::new(identifier)),
            kind: Text::cleaned(kind),
        })]);
        trial.run_for(0.5);
    };
    // The killed process sent no GPS hit, because it had reserved none.
    assert!(!refused(&mut successor(0), 1));
    let mut trial = successor(2);
    assert!(refused(&mut trial, 1), "a GPS hit may be flown");
    begins(&mut trial, 4, "trackline");
    assert!(!refused(&mut trial, 2), "a line is flown");
    begins(&mut trial, 5, "gps");
    assert!(refused(&mut trial, 3), "a behavior of the kind `gps` may be a GPS hit");
    // While the link was lost, another insert may have begun.
    let mut trial = successor(2);
    begins(&mut trial, 4, "trackline");
    trial.cut();
    trial.run_for(20.0);
    assert!(refused(&mut trial, 4));
    // When the plan goes on, no GPS hit is left.
    let now = trial.now;
    trial.vehicle.begin(now, Some(1), None);
    trial.run_for(0.5);
    assert!(!refused(&mut trial, 5));
    trial.cut();
    trial.run_for(20.0);
    assert!(!refused(&mut trial, 6), "{:?}", trial.states(6));
}

#[test]
fn sr_019_gps_hits_are_reserved_only_if_a_plugin_may_ask_for_them() {
    let reserved = |grants: &[Grant]| {
        let setup = granted(grants, &[]);
        let start = Start {
            identifiers: Some(Identifiers::default()),
            ..setup.start
        };
        let mut trial = Trial::with(Setup { start, ..setup });
        trial.run_for(2.0);
        let hits = trial.seen.iter().filter_map(|(_, seen)| match seen {
            Seen::Reserve(reservation) => Some(reservation.gps_hits),
            _ => None,
        });
        hits.max().unwrap()
    };
    assert_eq!(reserved(&[Grant::Modify, Grant::Insert]), 0);
    assert!(reserved(&[Grant::Insert, Grant::Surface]) > 0);
}

#[test]
fn sr_019_the_inserts_of_a_killed_process_count_under_the_cap_of_the_mission() {
    let mut trial = successor(9, |limits| limits.inserts_total_max = 10);
    trial.run_for(2.0);
    goes_on(&mut trial);
    for tag in [1, 2] {
        trial.ask(0, [good_line(tag)]);
        trial.run_for(0.5);
    }
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    assert!(
        trial.rejection(2).contains("inserts of the mission is 11"),
        "{}",
        trial.rejection(2)
    );
    // The number of inserts is on disk before they are sent.
    let reserved = trial.seen.iter().filter_map(|(_, seen)| match seen {
        Seen::Reserve(reservation) => Some(reservation.inserts),
        _ => None,
    });
    assert!(reserved.max().is_some_and(|most| most >= 10));
}

#[test]
fn sr_010_nothing_interrupts_while_an_insert_of_a_killed_process_may_be_flown() {
    let mut trial = successor(2, |_| {});
    trial.vehicle.inserted.extend([7]);
    trial.run_for(2.0);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("a previous run"), "{}", trial.rejection(1));
    // Once a behavior begins, core knows what is flown.
    begin(&mut trial, 7);
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.5);
    assert!(trial.rejection(2).contains("a previous run"), "{}", trial.rejection(2));
    end(&mut trial, 7);
    goes_on(&mut trial);
    trial.ask(0, [interrupting(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{:?}", trial.states(3));
}

#[test]
fn sr_015_a_hold_takes_back_the_inserts_that_a_killed_process_left_in_the_plan() {
    let mut trial = successor(2, |_| {});
    trial.vehicle.inserted.extend([7, 40]);
    trial.run_for(2.0);
    trial.feed(Input::Operator(Operator::Hold));
    trial.run_for(0.5);
    // Insert 40 is another payload's.
    assert_eq!(cancelled(&trial), [7]);
}

#[test]
fn sr_015_a_hold_takes_back_an_insert_of_a_killed_process_even_if_the_plan_does_not_come_again() {
    let mut trial = successor(2, |_| {});
    trial.vehicle.inserted.extend([7]);
    trial.run_for(2.0);
    trial.cut();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.feed(Input::Operator(Operator::Hold));
    trial.run_for(2.0);
    assert!(trial.is_connected());
    assert_eq!(cancelled(&trial), [7]);
    // An insert that has begun is not taken back.
    let mut trial = successor(2, |_| {});
    trial.vehicle.inserted.extend([7]);
    trial.run_for(2.0);
    begin(&mut trial, 7);
    trial.cut();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.feed(Input::Operator(Operator::Hold));
    trial.run_for(2.0);
    assert!(cancelled(&trial).is_empty());
}

#[test]
fn sr_015_during_a_hold_an_insert_of_a_killed_process_is_taken_back_as_soon_as_the_plan_names_it() {
    let mut trial = successor(2, |_| {});
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.run_for(2.0);
    trial.feed(Input::Operator(Operator::Hold));
    for index in 0..2 {
        let now = trial.now;
        for (identifier, east_m) in [(7, 0.0), (40, 100.0)] {
            trial
                .vehicle
                .say_element(now, None, Some(identifier), index, (east_m, 500.0));
        }
        trial.run_for(0.2);
    }
    // Insert 40 is another payload's. The plan is not complete yet.
    assert_eq!(cancelled(&trial), [7]);
}

/// A previous run has used identifiers for packets alone, so no insert of it can be flown: the line that the vehicle follows
/// shows what it flies.
#[test]
fn sr_002_after_a_run_that_sent_no_insert_the_line_shows_what_is_flown() {
    let seen = |inserts| {
        let mut trial = Trial::with(Setup::default().after(inserts, 0));
        trial.vehicle.replays = false;
        trial.run_for(1.0);
        hands_over(&mut trial);
        trial.run_for(20.0);
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        trial.core.is_steering()
    };
    assert!(seen(0));
    assert!(!seen(1));
}

/// What a process reserves, the next one must take for sent.
#[test]
fn sr_002_inserts_are_reserved_only_if_a_plugin_may_ask_for_them() {
    let reserved = |grants: &[Grant]| {
        let mut setup = Setup::default();
        for plugin in &mut setup.plugins {
            plugin.grants = grants.to_vec();
        }
        let trial = Trial::with_under_way(setup);
        let of = |seen: &Seen| match seen {
            Seen::Reserve(reservation) => Some((reservation.inserts, reservation.gps_hits)),
            _ => None,
        };
        trial.seen.iter().filter_map(|(_, seen)| of(seen)).max()
    };
    assert_eq!(reserved(&[Grant::Modify, Grant::Acoustic]), Some((0, 0)));
    assert_eq!(reserved(&[Grant::Insert]), Some((4, 0)));
    assert_eq!(reserved(&[Grant::Insert, Grant::Surface]), Some((4, 4)));
}
