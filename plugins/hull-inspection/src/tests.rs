use backseat_sdk::{Ended, Outcome, Refusal};

use super::*;

fn config() -> Config {
    Config {
        horizontal_m: [-10.0, 10.0],
        depth_m: [1.0, 3.0],
        columns: 2,
        rows: 2,
        distance_m: 4.0,
        speed_mps: 0.4,
        within_m: 0.3,
        stay_s: 5.0,
        way_max_s: 60.0,
    }
}

fn plugin() -> HullInspection {
    HullInspection::new(config()).unwrap()
}

/// A step at a place beside the hull: along it and at a depth. The vertical position counts upwards.
fn step(plugin: &mut HullInspection, seconds: f64, (horizontal, depth): (f64, f64), events: &[Event]) -> Vec<Request> {
    let input = StepInput {
        now_ns: nanoseconds(seconds),
        control: true,
        relative: Some(Relative {
            horizontal,
            vertical: -depth,
            distance: 4.0,
            depth,
            ..Relative::default()
        }),
        events: events.to_vec(),
        ..StepInput::default()
    };
    plugin.step(&input).unwrap()
}

/// Tag and place of the station keeping that was asked for.
fn asked(requests: &[Request]) -> Option<(u64, f64, f64)> {
    requests.iter().find_map(|request| {
        if let Request::Station(station) = request
            && let StationTarget::Hull(at) = station.target
        {
            Some((station.tag, at.horizontal, at.vertical))
        } else {
            None
        }
    })
}

fn outcome(tag: u64, state: Fate) -> [Event; 1] {
    [Event::Outcome(Outcome { tag, state })]
}

const START: (f64, f64) = (0.0, 2.0);
const FIRST: (f64, f64) = (-10.0, 1.0);

#[test]
fn the_places_go_to_and_fro() {
    let at: Vec<(f64, f64)> = places(&config())
        .iter()
        .map(|place| (place.horizontal_m, place.depth_m))
        .collect();
    assert_eq!(at, [(-10.0, 1.0), (10.0, 1.0), (10.0, 3.0), (-10.0, 3.0)]);
}

#[test]
fn it_asks_for_a_place_renews_and_stays_before_the_next() {
    let mut plugin = plugin();
    assert_eq!(asked(&step(&mut plugin, 0.0, START, &[])), Some((1, -10.0, -1.0)));
    assert_eq!(asked(&step(&mut plugin, 4.5, START, &[])), None);
    assert_eq!(asked(&step(&mut plugin, 5.0, START, &[])), Some((1, -10.0, -1.0)));
    let there = step(&mut plugin, 9.0, FIRST, &[]);
    assert!(
        matches!(there[..], [Request::Light(light)] if light.on && light.tag == 2),
        "{there:?}"
    );
    step(&mut plugin, 10.0, FIRST, &[]);
    let next = step(&mut plugin, 14.0, FIRST, &[]);
    assert_eq!(asked(&next), Some((3, 10.0, -1.0)));
    assert_eq!(plugin.state.inspected, 1);
}

#[test]
fn the_vertical_position_has_the_sign_of_the_vehicle() {
    let mut plugin = plugin();
    let input = StepInput {
        control: true,
        relative: Some(Relative {
            vertical: 2.0,
            depth: 2.0,
            ..Relative::default()
        }),
        ..StepInput::default()
    };
    assert_eq!(asked(&plugin.step(&input).unwrap()), Some((1, -10.0, 1.0)));
    // At the surface it cannot be known.
    let mut plugin = self::plugin();
    assert_eq!(step(&mut plugin, 0.0, (0.0, 0.1), &[]), []);
}

#[test]
fn a_place_in_a_forbidden_box_is_left_out() {
    let mut plugin = plugin();
    step(&mut plugin, 0.0, START, &[]);
    let refused = Fate::Rejected(Refusal::new(Rule::Station, "in keep-out box 'screw'"));
    let next = step(&mut plugin, 0.5, START, &outcome(1, refused));
    assert_eq!(asked(&next), Some((2, 10.0, -1.0)));
    assert_eq!((plugin.state.left_out, plugin.state.inspected), (1, 0));
}

#[test]
fn a_place_that_is_not_reached_is_left_out() {
    let mut plugin = plugin();
    step(&mut plugin, 0.0, START, &[]);
    assert_eq!(asked(&step(&mut plugin, 59.5, START, &[])), Some((1, -10.0, -1.0)));
    assert_eq!(asked(&step(&mut plugin, 60.0, START, &[])), Some((2, 10.0, -1.0)));
}

#[test]
fn other_refusals_and_ends_are_tried_again() {
    for fate in [
        Fate::Rejected(Refusal::new(Rule::Navigation, "navigation is stale")),
        Fate::Ended(Ended::new(EndKind::Control, "the vehicle has control")),
        Fate::TimedOut,
    ] {
        let mut plugin = plugin();
        step(&mut plugin, 0.0, START, &[]);
        assert_eq!(step(&mut plugin, 1.0, START, &outcome(1, fate)), []);
        assert_eq!(asked(&step(&mut plugin, 3.0, START, &[])), Some((2, -10.0, -1.0)));
        assert_eq!(plugin.state.left_out, 0);
    }
}

#[test]
fn at_the_end_it_gives_the_vehicle_back() {
    let mut plugin = plugin();
    let mut said = Vec::new();
    for (number, place) in places(&config()).into_iter().enumerate() {
        for second in 0..=6 {
            let seconds = f64::from(number as u32 * 7 + second);
            said = step(&mut plugin, seconds, (place.horizontal_m, place.depth_m), &[]);
            if plugin.state.over {
                break;
            }
        }
    }
    assert!(
        matches!(said[..], [Request::EndStation, Request::Light(light)] if !light.on),
        "{said:?}"
    );
    assert_eq!(plugin.state.inspected, 4);
    assert_eq!(step(&mut plugin, 100.0, START, &[]), []);
}

#[test]
fn a_new_instance_goes_on_at_its_place() {
    let mut first = plugin();
    step(&mut first, 0.0, START, &[]);
    first.state.at = 2;
    let mut second = plugin();
    second.restore(&first.snapshot()).unwrap();
    assert_eq!(second.state, first.state);
    let restored = [Event::Restored(backseat_sdk::Restored {
        lost_steps: 1,
        open: vec![],
    })];
    step(&mut second, 1.0, START, &restored);
    assert_eq!(asked(&step(&mut second, 4.0, START, &[])), Some((2, 10.0, -3.0)));
    assert!(second.restore(&[255; 3]).is_err());
}

#[test]
fn invalid_settings_are_refused() {
    let refused = |config| HullInspection::new(config).unwrap_err();
    assert!(refused(Config { columns: 1, ..config() }).starts_with("columns"));
    assert!(
        refused(Config {
            depth_m: [3.0, 1.0],
            ..config()
        })
        .starts_with("depth_m")
    );
    assert!(
        refused(Config {
            speed_mps: f64::NAN,
            ..config()
        })
        .starts_with("speed_mps")
    );
}
