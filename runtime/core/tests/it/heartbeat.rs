//! SR-023: there is no control, and no clock, without a fresh measured round trip. A request that cannot be taken back
//! leaves only if the vehicle has just answered. The trial's judge measures the round trips by itself.

use std::time::Duration;

use backseat_core::plugin::{GpsHitRequest, Request};
use backseat_core::{Grant, Note};
use backseat_spi::AckStatus;
use backseat_units::Timestamp;

use crate::course::{self, good_line, interrupting, modify};
use crate::trial::{Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

const LIMIT_S: f64 = 1.0;

/// The first plugin asks for a modify in every step.
fn insist(trial: &mut Trial) {
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
}

fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn says(trial: &Trial, part: &str) -> bool {
    let said = |(_, note): &(Timestamp, Note)| matches!(note, Note::Text { text } if text.contains(part));
    trial.notes().iter().any(said)
}

#[test]
fn sr_023_on_a_link_that_is_slow_from_its_first_byte_only_round_trips_decide_on_control() {
    for (forth, back) in [
        (0.005, 0.4),
        (0.4, 0.005),
        (0.387, 0.391),
        (0.7, 0.7),
        (0.005, 1.2),
        (1.2, 0.005),
        (3.0, 0.005),
        (0.005, 3.0),
        (0.005, 8.0),
        (8.0, 0.005),
        (12.0, 12.0),
    ] {
        let mut trial = Trial::new();
        trial.delay = seconds(back);
        trial.delay_to_vehicle = Some(seconds(forth));
        insist(&mut trial);
        trial.run_for(120.0);
        let steered = !trial.sent("RMB").is_empty();
        assert_eq!(
            steered,
            forth + back < LIMIT_S,
            "{forth} s forth, {back} s back: {:?} {:?}",
            trial.states(1).last(),
            trial.notes().last()
        );
    }
}

#[test]
fn sr_023_a_link_that_becomes_slow_in_either_direction_ends_the_lease_until_it_is_quick_again() {
    for (forth, back) in [
        (0.005, 1.5),
        (1.5, 0.005),
        (0.005, 8.0),
        (8.0, 0.005),
        (6.0, 6.0),
        (0.005, 12.0),
    ] {
        let mut trial = Trial::steering();
        insist(&mut trial);
        trial.run_for(8.0);
        let slow = trial.now;
        trial.delay = seconds(back);
        trial.delay_to_vehicle = Some(seconds(forth));
        trial.run_for(120.0);
        let last = *trial.sent("RMB").last().unwrap();
        assert!(
            last.since(slow) < Duration::from_secs(3),
            "{forth} {back}: {last}, slow since {slow}"
        );
        let ended = trial.sent_since("EMB", slow);
        assert!(
            !ended.is_empty() && ended[0].since(slow) <= Duration::from_millis(3100),
            "{ended:?}"
        );
        // When the link is quick again, the plugin steers again.
        trial.delay = Duration::from_millis(5);
        trial.delay_to_vehicle = None;
        let quick = trial.now;
        trial.run_for(75.0);
        assert!(!trial.sent_since("RMB", quick).is_empty(), "{forth} {back}");
    }
}

#[test]
fn sr_023_a_growing_delay_is_not_mistaken_for_a_slow_clock() {
    for (forth, back) in [(0.1, 0.0), (0.0, 0.1), (0.05, 0.05)] {
        let mut trial = Trial::steering();
        insist(&mut trial);
        for second in 0..120 {
            let grown = f64::from(second);
            trial.delay = seconds(0.005 + back * grown);
            trial.delay_to_vehicle = Some(seconds(0.005 + forth * grown));
            trial.run_for(1.0);
        }
        let last = *trial.sent("RMB").last().unwrap();
        assert!(last < Timestamp::from_secs(18), "{forth} {back}: {last}");
    }
}

#[test]
fn sr_023_a_slow_link_stays_without_control_after_reconnects() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.run_for(5.0);
    trial.delay = seconds(4.0);
    trial.delay_to_vehicle = Some(Duration::from_millis(5));
    for _ in 0..8 {
        trial.cut();
        let cut = trial.now;
        trial.run_for(15.0);
        assert!(trial.sent_since("RMB", cut).is_empty());
    }
}

#[test]
fn sr_023_a_vehicle_that_acknowledges_nothing_is_never_steered_and_core_reports_it() {
    let mut trial = Trial::new();
    for name in ["LOG", "VER", "RMP", "STS", "RMB"] {
        trial.vehicle.replies.insert(name, Reply::Silent);
    }
    insist(&mut trial);
    trial.run_for(60.0);
    assert!(trial.sent("RMB").is_empty() && !trial.core.has_control());
    assert!(
        says(&trial, "acknowledges nothing on this connection: it is not steered"),
        "{:?}",
        trial.notes()
    );
    // The vehicle navigates, so core does not reset the connection although nothing is acknowledged.
    assert_eq!(trial.sent("VER").len(), 1);
}

#[test]
fn sr_023_the_lease_ends_within_three_seconds_after_the_vehicle_stops_hearing_us() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.run_for(10.0);
    trial.deaf = true;
    let deaf = trial.now;
    trial.run_for(40.0);
    let last = *trial.sent("RMB").last().unwrap();
    assert!(last.since(deaf) <= Duration::from_secs(3), "{last}");
    assert!(trial.sent_since("EMB", deaf)[0].since(deaf) <= Duration::from_secs(3));
    assert!(!trial.core.has_control());
    // Core asks for acknowledgements again, and resets the connection only long after the BPEMB.
    let asked = trial.sent_since("LOG", deaf).len();
    assert!(asked >= 3, "{asked}");
    let reset = trial
        .seen
        .iter()
        .find(|(_, seen)| *seen == crate::trial::Seen::Reset)
        .expect("it is reset");
    assert!(reset.0.since(deaf) >= Duration::from_secs(28));
}

#[test]
fn sr_023_a_modify_that_is_never_accepted_is_tried_with_growing_pauses() {
    for reply in [Reply::Silent, Reply::Refuse] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RMB", reply);
        insist(&mut trial);
        trial.run_for(240.0);
        let firsts: Vec<Timestamp> = trial.sent("RMB");
        let mut leases = vec![firsts[0]];
        for sent in firsts {
            if sent.since(*leases.last().unwrap()) > Duration::from_millis(1500) {
                leases.push(sent);
            }
        }
        assert!(leases.len() <= 9, "{reply:?}: {leases:?}");
        let gaps: Vec<f64> = leases
            .windows(2)
            .map(|pair| pair[1].since(pair[0]).as_secs_f64())
            .collect();
        let mut least = 0.5f64;
        for gap in &gaps {
            least = (2.0 * least).min(60.0);
            assert!(*gap >= least - 0.1, "{reply:?}: {gaps:?}");
        }
        assert!(
            trial.rejection(1).starts_with("pause: "),
            "the plugin learns of the pause: {}",
            trial.rejection(1)
        );
        // After half a minute of answers the next pause is the shortest again.
        trial.vehicle.replies.remove("RMB");
        trial.run_for(61.0 + 40.0);
        assert!(trial.core.is_steering());
        trial.vehicle.replies.insert("RMB", Reply::Refuse);
        trial.run_for(1.5);
        trial.vehicle.replies.remove("RMB");
        trial.run_for(2.5);
        assert!(trial.core.is_steering(), "{reply:?}");
    }
}

/// A lease that ends before its answer comes does not avoid the pause.
#[test]
fn sr_023_a_refusal_that_comes_after_the_lease_has_ended_counts_too() {
    for reply in [Reply::Silent, Reply::Refuse] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RMB", reply);
        trial.script(0, |_| {
            let step = vec![Request::Modify(modify(1)), Request::EndModify];
            (Duration::from_millis(1), Ok(step))
        });
        trial.run_for(240.0);
        let sent = trial.sent("RMB");
        // Without an answer, some BPRMB leave before core knows that the first is not answered.
        let pauses = sent.windows(2).map(|pair| pair[1].since(pair[0]));
        let pauses: Vec<f64> = pauses
            .map(|pause| pause.as_secs_f64())
            .filter(|pause| *pause > 0.9)
            .collect();
        assert!(sent.len() <= 54, "{reply:?}: {} BPRMB", sent.len());
        assert!((5..=9).contains(&pauses.len()), "{reply:?}: {pauses:?}");
        let longer = |pair: &[f64]| pair[1] > 1.5 * pair[0] || pair[1] > 59.0;
        assert!(pauses.windows(2).all(longer), "{reply:?}: {pauses:?}");
    }
}

/// A lease that waits for its turn, because a BPRMB has just left for another, is not in force yet. The refusal that
/// comes meanwhile holds for it.
#[test]
fn sr_023_a_refusal_of_the_last_lease_also_ends_the_next_one_before_its_first_bprmb() {
    let mut trial = Trial::under_way();
    let refused = Reply::Late(Duration::from_millis(50), AckStatus::Failed);
    trial.vehicle.replies.insert("RMB", refused);
    let step = [
        Request::Modify(modify(1)),
        Request::EndModify,
        Request::Modify(modify(2)),
    ];
    trial.ask(0, step);
    trial.run_for(2.0);
    assert_eq!(trial.sent("RMB").len(), 1);
    assert_eq!(
        trial.sent("EMB").len(),
        1,
        "nothing is modified that a second could end"
    );
    assert_eq!(shorts(&trial.states(2)), ["ended"]);
}

#[test]
fn sr_023_if_status_is_never_answered_subscriptions_serve_as_the_heartbeat() {
    let mut trial = Trial::new();
    for name in ["VER", "STS", "RMB"] {
        trial.vehicle.replies.insert(name, Reply::Silent);
    }
    trial.run_for(30.0);
    assert!(trial.core.has_control());
    let lost: Vec<_> = trial
        .notes()
        .into_iter()
        .filter(|(at, note)| *at > Timestamp::from_secs(8) && matches!(note, Note::Control { granted: false, .. }))
        .collect();
    assert!(lost.is_empty(), "{lost:?}");
    let beats = trial.sent_since("LOG", Timestamp::from_secs(10)).len();
    assert!((18..=21).contains(&beats), "{beats}");
    // Core remembers this: on a new connection the beats begin sooner.
    trial.cut();
    let cut = trial.now;
    trial.run_for(8.0);
    assert!(trial.core.has_control());
    assert!(trial.sent_since("LOG", cut).len() > 10);
    // Core still notices a vehicle that no longer hears it.
    trial.deaf = true;
    let deaf = trial.now;
    trial.run_for(3.5);
    assert!(!trial.core.has_control());
    trial.run_for(20.0);
    assert!(
        trial.sent_since("LOG", deaf).len() <= 6,
        "one beat in flight, and the renewed subscriptions"
    );
}

#[test]
fn sr_023_acknowledgements_that_echo_fewer_decimals_count_too() {
    for decimals in 0..=9 {
        let mut trial = Trial::new();
        trial.vehicle.echo_decimals = decimals;
        insist(&mut trial);
        trial.run_for(30.0);
        assert!(trial.core.is_steering(), "{decimals}: {:?}", trial.lease_ends());
        assert!(trial.lease_ends().is_empty(), "{decimals}: {:?}", trial.lease_ends());
    }
}

#[test]
fn sr_023_refusals_and_pending_answers_count_as_round_trips() {
    for reply in [
        Reply::Refuse,
        Reply::Pending(Duration::from_secs(3), AckStatus::Succeeded),
        Reply::PendingForEver,
    ] {
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("STS", reply);
        trial.run_for(10.0);
        assert!(trial.core.has_control(), "{reply:?}");
    }
}

fn hit(tag: u64) -> Request {
    Request::GpsHit(GpsHitRequest {
        tag,
        position: course::at(0.0, 500.0),
    })
}

fn with_interrupt() -> Setup {
    granted(&[Grant::Insert, Grant::Interrupt, Grant::Surface], &[])
}

#[test]
fn sr_023_an_interrupting_insert_needs_its_own_grant() {
    let mut setup = Setup::default();
    setup.plugins[0].grants.retain(|grant| *grant != Grant::Interrupt);
    let mut trial = Trial::with_under_way(setup);
    trial.ask(0, [interrupting(1), good_line(2)]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(1).contains("does not grant `interrupt`"),
        "{:?}",
        trial.states(1)
    );
    assert_eq!(trial.sent("RTK").len(), 1);
}

#[test]
fn sr_023_an_irrevocable_request_waits_for_an_answer_and_leaves_after_it() {
    let mut trial = Trial::with_under_way(with_interrupt());
    // The vehicle has answered nothing within the last second.
    trial.vehicle.replies.insert("STS", Reply::Silent);
    trial.run_for(1.3);
    assert!(trial.core.has_control());
    trial.vehicle.replies.remove("STS");
    let asked = trial.now;
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    let sent = trial.sent_since("RTK", asked);
    assert_eq!(sent.len(), 1, "{:?}", trial.states(1));
    let beat = trial.sent_since("STS", asked);
    assert!(
        beat[0] < sent[0] && sent[0].since(beat[0]) >= Duration::from_millis(10),
        "{beat:?} {sent:?}"
    );
}

/// A beat that is answered shows that the vehicle has read the first insert, but not whether it flies it.
#[test]
fn sr_023_an_irrevocable_request_waits_until_the_vehicle_has_answered_every_insert_before_it() {
    for (first, name) in [(interrupting(1), "RTK"), (hit(1), "RGP"), (good_line(1), "RTK")] {
        let under_way = || {
            let mut trial = Trial::with_under_way(Setup {
                fence: course::harbour(),
                ..with_interrupt()
            });
            trial.run_for(5.0);
            trial
        };
        let mut trial = under_way();
        trial.vehicle.replies.insert(name, Reply::Silent);
        trial.ask(0, [first.clone()]);
        trial.ask(1, [hit(2)]);
        let asked = trial.now;
        trial.run_for(0.9);
        assert_eq!(shorts(&trial.states(1)), ["sent"], "{:?}", trial.states(1));
        assert!(trial.states(2).is_empty(), "it waits: {:?}", trial.states(2));
        assert!(
            !trial.sent_since("STS", asked).is_empty(),
            "a beat was sent and answered"
        );
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
        assert!(trial.rejection(2).starts_with("heard: "), "{:?}", trial.states(2));
        // With the answer to the first, the second leaves.
        let mut trial = under_way();
        let late = Reply::Late(Duration::from_millis(400), AckStatus::Succeeded);
        trial.vehicle.replies.insert(name, late);
        trial.ask(0, [first]);
        trial.run_for(0.15);
        trial.vehicle.replies.remove(name);
        trial.ask(1, [hit(2)]);
        let second = trial.now;
        trial.run_for(0.8);
        let sent = trial.commands("RGP").pop().expect("the second leaves").0;
        assert!(
            sent.since(second) >= Duration::from_millis(200),
            "{:?}",
            trial.states(2)
        );
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    }
}

#[test]
fn sr_023_an_irrevocable_request_to_a_vehicle_that_hears_nothing_is_refused() {
    let mut trial = Trial::with_under_way(with_interrupt());
    trial.run_for(0.05);
    trial.deaf = true;
    let deaf = trial.now;
    trial.run_for(1.4);
    assert!(trial.core.has_control(), "its last answer is still recent enough");
    trial.ask(0, [interrupting(1), good_line(2)]);
    trial.run_for(1.3);
    assert!(trial.rejection(1).starts_with("heard: "), "{:?}", trial.states(1));
    let inserts = trial.commands("RTK");
    assert!(
        inserts
            .iter()
            .all(|(_, command)| !format!("{command:?}").contains("InterruptCurrent"))
    );
    // The other insert leaves as always, because it can be taken back.
    assert_eq!(shorts(&trial.states(2))[0], "sent");
    assert!(trial.now.since(deaf) < Duration::from_secs(3));
}

#[test]
fn sr_023_a_waiting_request_is_judged_again_and_ends_with_its_plugin() {
    let mut trial = Trial::with_under_way(with_interrupt());
    let late = Reply::Late(Duration::from_millis(600), AckStatus::Succeeded);
    trial.vehicle.replies.insert("STS", late);
    trial.run_for(2.15);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.2);
    assert!(trial.states(1).is_empty(), "it waits: {:?}", trial.states(1));
    trial.operator(backseat_core::Operator::Hold);
    trial.run_for(1.0);
    assert!(trial.rejection(1).starts_with("control: "), "{:?}", trial.states(1));
    assert!(trial.sent("RTK").is_empty());
    trial.operator(backseat_core::Operator::Release);
    trial.run_for(0.8);
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.15);
    trial.fail(0, backseat_core::plugin::FaultKind::Trap);
    trial.run_for(2.0);
    assert!(trial.sent("RTK").is_empty(), "{:?}", trial.states(2));
}
