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
    queue.hear(tag, state, &at(now_s), 1.5, |_| true)
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

fn circle(radius_m: f64) -> Leg {
    Leg::Circle(Circle {
        centre: EastNorth::default(),
        radius_m,
        orbits: -2.0,
        entry_deg: None,
    })
}

/// What becomes of a leg that the runtime refuses and of which only a part fits into the fence: the turn, the leg, and how
/// often the fence was asked.
fn refused(leg: Leg, fits: impl Fn(&Leg) -> bool) -> (Turn, Leg, usize) {
    let mut queue = InsertQueue::default();
    queue.push(leg);
    queue.ask(0);
    let mut asked = 0;
    let refused = State::Rejected(Refusal::new(Rule::KeepOut, "inside the wreck"));
    let turn = queue.hear(1, &refused, &at(1), 1.5, |leg| {
        asked += 1;
        fits(leg)
    });
    if matches!(turn, Turn::Smaller { .. }) {
        assert_eq!(queue.ask(SECOND_NS), Some((0, 2)), "it is requested again at once");
    } else {
        assert_eq!(queue.ask(1000 * SECOND_NS), None, "it is given up");
    }
    (turn, queue.tasks[0].leg, asked)
}

fn smaller(sizes: &str) -> Turn {
    Turn::Smaller {
        sizes: sizes.to_owned(),
        why: "inside the wreck".to_owned(),
    }
}

/// Whether a leg lies in so many metres east.
fn lies_in(leg: &Leg, bounds: Range<f64>) -> bool {
    let Leg::Line(line) = leg else { return false };
    let (west, east) = (
        line.start.east_m.min(line.end.east_m),
        line.start.east_m.max(line.end.east_m),
    );
    west >= bounds.start - 1e-6 && east <= bounds.end + 1e-6
}

#[test]
fn a_line_is_cut_where_it_does_not_fit_and_nowhere_else() {
    let cut = |bounds: Range<f64>| {
        let (turn, leg, asked) = refused(line(0), |leg| lies_in(leg, bounds.clone()));
        let Leg::Line(line) = leg else { panic!("a line") };
        (turn, line.start.east_m.round(), line.end.east_m.round(), asked)
    };
    // The line has six parts of 50 m, and the fence is asked about the line, its parts and the rest.
    assert_eq!(cut(-10.0..220.0), (smaller("300 m to 200 m"), 0.0, 200.0, 8));
    assert_eq!(cut(90.0..310.0), (smaller("300 m to 200 m"), 100.0, 300.0, 8));
    assert_eq!(cut(40.0..290.0), (smaller("300 m to 200 m"), 50.0, 250.0, 8));
    // Its parts are too short, or none fits.
    let given_up = Turn::Dropped("inside the wreck".to_owned());
    assert_eq!(cut(100.0..170.0), (given_up.clone(), 0.0, 300.0, 8));
    assert_eq!(cut(400.0..500.0), (given_up, 0.0, 300.0, 7));
}

#[test]
fn of_a_line_through_a_keep_out_zone_the_longer_part_is_flown() {
    let (turn, leg, _) = refused(line(0), |leg| lies_in(leg, 0.0..100.0) || lies_in(leg, 150.0..300.0));
    let Leg::Line(line) = leg else { panic!("a line") };
    assert_eq!(turn, smaller("300 m to 150 m"));
    assert_eq!((line.start.east_m.round(), line.end.east_m.round()), (150.0, 300.0));
}

#[test]
fn a_line_whose_parts_fit_but_not_the_whole_loses_both_ends() {
    let (turn, leg, _) = refused(line(0), |leg| leg.length_m() < 150.0);
    assert_eq!(turn, smaller("300 m to 100 m"));
    assert!(lies_in(&leg, 100.0..200.0), "{leg:?}");
}

#[test]
fn a_long_line_costs_no_more_questions_than_a_short_one() {
    let long = Leg::Line(Line {
        start: EastNorth::new(0.0, 0.0),
        end: EastNorth::new(24_000.0, 0.0),
    });
    let (turn, _, asked) = refused(long, |leg| lies_in(leg, 0.0..9_500.0));
    assert_eq!((turn, asked), (smaller("24000 m to 9000 m"), 1 + PARTS_MAX + 1));
}

#[test]
fn a_circle_is_made_smaller_until_it_fits_or_is_too_small() {
    let radius_below = |most_m: f64| move |leg: &Leg| matches!(leg, Leg::Circle(circle) if circle.radius_m < most_m);
    assert_eq!(
        refused(circle(30.0), radius_below(20.0)).0,
        smaller("radius 30 m to radius 17 m")
    );
    let (turn, leg, _) = refused(circle(30.0), radius_below(16.0));
    assert_eq!(
        (turn, leg),
        (Turn::Dropped("inside the wreck".to_owned()), circle(30.0))
    );
    assert!((leg.length_m() - TAU * 60.0).abs() < 1e-9);
}

#[test]
fn a_circle_that_shall_not_shrink_is_given_up() {
    let mut queue = InsertQueue::new(QueueSettings {
        shrink: 1.0,
        ..QueueSettings::default()
    });
    queue.push(circle(30.0));
    queue.ask(0);
    let refused = State::Rejected(Refusal::new(Rule::KeepOut, "inside the wreck"));
    let turn = queue.hear(1, &refused, &at(1), 1.5, |_| false);
    assert_eq!(turn, Turn::Dropped("inside the wreck".to_owned()));
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
    let turn = queue.hear(1, &refused, &without, 1.5, |_| false);
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
