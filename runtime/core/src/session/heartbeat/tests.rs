//! Tests of the heartbeat.

use backseat_spi::{AckStatus, EchoedTime, Text};

use super::*;

const DELAY_MAX: Duration = Duration::from_secs(1);

fn stamp(millis: u64) -> TimeOfDay {
    TimeOfDay::from_nanos((10_000_000 + millis) * 1_000_000).unwrap()
}

fn at(millis: u64) -> Timestamp {
    Timestamp::from_millis(millis)
}

fn ack(letters: &'static str, echo: EchoedTime) -> Acknowledgement {
    Acknowledgement {
        created: TimeOfDay::MIDNIGHT,
        command: name(letters),
        command_created: echo,
        behavior: None,
        status: AckStatus::Succeeded,
        text: Text::cleaned(""),
    }
}

/// An answer to a BPLOG, written at this time.
fn log_answer(millis: u64) -> Acknowledgement {
    Acknowledgement {
        created: stamp(millis),
        ..ack("LOG", EchoedTime::NONE)
    }
}

fn connected() -> Heartbeat {
    let mut heartbeat = Heartbeat::new(DELAY_MAX);
    heartbeat.begin(at(0));
    heartbeat
}

/// Sends a BPSTS at one time, and its answer comes at another.
fn beat(heartbeat: &mut Heartbeat, sent: u64, answered: u64) -> Option<Heard> {
    heartbeat.left(at(sent), name("STS"), Some(stamp(sent)), false);
    heartbeat.acknowledged(at(answered), &ack("STS", EchoedTime::of(stamp(sent))))
}

#[test]
fn sr_023_a_good_round_trip_counts_for_3_s_from_when_its_command_was_sent() {
    let mut heartbeat = connected();
    assert!(!heartbeat.is_heard(at(0)));
    assert!(beat(&mut heartbeat, 100, 1100).unwrap().good);
    assert!(heartbeat.is_heard(at(3099)) && !heartbeat.is_heard(at(3100)));
    assert_eq!(heartbeat.lapses_at(), Some(at(3100)));
    assert!(!beat(&mut heartbeat, 3000, 4001).unwrap().good);
    assert!(!heartbeat.is_heard(at(4001)));
    heartbeat.begin(at(4100));
    assert!(
        !heartbeat.is_heard(at(4100)),
        "the round trip was on another connection"
    );
}

#[test]
fn sr_023_only_the_first_answer_to_a_sent_command_counts() {
    let mut heartbeat = connected();
    assert!(beat(&mut heartbeat, 100, 110).is_some());
    let again = ack("STS", EchoedTime::of(stamp(100)));
    assert_eq!(heartbeat.acknowledged(at(2000), &again), None);
    let never_sent = ack("STS", EchoedTime::of(stamp(900)));
    assert_eq!(heartbeat.acknowledged(at(2000), &never_sent), None);
    heartbeat.left(at(2000), name("STS"), Some(stamp(2000)), false);
    assert_eq!(heartbeat.acknowledged(at(2001), &ack("STS", EchoedTime::NONE)), None);
    assert_eq!(heartbeat.acknowledged(at(2001), &ack("NAK", EchoedTime::NONE)), None);
}

#[test]
fn sr_023_an_echo_that_matches_two_commands_counts_for_the_older() {
    let mut heartbeat = connected();
    heartbeat.left(at(100), name("RMB"), Some(stamp(100)), false);
    heartbeat.left(at(300), name("RMB"), Some(stamp(300)), false);
    let echo = EchoedTime::with_decimals(stamp(300), 0);
    let heard = heartbeat.acknowledged(at(310), &ack("RMB", echo)).unwrap();
    assert_eq!(heard.trip.lasted(), Duration::from_millis(210));
}

#[test]
fn sr_023_if_only_status_is_not_answered_subscriptions_are_the_beat_one_at_a_time() {
    let mut heartbeat = connected();
    heartbeat.left(at(0), name("LOG"), None, false);
    assert!(heartbeat.acknowledged(at(10), &log_answer(9)).unwrap().good);
    let mut logs = Vec::new();
    for second in 0..20u64 {
        let now = 20 + second * 1000;
        if heartbeat.needs_log(at(now)) {
            heartbeat.left(at(now), name("LOG"), None, false);
            logs.push(second);
            if second < 10 {
                let heard = heartbeat.acknowledged(at(now + 5), &log_answer(now + 4));
                assert_eq!(heard.unwrap().trip.lasted(), Duration::from_millis(5));
            }
        }
        heartbeat.left(at(now), name("STS"), Some(stamp(now)), false);
    }
    // The BPLOG that was sent at 10 s is not answered, and no other follows it.
    assert_eq!(logs, [4, 5, 6, 7, 8, 9, 10]);
    assert!(!heartbeat.is_heard(at(20_000)));
    // Its answer comes late, and is taken for its own.
    let late = heartbeat.acknowledged(at(20_500), &log_answer(20_400)).unwrap();
    assert!(!late.good && late.trip.lasted() > Duration::from_secs(10));
}

#[test]
fn sr_023_a_refused_status_does_not_show_that_the_vehicle_answers_others() {
    let mut heartbeat = connected();
    let mut heard = Vec::new();
    for second in 0..60u64 {
        let now = 20 + second * 1000;
        if second == 0 || heartbeat.needs_log(at(now)) {
            heartbeat.left(at(now), name("LOG"), None, false);
            heartbeat.acknowledged(at(now + 5), &log_answer(now + 4));
        }
        heartbeat.left(at(now), name("STS"), Some(stamp(now)), false);
        heartbeat.left(at(now), name("TMR"), Some(stamp(now)), false);
        if second == 30 {
            for letters in ["STS", "TMR"] {
                let refused = Acknowledgement {
                    status: AckStatus::Invalid,
                    ..ack(letters, EchoedTime::of(stamp(now)))
                };
                assert!(heartbeat.acknowledged(at(now + 5), &refused).unwrap().good);
            }
        }
        if heartbeat.has_just_answered(at(now + 10)) && heartbeat.is_heard(at(now + 990)) {
            heard.push(second);
        }
    }
    let expected: Vec<u64> = [0].into_iter().chain(4..60).collect();
    assert_eq!(heard, expected);
}

#[test]
fn sr_023_a_lost_answer_to_a_subscription_costs_20_s_and_not_the_day() {
    let mut heartbeat = connected();
    heartbeat.left(at(0), name("LOG"), None, false);
    heartbeat.acknowledged(at(10), &log_answer(9));
    let mut heard = Vec::new();
    for second in 0..200u64 {
        let now = 20 + second * 1000;
        let beat = heartbeat.needs_log(at(now));
        let subscribe = heartbeat.remedy(at(now)) == Some(Remedy::Subscribe);
        for _ in 0..u32::from(beat) + u32::from(subscribe) {
            heartbeat.left(at(now), name("LOG"), None, false);
            // One of the answers is damaged on its way.
            if second != 20 {
                heartbeat.acknowledged(at(now + 5), &log_answer(now + 4));
            }
        }
        heartbeat.left(at(now), name("STS"), Some(stamp(now)), false);
        if heartbeat.is_heard(at(now + 6)) {
            heard.push(second);
        }
    }
    assert!(heard.contains(&19) && !heard.contains(&25), "{heard:?}");
    assert!((40..200).all(|second| heard.contains(&second)), "{heard:?}");
}

#[test]
fn sr_023_a_repeated_answer_is_no_round_trip_of_the_next_subscription() {
    let mut heartbeat = connected();
    let subscribe = |heartbeat: &mut Heartbeat, millis| {
        for _ in 0..3 {
            heartbeat.left(at(millis), name("LOG"), None, false);
        }
    };
    // The vehicle hears us only after 2 s, when everything has been sent again. One of its answers comes twice, and
    // then the others come.
    subscribe(&mut heartbeat, 0);
    subscribe(&mut heartbeat, 2000);
    for (answered, written) in [
        (2010, 2000),
        (2010, 2000),
        (2010, 2000),
        (2011, 2001),
        (4010, 4000),
        (4010, 4000),
    ] {
        let heard = heartbeat.acknowledged(at(answered), &log_answer(written)).unwrap();
        assert_eq!(heard.trip.sent, at(0), "{answered}");
        assert!(!heartbeat.is_heard(at(answered)));
    }
    assert_eq!(
        heartbeat.acknowledged(at(4011), &log_answer(4000)),
        None,
        "no BPLOG waits for an answer"
    );
    // An answer that is under way now could belong to an earlier BPLOG.
    heartbeat.left(at(5000), name("LOG"), None, false);
    assert!(!heartbeat.acknowledged(at(5010), &log_answer(5005)).unwrap().good);
    heartbeat.left(at(12_200), name("LOG"), None, false);
    assert!(heartbeat.acknowledged(at(12_210), &log_answer(12_205)).unwrap().good);
}

#[test]
fn sr_023_if_subscriptions_are_the_beat_a_repeated_answer_counts_once() {
    let mut heartbeat = connected();
    heartbeat.left(at(0), name("LOG"), None, false);
    heartbeat.acknowledged(at(10), &log_answer(9));
    for millis in [1000, 2000, 3000, 4000] {
        heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
    }
    assert!(heartbeat.needs_log(at(5000)));
    heartbeat.left(at(5000), name("LOG"), None, false);
    assert!(!heartbeat.acknowledged(at(8000), &log_answer(6500)).unwrap().good);
    // The same answer comes again when the next BPLOG has just been sent.
    assert!(heartbeat.needs_log(at(9000)));
    heartbeat.left(at(9000), name("LOG"), None, false);
    assert_eq!(heartbeat.acknowledged(at(9001), &log_answer(6500)), None);
    assert!(!heartbeat.is_heard(at(9001)) && !heartbeat.needs_log(at(10_000)));
    let heard = heartbeat.acknowledged(at(12_000), &log_answer(10_500)).unwrap();
    assert_eq!(heard.trip.sent, at(9000));
    assert!(!heartbeat.is_heard(at(12_000)));
}

#[test]
fn sr_023_if_subscriptions_are_the_beat_and_arrive_twice_no_answer_is_taken_for_the_next_one() {
    for takes in (1100..4100u64).step_by(20) {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        heartbeat.acknowledged(at(10), &log_answer(9));
        for millis in [1000, 2000, 3000, 4000] {
            heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
        }
        // The way there and back is long, and everything that we send arrives twice: each BPLOG has two answers, which
        // the vehicle writes at times of their own.
        let mut answers = VecDeque::new();
        let mut sent = 0;
        for millis in (5000..60_000u64).step_by(10) {
            while answers.front().is_some_and(|(comes, _)| *comes <= millis) {
                let (comes, written) = answers.pop_front().unwrap();
                heartbeat.acknowledged(at(comes), &log_answer(written));
            }
            if millis.is_multiple_of(1000) && heartbeat.needs_log(at(millis)) {
                sent += 1;
                heartbeat.left(at(millis), name("LOG"), None, false);
                let written = millis + takes / 2;
                answers.extend([(millis + takes, written), (millis + takes + 50, written + 50)]);
            }
            assert!(!heartbeat.is_heard(at(millis)), "{takes}: {millis}");
        }
        assert!(sent > 5, "{takes}: {sent} beats");
    }
}

#[test]
fn sr_023_answers_that_take_a_while_leave_no_gap_between_beats_of_subscriptions() {
    for takes in [5, 400, 1000] {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        heartbeat.acknowledged(at(10), &log_answer(9));
        for millis in [1000, 2000, 3000, 4000] {
            heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
        }
        let mut comes = None;
        for millis in (5000..60_000u64).step_by(5) {
            if comes == Some(millis) {
                heartbeat.acknowledged(at(millis), &log_answer(millis - 2));
            }
            if millis.is_multiple_of(1000) && heartbeat.needs_log(at(millis)) {
                heartbeat.left(at(millis), name("LOG"), None, false);
                comes = Some(millis + takes);
            }
            assert!(millis < 6000 || heartbeat.is_heard(at(millis)), "{takes}: {millis}");
        }
    }
}

#[test]
fn sr_023_more_subscriptions_than_are_remembered_make_no_late_answer_look_prompt() {
    for (sent, answered) in [(100, 64), (logs::WAITING_MAX + 20, logs::WAITING_MAX)] {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        heartbeat.acknowledged(at(10), &log_answer(9));
        for millis in [1000, 2000, 3000, 4000] {
            heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
        }
        assert!(heartbeat.needs_log(at(5000)), "BPLOG is the beat");
        // On a link that takes 11 s, everything is subscribed again and again. The first answers come.
        for _ in 0..sent {
            heartbeat.left(at(5000), name("LOG"), None, false);
        }
        for written in 10_000..10_000 + answered as u64 {
            heartbeat.acknowledged(at(16_000), &log_answer(written));
        }
        // The next answer belongs to a BPLOG of 11 s ago, and not to the one that has just been sent.
        heartbeat.left(at(16_100), name("LOG"), None, false);
        heartbeat.acknowledged(at(16_200), &log_answer(11_000));
        assert!(!heartbeat.is_heard(at(16_200)), "{sent} subscriptions");
    }
}

#[test]
fn a_vehicle_that_answers_nothing_gets_no_subscriptions_as_beats() {
    let mut heartbeat = connected();
    for second in 0..60u64 {
        assert!(!heartbeat.needs_log(at(second * 1000)));
        heartbeat.left(at(second * 1000), name("STS"), Some(stamp(second * 1000)), false);
    }
}

#[test]
fn with_early_answers_round_trips_count_from_the_first_command() {
    let mut heartbeat = connected();
    heartbeat.left(at(0), name("VER"), Some(stamp(0)), true);
    heartbeat.left(at(0), name("LOG"), None, true);
    heartbeat.left(at(1000), name("LOG"), None, false);
    heartbeat.acknowledged(at(1500), &ack("VER", EchoedTime::of(stamp(0))));
    let first = heartbeat.acknowledged(at(1500), &log_answer(1000)).unwrap();
    assert_eq!(first.trip.sent, at(0));
    let second = heartbeat.acknowledged(at(2500), &log_answer(2000)).unwrap();
    assert_eq!(second.trip.sent, at(1000));
}

#[test]
fn sr_023_a_subscription_of_the_moment_in_which_the_connection_began_may_be_of_the_last_one() {
    let mut heartbeat = connected();
    heartbeat.left(at(0), name("LOG"), None, false);
    // A remedy, and in the same moment the connection is reset.
    heartbeat.left(at(12_000), name("LOG"), None, false);
    heartbeat.begin(at(12_000));
    heartbeat.left(at(12_000), name("LOG"), None, false);
    // The answer to the first, 12 s late, passed on in this connection.
    assert_eq!(heartbeat.acknowledged(at(12_010), &log_answer(12_005)), None);
    assert!(!heartbeat.is_heard(at(12_010)));
}

#[test]
fn sr_023_an_irrevocable_command_needs_an_answer_of_this_second_and_none_outstanding() {
    let mut heartbeat = connected();
    beat(&mut heartbeat, 1000, 1010);
    assert!(heartbeat.has_just_answered(at(2000)) && !heartbeat.has_just_answered(at(2001)));
    beat(&mut heartbeat, 2000, 2010);
    heartbeat.left(at(2020), name("STS"), Some(stamp(2020)), false);
    assert!(!heartbeat.has_just_answered(at(2030)), "a beat is under way");
    heartbeat.acknowledged(at(2040), &ack("STS", EchoedTime::of(stamp(2020))));
    // A kind of command that this vehicle has never answered is not waited for, unless it is an insert.
    heartbeat.left(at(2050), name("MSG"), Some(stamp(2050)), false);
    assert!(heartbeat.has_just_answered(at(2060)));
    heartbeat.left(at(2070), name("RGP"), Some(stamp(2070)), false);
    assert!(!heartbeat.has_just_answered(at(2080)));
    heartbeat.acknowledged(at(2090), &ack("RGP", EchoedTime::of(stamp(2070))));
    assert!(heartbeat.has_just_answered(at(2090)));
}

#[test]
fn acknowledgements_are_subscribed_again_after_3_6_and_12_s_and_a_good_connection_is_reset_after_30() {
    let mut heartbeat = connected();
    beat(&mut heartbeat, 1000, 1010);
    let mut done = Vec::new();
    for millis in (1000..60_000).step_by(100) {
        if let Some(remedy) = heartbeat.remedy(at(millis)) {
            done.push((millis, remedy));
        }
    }
    use Remedy::{Reset, Subscribe};
    assert_eq!(
        done[..5],
        [
            (4000, Subscribe),
            (7000, Subscribe),
            (13_000, Subscribe),
            (25_000, Subscribe),
            (31_000, Reset)
        ]
    );
    assert!(done[5..].iter().all(|(_, remedy)| *remedy == Subscribe), "{done:?}");
}
