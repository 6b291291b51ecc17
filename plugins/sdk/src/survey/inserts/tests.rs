use super::*;
use crate::{EndKind, Ended, Outcome, Refusal};

fn line(index: u32) -> Leg {
    let north_m = 50.0 * f64::from(index);
    Leg::Line(Line {
        start: EastNorth::new(0.0, north_m),
        end: EastNorth::new(300.0, north_m),
    })
}

fn queue(count: u32) -> InsertQueue {
    let mut queue = InsertQueue::default();
    queue.extend((0..count).map(line));
    queue
}

fn at(now_s: u64) -> StepInput {
    StepInput {
        now_ns: now_s * SECOND_NS,
        control: true,
        ..StepInput::default()
    }
}

fn hear(queue: &mut InsertQueue, tag: u64, state: &State, now_s: u64) -> Turn {
    queue.hear(tag, state, &at(now_s), 1.5, || false)
}

fn done() -> State {
    State::Ended(Ended::new(EndKind::Done, "flown"))
}

fn flight() -> Flight {
    Flight {
        frame: LocalFrame::new(backseat_units::Position::from_deg(42.0, -70.0).unwrap()),
        vertical: Vertical::Depth(15.0),
        speed_mps: 1.5,
    }
}

fn tags(requests: &[Request]) -> Vec<u64> {
    requests.iter().filter_map(Request::tag).collect()
}

#[test]
fn some_legs_are_kept_at_the_vehicle_and_none_is_requested_twice() {
    let mut queue = queue(5);
    assert_eq!(queue.step(&StepInput::default(), &flight()), [], "without control");
    assert_eq!(tags(&queue.step(&at(0), &flight())), [1, 2, 3]);
    assert_eq!(hear(&mut queue, 1, &State::Started, 0), Turn::Began);
    queue.fly(EastNorth::new(290.0, 0.0), EastNorth::new(1.5, 0.0));
    let ended = Event::Outcome(Outcome { tag: 1, state: done() });
    let input = StepInput {
        events: vec![ended],
        ..at(200)
    };
    assert_eq!(tags(&queue.step(&input, &flight())), [4]);
    assert_eq!(queue.tasks()[0].standing, Standing::Flown);
    assert_eq!(queue.step(&at(201), &flight()), []);
    let off = StepInput {
        events: vec![Event::Shutdown],
        ..at(202)
    };
    assert_eq!(queue.step(&off, &flight()), []);
    hear(&mut queue, 2, &State::Cancelled, 203);
    assert_eq!(queue.step(&at(300), &flight()), [], "the power goes off");
}

#[test]
fn only_the_first_of_nothing_open_interrupts() {
    let mut queue = InsertQueue::new(QueueSettings {
        interrupt: true,
        ..QueueSettings::default()
    });
    queue.extend((0..2).map(line));
    let interrupts: Vec<bool> = queue
        .step(&at(0), &flight())
        .iter()
        .map(|request| matches!(request, Request::Trackline(line) if line.interrupt))
        .collect();
    assert_eq!(interrupts, [true, false]);
}

#[test]
fn a_line_that_ended_too_early_is_flown_again_and_given_up_after_three_tries() {
    let mut queue = queue(1);
    queue.ask(0);
    for (try_, now_s) in [(1, 0), (2, 100), (3, 200)] {
        hear(&mut queue, try_, &State::Started, now_s);
        let early = State::Ended(Ended::new(EndKind::Behavior, "interrupted"));
        let turn = hear(&mut queue, try_, &early, now_s + 20);
        if try_ == 3 {
            assert_eq!(turn, Turn::Dropped("ended too early: interrupted".to_owned()));
            break;
        }
        assert_eq!(turn, Turn::Again("ended too early: interrupted".to_owned()));
        assert_eq!(
            queue.ask((now_s + 21) * SECOND_NS),
            None,
            "the leg is not requested again at once"
        );
        assert_eq!(queue.ask((now_s + 26) * SECOND_NS), Some((0, try_ + 1)));
    }
    assert!(queue.is_done() && !queue.last_flown());
}

#[test]
fn a_reached_cap_uses_up_no_attempts_of_a_leg() {
    let mut queue = queue(4);
    for _ in 0..3 {
        queue.ask(0);
    }
    for attempt in 0..200 {
        let now_s = 10 * attempt;
        let tag = queue.next_tag - 1;
        let capped = State::Rejected(Refusal::new(Rule::Cap, "over the cap"));
        hear(&mut queue, tag, &capped, now_s);
        assert_eq!(queue.ask((now_s + 6) * SECOND_NS), Some((2, tag + 1)));
    }
    assert_eq!(queue.tasks[2].leg, line(2), "the leg is not made smaller");
}

#[test]
fn legs_are_flown_in_their_order_although_the_first_is_refused_at_first() {
    let mut queue = queue(4);
    let refused = State::Rejected(Refusal::new(Rule::Plan, "plan unknown"));
    for round in 0..12 {
        if let Some((index, tag)) = queue.ask(round * 1_000_000_000) {
            assert_eq!(index, 0, "round {round}");
            hear(&mut queue, tag, &refused, round);
        }
    }
    let (index, tag) = queue.ask(60_000_000_000).unwrap();
    assert_eq!(index, 0);
    hear(&mut queue, tag, &State::Started, 60);
    // Now the vehicle must have something to fly next, whatever is refused.
    let (index, tag) = queue.ask(61_000_000_000).unwrap();
    assert_eq!(index, 1);
    hear(&mut queue, tag, &refused, 61);
    assert_eq!(queue.ask(62_000_000_000).unwrap().0, 2);
}

#[test]
fn what_does_not_fit_is_made_smaller_until_it_is_too_small() {
    let mut queue = queue(1);
    queue.push(Leg::Circle(Circle {
        centre: EastNorth::default(),
        radius_m: 30.0,
        orbits: -2.0,
        entry_deg: None,
    }));
    assert!((queue.tasks[1].leg.length_m() - TAU * 60.0).abs() < 1e-9);
    let refused = State::Rejected(Refusal::new(Rule::KeepOut, "inside the wreck"));
    let mut turns = Vec::new();
    for round in 0..8 {
        while let Some((index, tag)) = queue.ask(round * SECOND_NS) {
            turns.push((index, queue.hear(tag, &refused, &at(round), 1.5, || true)));
        }
    }
    let smaller = |index| {
        turns
            .iter()
            .filter(|(of, turn)| *of == index && matches!(turn, Turn::Smaller { .. }))
            .count()
    };
    // 300, 200 and 100 m; 30, 22.5 and 16.9 m.
    assert_eq!((smaller(0), smaller(1)), (2, 2), "{turns:?}");
    assert!(queue.is_done());
}

#[test]
fn refusals_without_control_and_answers_to_nobody_count_for_nothing() {
    let mut queue = queue(1);
    queue.ask(0);
    let refused = State::Rejected(Refusal::new(Rule::Control, "no control"));
    assert_eq!(hear(&mut queue, 77, &refused, 1), Turn::Quiet);
    let without = StepInput {
        control: false,
        ..at(1)
    };
    let turn = queue.hear(1, &refused, &without, 1.5, || true);
    assert_eq!(turn, Turn::Again("no control".to_owned()));
    assert_eq!(queue.tasks[0].leg, line(0));
}

#[test]
fn a_new_instance_continues_with_what_is_open() {
    let mut queue = queue(5);
    for _ in 0..3 {
        queue.ask(0);
    }
    hear(&mut queue, 1, &State::Started, 0);
    let restored = |open: &[u64]| Restored {
        lost_steps: 3,
        open: open.to_vec(),
    };
    // The first has ended unseen, a fourth has been requested, and a tag of another kind is open.
    queue.restored(&restored(&[2, 3, 4, InsertQueue::OTHER_TAGS]), SECOND_NS);
    assert_eq!(queue.tasks[0].standing, Standing::Flown);
    assert_eq!(queue.task_of(4), Some(3));
    assert_eq!(queue.ask(SECOND_NS), None);
    let input = StepInput {
        events: vec![Event::Restored(restored(&[2, 3, 4, 5, 6]))],
        ..at(2)
    };
    assert_eq!(
        queue.step(&input, &flight()),
        [Request::Cancel(6)],
        "no leg is left for it"
    );
    assert_eq!((queue.task_of(5), queue.strays()), (Some(4), &[6][..]));
    hear(&mut queue, 6, &State::Cancelled, 2);
    assert!(queue.strays().is_empty());
}

#[test]
fn a_line_whose_beginning_was_missed_in_a_restart_counts_as_flown_when_it_ends() {
    let mut queue = queue(2);
    queue.ask(0);
    let restored = Restored {
        lost_steps: 2,
        open: vec![1],
    };
    // It began in the lost steps.
    queue.restored(&restored, SECOND_NS);
    let Leg::Line(on) = line(0) else { panic!("a line") };
    let along = (on.end - on.start) * (1.5 / on.length_m());
    queue.fly(on.at(0.9 * on.length_m()), along);
    assert!(queue.tasks[0].progress > 0.8, "{:?}", queue.tasks[0]);
    assert_eq!(hear(&mut queue, 1, &done(), 400), Turn::Flown);
}

#[test]
fn progress_counts_on_the_line_and_in_its_direction() {
    let mut queue = queue(1);
    queue.ask(0);
    hear(&mut queue, 1, &State::Started, 0);
    let fly = |queue: &mut InsertQueue, (east_m, north_m), east_mps| {
        queue.fly(EastNorth::new(east_m, north_m), EastNorth::new(east_mps, 0.0));
        queue.last_progress()
    };
    assert_eq!(fly(&mut queue, (150.0, 30.0), 1.5), 0.0, "beside it");
    assert_eq!(fly(&mut queue, (150.0, 3.0), -1.5), 0.0, "towards its start");
    assert_eq!(fly(&mut queue, (150.0, 3.0), 1.5), 0.5);
    assert_eq!(fly(&mut queue, (90.0, 3.0), 1.5), 0.5);
    assert_eq!(fly(&mut queue, (320.0, 3.0), 1.5), 1.0);
    assert_eq!(hear(&mut queue, 1, &done(), 200), Turn::Flown);
    assert!(queue.is_done() && queue.last_flown());
}

#[test]
fn a_plan_that_stays_unknown_makes_no_leg_smaller() {
    let mut queue = queue(1);
    let length_m = queue.tasks[0].leg.length_m();
    let hear_again = |queue: &mut InsertQueue, rule: Rule| {
        let refused = State::Rejected(Refusal::new(rule, "refused"));
        (0..13_u64).for_each(|round| {
            let now_s = 5 * round + 100 * u64::from(rule != Rule::Plan);
            if let Some((_, tag)) = queue.ask(now_s * SECOND_NS) {
                hear(queue, tag, &refused, now_s);
            }
        });
    };
    hear_again(&mut queue, Rule::Plan);
    assert_eq!(queue.tasks[0].leg.length_m(), length_m);
    // The way to the leg leaves the fence, which a plugin cannot ask: a smaller one is tried.
    hear_again(&mut queue, Rule::KeepIn);
    assert!(queue.tasks[0].leg.length_m() < length_m);
}
