//! Plugins that fly in a basin: the harness and the vehicle of `backseat_sdk::testing`.

use std::time::Duration;

use backseat_sdk::survey::{Circle, Flight, InsertQueue, Leg, Line, Rectangle, Standing, Timers};
use backseat_sdk::testing::{Basin, Fault, Harness};
use backseat_sdk::units::{EastNorth, LocalFrame};
use backseat_sdk::{
    Briefing, Description, EndKind, Event, Grant, Modify, Plugin, Refusal, Request, Rule, State, StepInput, Vertical,
    fence, log, measures,
};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

/// Flies a lawnmower and a circle; or, with a heading, steers.
struct Survey {
    config: Config,
    frame: LocalFrame,
    state: Kept,
    ends: Vec<EndKind>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    heading_deg: Option<f64>,
}

#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Kept {
    queue: InsertQueue,
    timers: Timers,
    rings: u32,
}

impl Plugin for Survey {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "survey".into(),
            version: "0".into(),
            step_period_ns: 1_000_000_000,
            topics: vec![],
            grants: vec![Grant::Insert],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        Ok(Self {
            config,
            frame: Briefing::default().frame()?,
            state: Kept::default(),
            ends: Vec::new(),
        })
    }

    fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
        self.frame = briefing.frame()?;
        Ok(())
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        if input.now_ns == 10_000_000_000 {
            requests.push(self.state.timers.start("ring", Duration::from_secs(3), input));
            if self.config.heading_deg.is_none() {
                let area = Rectangle::new(EastNorth::new(200.0, 0.0), 400.0, 200.0, 30.0);
                let lines = area.lawnmower(50.0, EastNorth::default());
                self.state.queue.extend(lines.into_iter().map(Leg::Line));
                self.state.queue.push(Leg::Circle(Circle {
                    centre: EastNorth::new(-300.0, 100.0),
                    radius_m: 60.0,
                    orbits: 1.5,
                    entry_deg: Some(90.0),
                }));
            }
        }
        for event in &input.events {
            if let Event::Outcome(outcome) = event
                && let State::Ended(end) = &outcome.state
            {
                self.ends.push(end.kind);
            }
        }
        self.state.rings += self.state.timers.expired(input).len() as u32;
        if let Some(heading) = self.config.heading_deg
            && input.control
        {
            requests.push(Request::Modify(Modify {
                tag: 7,
                heading,
                vertical: Vertical::Altitude(20.0),
                speed: 2.0,
                duration_ns: 5_000_000_000,
            }));
            return Ok(requests);
        }
        let flight = Flight {
            frame: self.frame,
            vertical: Vertical::Depth(20.0),
            speed_mps: 1.5,
        };
        requests.extend(self.state.queue.step(input, &flight));
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

#[test]
fn a_survey_is_flown_in_its_order() {
    let mut basin = Basin::<Survey>::new("{}").unwrap();
    let flight = basin.fly(Duration::from_secs(3600));
    let queue = &basin.harness.plugin.state.queue;
    assert!(queue.tasks().iter().all(|task| task.standing == Standing::Flown));
    assert_eq!(flight.flown, flight.accepted);
    assert_eq!(flight.flown.len(), 5);
    assert_eq!(flight.rejected, 0);
    let area = Rectangle::new(EastNorth::new(200.0, 0.0), 400.0, 200.0, 30.0);
    for line in area.lawnmower(50.0, EastNorth::default()) {
        assert!(flight.nearest_m(line.start) < 5.0 && flight.nearest_m(line.end) < 5.0);
    }
    // Half of the circle is flown twice: its southernmost point is on it.
    assert!(flight.nearest_m(EastNorth::new(-300.0, 40.0)) < 5.0);
    assert!((basin.depth_m - 20.0).abs() < 0.1);
    assert_eq!(basin.harness.plugin.state.rings, 1, "the timer has rung once");
    let lines = basin.harness.lines();
    assert!(lines.iter().any(|(_, line)| line == "leg 5 of 5 flown"), "{lines:?}");
}

#[test]
fn a_vehicle_that_is_steered_turns_and_keeps_its_altitude() {
    let mut basin = Basin::<Survey>::new(r#"{"heading_deg": 0}"#).unwrap();
    basin.water_depth_m = |place| 50.0 - 0.01 * place.north_m;
    let flight = basin.fly(Duration::from_secs(600));
    assert!((basin.heading_deg).abs() < 1e-6);
    assert!(
        basin.place.north_m > 1100.0 && basin.place.east_m < 40.0,
        "{:?}",
        basin.place
    );
    assert!(((basin.water_depth_m)(basin.place) - basin.depth_m - 20.0).abs() < 0.5);
    assert!(flight.flown.is_empty());
    assert!(
        basin.harness.plugin.ends.is_empty(),
        "each modify refreshes the one before"
    );
    // When control is lost the modify ends, and the vehicle goes straight on.
    basin.faults = vec![Fault::NoControl {
        from: Duration::from_secs(10),
        lasts: Duration::from_secs(20),
    }];
    basin.fly(Duration::from_secs(60));
    assert_eq!(basin.harness.plugin.ends, [EndKind::Control]);
}

#[test]
fn what_lies_outside_of_the_basin_is_refused_and_made_smaller() {
    let mut basin = Basin::<Survey>::new("{}").unwrap();
    basin.fence_m = 330.0;
    let flight = basin.fly(Duration::from_secs(3600));
    assert!(flight.rejected > 0);
    let tasks = basin.harness.plugin.state.queue.tasks();
    let shorter = tasks
        .iter()
        .any(|task| matches!(task.leg, Leg::Line(Line { .. }) if task.leg.length_m() < 399.0));
    assert!(shorter, "{tasks:?}");
    assert!(basin.harness.plugin.state.queue.is_done());
}

#[test]
fn the_fence_of_a_harness_answers_the_plugin_and_its_log_and_measures_are_kept() {
    struct Asks;
    impl Plugin for Asks {
        type Config = backseat_sdk::NoConfig;
        fn describe() -> Description {
            Description {
                grants: vec![],
                ..Survey::describe()
            }
        }
        fn new(_: Self::Config) -> Result<Self, String> {
            log::info!("here");
            Ok(Self)
        }
        fn step(&mut self, _: &StepInput) -> Result<Vec<Request>, String> {
            let room = fence::check(&Request::EndModify);
            measures::publish("room", room.as_ref().copied().unwrap_or(-1.0), "m");
            Ok(vec![Request::Message("x".repeat(300))])
        }
    }
    let mut harness = Harness::<Asks>::new("{}").unwrap();
    assert_eq!(
        harness.step(vec![]).unwrap_err(),
        "a message of 300 bytes, more than 256"
    );
    harness.set_fence(|_| Some(Refusal::new(Rule::KeepOut, "the wreck")));
    harness.step(vec![]).unwrap_err();
    assert_eq!(harness.measures("room"), [1000.0, -1.0]);
    assert_eq!(harness.measures("else"), [0.0; 0]);
    assert_eq!(harness.lines().len(), 1);
    let typo = Harness::<Survey>::new(r#"{"heading": 3}"#).err().unwrap();
    assert!(typo.contains("unknown field `heading`"), "{typo}");
    let without = Harness::<Survey>::with_briefing("{}", Briefing::default())
        .err()
        .unwrap();
    assert_eq!(without, "needs the grant insert");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn a_survey_ends_whatever_happens(seed: u64) {
        let mut basin = Basin::<Survey>::new("{}").unwrap();
        basin.faults = Fault::draw(seed);
        let flight = basin.fly(Duration::from_secs(3 * 3600));
        prop_assert!(flight.failures.is_empty());
        prop_assert!(basin.harness.plugin.state.queue.is_done(), "{:?}", basin.harness.plugin.state.queue);
        // The same faults, the same flight.
        let mut again = Basin::<Survey>::new("{}").unwrap();
        again.faults = Fault::draw(seed);
        prop_assert_eq!(again.fly(Duration::from_secs(3 * 3600)), flight);
    }
}

/// What a plugin hears of its last step in a flight comes at the beginning of the next one.
#[test]
fn many_short_flights_are_one_long_one() {
    let mut long = Basin::<Survey>::new("{}").unwrap();
    let whole = long.fly(Duration::from_secs(7200)).flown.len();
    let mut short = Basin::<Survey>::new("{}").unwrap();
    let parts: usize = (0..7200).map(|_| short.fly(Duration::from_secs(1)).flown.len()).sum();
    assert!(whole > 3, "{whole} inserts are flown");
    assert_eq!(parts, whole);
    assert!(short.harness.plugin.state.queue.is_done(), "no leg stays open");
}
