use std::collections::BTreeSet;

use backseat_sdk::{
    Cartesian, Event, Navigation, Outcome, Plugin, Position, Relative, Request, Restored, State, StepInput, Trackline,
    Window,
};
use backseat_sdk::{Refusal, Rule};

use crate::{Config, Kind, Prober};

const CONFIG: &str = r#"{"seed": 7, "east_min_m": -800, "east_max_m": 800, "north_min_m": -500, "north_max_m": 500,
    "depth_m": [5, 25], "altitude_m": [8, 20], "speed_mps": [1.0, 1.8]}"#;
const HALF_SECOND_NS: u64 = 500_000_000;
/// The number of steps in twenty minutes.
const DIVE: u64 = 2400;

fn config() -> Config {
    serde_json::from_str(CONFIG).unwrap()
}

fn prober(config: Config) -> Prober {
    let mut prober = Prober::new(config).unwrap();
    prober.fits = |request| !leaves(request);
    prober
}

/// Whether a line leaves a box of half the size.
fn leaves(request: &Request) -> bool {
    let outside = |position: &Position| position.latitude.abs() > 0.0025 || position.longitude.abs() > 0.0035;
    if let Request::Trackline(Trackline { start, end, .. }) = request {
        outside(start) || outside(end)
    } else {
        false
    }
}

/// Runs the steps `from` to `to` with a vehicle that stays in place, and accepts all requests that do not leave the
/// box. Returns the requests of each step.
fn dive(prober: &mut Prober, from: u64, to: u64, control: bool) -> Vec<Vec<Request>> {
    let mut events = Vec::new();
    let mut asked = Vec::new();
    for step in from..to {
        if step % 60 == 0 {
            events.push(Event::Window(Window {
                until_ns: (step + 20) * HALF_SECOND_NS,
                address: 1,
                device: "WHOI".into(),
            }));
            events.push(Event::DvlTrigger(step % 120 == 0));
        }
        let input = StepInput {
            now_ns: step * HALF_SECOND_NS,
            navigation: Some(Navigation {
                depth: 12.0,
                ..Navigation::default()
            }),
            relative: Some(Relative::default()),
            cartesian: Some(Cartesian::default()),
            control,
            events: std::mem::take(&mut events),
            ..StepInput::default()
        };
        let requests = prober.step(&input).unwrap();
        for request in &requests {
            let state = if leaves(request) {
                State::Rejected(Refusal::new(Rule::KeepIn, "keep-in"))
            } else {
                State::Accepted
            };
            if let Some(tag) = request.tag() {
                events.push(Event::Outcome(Outcome { tag, state }));
            }
        }
        asked.push(requests);
    }
    asked
}

fn kind(request: &Request) -> Option<Kind> {
    Some(match request {
        Request::Modify(_) | Request::EndModify => Kind::Modify,
        Request::Trackline(_) => Kind::Trackline,
        Request::Trackcircle(_) => Kind::Trackcircle,
        Request::Cancel(_) => Kind::Cancel,
        Request::Message(_) => Kind::Message,
        Request::GpsHit(_) => Kind::GpsHit,
        Request::Topside(_) => Kind::Topside,
        Request::DvlTrigger(_) => Kind::Dvl,
        Request::Silent(_) => Kind::Silent,
        Request::Trim(_) => Kind::Trim,
        Request::Buoyancy(_) => Kind::Buoyancy,
        Request::Packet(_) => Kind::Packet,
        Request::Station(_) | Request::EndStation => Kind::Station,
        Request::SonarAngle(_) | Request::Camera(_) | Request::Light(_) => Kind::Devices,
        Request::SonarSet(_) | Request::SonarLog(_) | Request::Timer(_) => return None,
    })
}

fn kinds(asked: &[Vec<Request>]) -> BTreeSet<Kind> {
    asked.iter().flatten().filter_map(kind).collect()
}

/// Requests cannot be compared, but their debug output can.
fn text(asked: &[Vec<Request>]) -> String {
    format!("{asked:?}")
}

#[test]
fn it_makes_requests_of_every_kind_in_one_dive() {
    let mut hovering = prober(Config {
        hovering: true,
        ..config()
    });
    let asked = dive(&mut hovering, 0, DIVE, true);
    assert_eq!(kinds(&asked).len(), 14, "{:?}", kinds(&asked));
    let mut cruising = prober(config());
    let asked = kinds(&dive(&mut cruising, 0, DIVE, true));
    assert!(!asked.contains(&Kind::Station) && !asked.contains(&Kind::Devices));
}

#[test]
fn it_makes_only_requests_of_the_configured_kinds() {
    let only = vec![Kind::Modify, Kind::Trackcircle];
    let mut prober = prober(Config {
        kinds: Some(only.clone()),
        ..config()
    });
    let asked = kinds(&dive(&mut prober, 0, DIVE, true));
    assert_eq!(asked.into_iter().collect::<Vec<_>>(), only);
}

#[test]
fn even_at_full_boldness_some_lines_are_inside_the_box() {
    for seed in 0..100 {
        let bold = Config {
            seed,
            boldness: 1.0,
            ..config()
        };
        let asked = dive(&mut prober(bold), 0, DIVE, true);
        let lines: Vec<bool> = asked
            .iter()
            .flatten()
            .filter(|request| matches!(request, Request::Trackline(_)))
            .map(leaves)
            .collect();
        let outside = lines.iter().filter(|leaves| **leaves).count();
        assert!(outside >= 2 && lines.len() - outside >= 2, "seed {seed}: {lines:?}");
    }
}

#[test]
fn its_leases_last_only_some_of_the_time() {
    let mut steps = 0;
    for seed in 0..20 {
        let asked = dive(&mut prober(Config { seed, ..config() }), 0, DIVE, true);
        let steering: Vec<u64> = (0..DIVE)
            .zip(&asked)
            .filter(|(_, requests)| requests.iter().any(|request| matches!(request, Request::Modify(_))))
            .map(|(step, _)| step)
            .collect();
        steps += steering.len();
        let pause = steering.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(DIVE);
        assert!(pause > 20, "seed {seed}: {pause} steps");
    }
    assert!(steps > 20 * 100, "{steps} steps");
}

#[test]
fn a_step_makes_no_more_requests_than_allowed() {
    for seed in 0..50 {
        let bold = Config {
            seed,
            hovering: true,
            boldness: 1.0,
            ..config()
        };
        let asked = dive(&mut prober(bold), 0, DIVE, true);
        let most = asked.iter().map(Vec::len).max().unwrap();
        assert!((40..=100).contains(&most), "seed {seed}: {most}");
    }
}

#[test]
fn without_control_only_a_bold_prober_makes_requests_and_seldom() {
    let count = |boldness| {
        let config = Config { boldness, ..config() };
        dive(&mut prober(config), 0, DIVE, false).iter().flatten().count()
    };
    assert_eq!(count(0.0), 0);
    let bold = count(1.0);
    assert!((20..1000).contains(&bold), "{bold}");
}

#[test]
fn the_same_seed_gives_the_same_requests_and_another_seed_others() {
    let run = |seed| text(&dive(&mut prober(Config { seed, ..config() }), 0, 600, true));
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn a_restored_instance_continues_as_the_old_one_would_have() {
    let mut first = prober(config());
    dive(&mut first, 0, 600, true);
    let mut second = prober(config());
    second.restore(&first.snapshot()).unwrap();
    assert_eq!(first.state, second.state);
    let (there, here) = (dive(&mut first, 600, 1200, true), dive(&mut second, 600, 1200, true));
    assert_eq!(text(&there), text(&here));
    assert!(second.restore(&[0xff; 3]).is_err());
}

#[test]
fn a_new_instance_knows_only_what_is_open() {
    let mut prober = prober(config());
    dive(&mut prober, 0, 600, true);
    let restored = Event::Restored(Restored {
        lost_steps: 1,
        open: vec![],
    });
    let input = StepInput {
        now_ns: 601 * HALF_SECOND_NS,
        events: vec![restored],
        ..StepInput::default()
    };
    prober.step(&input).unwrap();
    let inserts = format!("{:?}", prober.state.inserts);
    assert!(inserts.contains("open: []"), "{inserts}");
}

#[test]
fn an_invalid_value_is_refused_with_its_key() {
    let refusal = |config: Config| Prober::new(config).unwrap_err();
    let bold = Config {
        boldness: 1.5,
        ..config()
    };
    assert_eq!(refusal(bold), "boldness is 1.5: expected 0 to 1");
    let turned = Config {
        depth_m: [25.0, 5.0],
        ..config()
    };
    assert_eq!(refusal(turned), "depth_m is 5: expected the least, then the greatest");
    let flat = Config {
        north_max_m: -480.0,
        ..config()
    };
    assert!(refusal(flat).starts_with("north_max_m is -480"));
    let none = Config {
        speed_mps: [f64::NAN, 1.0],
        ..config()
    };
    assert!(refusal(none).starts_with("speed_mps is NaN"));
}
