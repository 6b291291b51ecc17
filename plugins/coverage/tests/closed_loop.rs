//! The plugin surveys drawn seabeds with a simple vehicle and a simulated sidescan, in closed loop: how much it sees for
//! its way, and how it behaves when something goes wrong.

#![expect(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "in a harness, everything unexpected fails the test"
)]

mod sea;

use backseat_sdk::units::EastNorth;
use backseat_sdk::{Event, Failure, Plugin, Refusal, Request, Restored, Rule, SonarSetting, State, StepInput};
use coverage::Coverage;
use sea::{Gives, HALF, SHELF, SLOPE, Trial, config, plugin};

/// The plugin that also sets the range.
fn ranging() -> Coverage {
    let mut config = config();
    config["range"] = serde_json::json!({"per_altitude": 4.0, "min_m": 75.0, "max_m": 120.0});
    plugin(config)
}

#[test]
fn it_sees_nearly_everything_and_knows_what_it_has_seen() {
    for (seabed, least, way_max_m) in [(SHELF, 0.98, 9500.0), (SLOPE, 0.98, 8500.0)] {
        for seed in 0..4 {
            let plugin = if seabed == SHELF { plugin(config()) } else { ranging() };
            let mut trial = Trial::new(seed, seabed, plugin);
            trial.run();
            let (part, believed) = (trial.part(), trial.plugin.part());
            assert!(trial.done, "world {seed} does not end");
            assert!(part >= least, "{part} in world {seed}");
            assert!(
                (part - believed).abs() < 0.012,
                "{part} is truly seen, and {believed} believed, in world {seed}"
            );
            assert!(trial.way_m < way_max_m, "{} m in world {seed}", trial.way_m);
            assert!(
                trial.most_open <= 2 && trial.gaps == 0,
                "{} open, {} s lost",
                trial.most_open,
                trial.gaps
            );
        }
    }
}

#[test]
fn a_fixed_spacing_of_the_same_way_sees_less() {
    for seed in 0..4 {
        let mut trial = Trial::new(seed, SLOPE, plugin(config()));
        trial.run();
        // As many even lines as fit into the same way, each with its transit to the next one.
        let count = ((trial.way_m + 60.0) / (2.0 * HALF.east_m + 60.0 + 2.0 * HALF.north_m / 9.0)).round();
        let spacing_m = 2.0 * HALF.north_m / count;
        let lines = (0..count as u32).map(|index| {
            let north_m = HALF.north_m - (f64::from(index) + 0.5) * spacing_m;
            let side = if index % 2 == 0 { 1.0 } else { -1.0 };
            (
                EastNorth::new(-side * HALF.east_m, north_m),
                EastNorth::new(side * HALF.east_m, north_m),
            )
        });
        let mut mower = Trial::new(seed, SLOPE, plugin(config()));
        mower.mow(lines);
        let (part, fixed) = (trial.part(), mower.part());
        assert!(part > fixed + 0.01, "{part} and {fixed} in world {seed}");
        assert!(
            (mower.way_m / trial.way_m - 1.0).abs() < 0.15,
            "{} and {} m",
            mower.way_m,
            trial.way_m
        );
    }
}

#[test]
fn the_reported_swath_takes_the_place_of_pings() {
    let mut trial = Trial::new(1, SHELF, plugin(config()));
    trial.gives = Gives::Swaths;
    trial.run();
    assert!(trial.part() > 0.98, "{}", trial.part());
    assert!((trial.part() - trial.plugin.part()).abs() < 0.012);
}

#[test]
fn without_a_sonar_it_gives_up() {
    let mut trial = Trial::new(1, SHELF, plugin(config()));
    trial.gives = Gives::Nothing;
    trial.run();
    assert!(
        trial.done && trial.messages[0].contains("the sonar shows nothing"),
        "{:?}",
        trial.messages
    );
    assert!(trial.lines.len() <= 4, "{:?}", trial.lines);
}

#[test]
fn a_restored_instance_continues_identically() {
    let mut trial = Trial::new(5, SLOPE, ranging());
    for _ in 0..2400 {
        trial.step();
    }
    let snapshot = trial.plugin.snapshot();
    assert!(snapshot.len() < 60_000, "{}", snapshot.len());
    let mut second = ranging();
    second.restore(&snapshot).unwrap();
    for _ in 0..4000 {
        let input = trial.input();
        let requests = trial.plugin.step(&input).unwrap();
        assert_eq!(requests, second.step(&input).unwrap());
        trial.fly(&requests);
    }
    assert!(trial.done, "the comparison covers the rest of the survey");
    assert_eq!(trial.plugin.snapshot(), second.snapshot());
    assert!(second.restore(&snapshot[..9]).unwrap_err().contains("does not parse"));
    let mut other = config();
    other["cell_m"] = 4.0.into();
    assert!(plugin(other).restore(&snapshot).unwrap_err().contains("other cells"));
}

#[test]
fn after_a_failure_nothing_is_requested_twice_and_the_survey_succeeds() {
    let mut trial = Trial::new(2, SHELF, plugin(config()));
    for _ in 0..1500 {
        trial.step();
    }
    let (snapshot, before) = (trial.plugin.snapshot(), trial.asked);
    for _ in 0..700 {
        trial.step();
    }
    let lost = trial.asked - before;
    trial.plugin = plugin(config());
    trial.plugin.restore(&snapshot).unwrap();
    trial.events = vec![Event::Restored(Restored {
        lost_steps: 700,
        open: trial.open_tags(),
    })];
    trial.run();
    assert!(lost >= 1 && trial.done, "{lost} {:?}", trial.messages);
    assert!(trial.part() > 0.97, "{}", trial.part());
    // At most the lines that were flown unseen are flown again.
    assert!(trial.asked <= 10 + lost, "{} asked", trial.asked);
}

#[test]
fn a_line_that_does_not_fit_is_shortened_and_then_given_up() {
    // The fence ends 70 m before the eastern edge, and has nothing in the south.
    let check = |request: &Request| match request {
        Request::Trackline(line) if line.start.longitude.max(line.end.longitude) > -70.5960 => {
            Some(Refusal::new(Rule::KeepIn, "keep-in zone 'box' left by 31.2 m"))
        }
        Request::Trackline(line) if line.start.latitude < 42.2990 => Some(Refusal::new(Rule::Depth, "too deep")),
        _ => None,
    };
    let mut trial = Trial::new(3, SHELF, plugin(config()).with_fence(check));
    trial.run();
    assert!(trial.done, "{:?}", trial.messages);
    let east_m = trial
        .lines
        .iter()
        .map(|(from, to)| from.east_m.max(to.east_m))
        .fold(0.0, f64::max);
    assert!((280.0..335.0).contains(&east_m), "{east_m}");
    assert!(
        trial.lines.iter().all(|(from, _)| from.north_m > -112.0),
        "{:?}",
        trial.lines
    );
    assert!((0.4..0.8).contains(&trial.part()), "{}", trial.part());
    assert!(trial.asked < 40, "{}", trial.asked);
}

#[test]
fn failures_and_passing_refusals_are_tried_again_a_bounded_number_of_times() {
    let mut flaky = Trial::new(4, SHELF, plugin(config()));
    flaky.answer = |_, asked| match asked % 5 {
        1 => Some(State::Failed(Failure::Vehicle("busy".into()))),
        2 => Some(State::TimedOut),
        3 => Some(State::Rejected(Refusal::new(
            Rule::Plan,
            "plan unknown: cannot check the way to the insert",
        ))),
        _ => None,
    };
    flaky.run();
    assert!(
        flaky.done && flaky.part() > 0.95,
        "{} {:?}",
        flaky.part(),
        flaky.messages
    );

    let mut dead = Trial::new(4, SHELF, plugin(config()));
    dead.answer = |_, _| Some(State::TimedOut);
    dead.run();
    assert!(dead.done && dead.lines.is_empty(), "{:?}", dead.messages);
    assert!(dead.asked <= 3 * 40, "{}", dead.asked);
}

#[test]
fn without_control_it_makes_no_requests_and_continues_when_control_returns() {
    let mut trial = Trial::new(6, SHELF, plugin(config()));
    for _ in 0..1000 {
        trial.step();
    }
    trial.control = false;
    let asked = trial.asked;
    for _ in 0..1800 {
        trial.step();
    }
    assert_eq!(trial.asked, asked);
    trial.control = true;
    trial.run();
    assert!(trial.done && trial.part() > 0.97, "{}", trial.part());
}

#[test]
fn the_noise_is_heard_before_the_first_line_and_the_power_comes_back() {
    /// At so little power, percent, the seabed drowns in the noise before the end of the range.
    const WEAK: f64 = 0.1;
    let listening = || {
        let mut config = config();
        config["range_m"] = 140.0.into();
        config["noise"] = serde_json::json!({"pings": 20, "power_percent": WEAK});
        plugin(config)
    };
    let trial = |plugin| {
        let mut trial = Trial::new(7, SHELF, plugin);
        trial.range_m = 140.0;
        trial.power = WEAK;
        trial
    };
    let mut hearing = trial(listening());
    hearing.run();
    assert_eq!(hearing.settings, [SonarSetting::Power(0.0), SonarSetting::Power(WEAK)]);
    // Lines by what truly comes back are closer than lines by the range.
    let mut believing = trial(plugin(
        serde_json::from_str(&config().to_string().replace("75.0", "140.0")).unwrap(),
    ));
    believing.run();
    assert!(
        hearing.lines.len() > believing.lines.len(),
        "{} {}",
        hearing.lines.len(),
        believing.lines.len()
    );
    assert!(hearing.part() > 0.98, "{}", hearing.part());

    // A sonar that takes no settings is surveyed with as it is, and is not asked without end.
    let mut refusing = trial(listening());
    refusing.answer = |request, _| matches!(request, Request::SonarSet(_)).then_some(State::TimedOut);
    for _ in 0..600 {
        refusing.step();
    }
    assert!(
        (2..=61).contains(&refusing.settings.len()),
        "{}",
        refusing.settings.len()
    );
    assert!(!refusing.lines.is_empty(), "the survey begins");
}

#[test]
fn an_empty_input_is_accepted() {
    let mut plugin = plugin(config());
    assert_eq!(plugin.step(&StepInput::default()).unwrap(), []);
    let control = StepInput {
        control: true,
        ..StepInput::default()
    };
    assert_eq!(plugin.step(&control).unwrap(), []);
}
