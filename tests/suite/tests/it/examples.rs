//! The example missions, each of which shows one topic with a plugin to copy from: each does what it is there to show,
//! in every sea and with every interpretation that the seeds draw.

use backseat_recorder::read;
use backseat_suite::{Backseat, Mission};
use serde_json::Value;

const EXAMPLES: [&str; 5] = [
    "acoustic-windows",
    "dvl-triggering",
    "gps-hits",
    "hull-inspection",
    "trim-and-buoyancy",
];
const SEEDS: [&str; 3] = ["1", "2", "3"];

/// A flight that meets all of `[expect]` without a violation, a failure of its plugin, or a warning.
struct Flight {
    report: Value,
    /// The sentences on the link in their order, without `$` and checksum.
    sentences: Vec<String>,
}

impl Flight {
    fn of(example: &str, seed: &str) -> Self {
        let mission = Mission::copy(example);
        let path = mission.beside("run.mcap");
        let finished = Backseat::new()
            .args(["sim", "--json", "--seed", seed, "--log"])
            .arg(&path)
            .mission(&mission)
            .run()
            .exit(0);
        assert_eq!(finished.stderr, "", "{example}, seed {seed}");
        let report = finished.json();
        assert_eq!(report["violations"], Value::Array(vec![]), "{report}");
        assert_eq!(
            report["plugin_failures"].as_object().map(serde_json::Map::len),
            Some(0),
            "{report}"
        );
        let log = read(&path).expect("the log can be read");
        // A read or a write may hold a part of a sentence, so each direction is joined first.
        let mut sentences = Vec::new();
        for direction in [true, false] {
            let mut rest = String::new();
            for (at, from_vehicle, bytes) in log.link() {
                if from_vehicle == direction {
                    rest.push_str(&String::from_utf8_lossy(bytes));
                    while let Some((line, after)) = rest.split_once("\r\n") {
                        let body = line.trim_start_matches('$');
                        let body = body.split_once('*').map_or(body, |(body, _)| body);
                        sentences.push((at, body.to_owned()));
                        rest = after.to_owned();
                    }
                }
            }
        }
        sentences.sort_by_key(|(at, _)| *at);
        let sentences = sentences.into_iter().map(|(_, body)| body).collect();
        Self { report, sentences }
    }

    /// The sentences of these names, without the time: `BPDVR,1,0`.
    fn said(&self, names: &[&str]) -> Vec<String> {
        let of_name = |sentence: &&String| names.iter().any(|name| sentence.split(',').next() == Some(*name));
        let without_time = |sentence: &String| {
            let mut fields = sentence.splitn(3, ',');
            let (name, _, rest) = (fields.next(), fields.next(), fields.next());
            [name, rest].into_iter().flatten().collect::<Vec<_>>().join(",")
        };
        self.sentences.iter().filter(of_name).map(without_time).collect()
    }

    fn count(&self, name: &str) -> usize {
        self.said(&[name]).len()
    }

    fn published(&self, name: &str) -> f64 {
        self.report["published"][name]["value"]
            .as_f64()
            .unwrap_or_else(|| panic!("{name} is not published: {}", self.report))
    }
}

/// Against a plain zigzag over the same area: the same plugin, which then turns at the sides alone.
#[test]
fn a_front_is_followed_while_it_moves() {
    for seed in SEEDS {
        let flight = Flight::of("front", seed);
        let plain = Backseat::new()
            .args(["sim", "--json", "--seed", seed])
            .args(["--set", "plugin.front.config.adaptive=false"])
            .mission(&Mission::copy("front"))
            .run()
            .exit(1)
            .json();
        let share = plain["published"]["front.in_front"]["value"].as_f64().unwrap_or(0.0);
        let adaptive = flight.published("front.in_front");
        assert!(adaptive > 1.5 * share, "{adaptive} % against {share} %");
    }
}

/// Against a lawnmower of the same way, which makes its map by the same process.
#[test]
fn a_search_knows_warm_water_better_than_a_lawnmower() {
    for seed in SEEDS {
        let deviation = Flight::of("informative", seed).published("informative.warm_deviation");
        let plain = Backseat::new()
            .args(["sim", "--json", "--seed", seed])
            .args(["--set", "plugin.informative.config.adaptive=false"])
            .mission(&Mission::copy("informative"))
            .run();
        let plain = plain.json();
        let even = plain["published"]["informative.warm_deviation"]["value"].as_f64();
        assert!(
            even.is_some_and(|even| even > 1.2 * deviation),
            "{even:?} C against {deviation} C"
        );
    }
}

/// SPI 7.7.
#[test]
fn a_vehicle_whose_position_drifts_surfaces_for_fixes() {
    for seed in SEEDS {
        let flight = Flight::of("gps-hits", seed);
        let hits = flight.count("BPRGP");
        assert!((2..=5).contains(&hits), "{hits}");
        // A hit that the mission's end cuts off has no fix.
        let fixes = flight.published("gps-hits.fixes");
        assert!(fixes == hits as f64 || fixes + 1.0 == hits as f64, "{fixes} of {hits}");
        // The place in the lane is never asked for.
        let in_lane = |said: &String| said.contains(",07042.000");
        assert!(
            !flight.said(&["BPRGP"]).iter().any(in_lane),
            "{:?}",
            flight.said(&["BPRGP"])
        );
        assert_eq!(flight.report["requests"]["rejected"], 0, "{}", flight.report);
    }
}

/// SPI 9.
#[test]
fn reports_cross_the_water_in_windows_and_an_order_comes_back() {
    let mut lost = 0;
    for seed in SEEDS {
        let flight = Flight::of("acoustic-windows", seed);
        assert!(flight.count("BPCPD") >= 10, "{}", flight.count("BPCPD"));
        assert_eq!(
            flight.count("BFCPS"),
            flight.count("BPCPD"),
            "each packet has its report"
        );
        // Status 2 is acknowledged; the frames of a lost packet have another.
        let reports = flight.said(&["BFCPS"]);
        lost += reports
            .iter()
            .filter(|said| said.split(',').nth(4) != Some("2"))
            .count();
        // The order to dive to 20 m is flown by modifies.
        assert!(flight.count("BPRMB") > 100, "{}", flight.count("BPRMB"));
    }
    assert!(lost > 0, "some packets are lost, and repeated");
}

/// SPI 7.4.
#[test]
fn the_payload_triggers_the_dvl_and_gives_it_back_when_it_must() {
    for seed in SEEDS {
        let flight = Flight::of("dvl-triggering", seed);
        let handshake = flight.said(&["BPDVR", "BFDVT"]);
        let begins = ["BPDVR,1,0", "BFDVT,1", "BPDVR,1,1"];
        let (first, rest) = handshake.split_at(3);
        assert_eq!(first, begins);
        // The vehicle takes it back, and allows it again.
        assert_eq!(rest[..4], ["BFDVT,0", "BPDVR,1,0", "BFDVT,1", "BPDVR,1,1"]);
        // The line is dead: the plugin gives the DVL back, and begins anew.
        assert_eq!(rest[4..8], ["BPDVR,0,0", "BPDVR,1,0", "BFDVT,1", "BPDVR,1,1"]);
        assert_eq!(rest[8..], ["BPDVR,0,0"]);
    }
}

/// SPI 7.22 to 7.24.
#[test]
fn a_stop_in_the_plan_is_used_for_buoyancy_trim_and_silence() {
    let mut tried = 0;
    for seed in SEEDS {
        let flight = Flight::of("trim-and-buoyancy", seed);
        let mut said = flight.said(&["BPBOY", "BPTRM", "BPSIL"]);
        tried += said.len();
        said.dedup();
        assert_eq!(said, ["BPBOY", "BPTRM", "BPSIL,1", "BPSIL,0"]);
        // The vehicle is silent, and says nothing by its modem; it goes on with its plan.
        assert_eq!(flight.report["outcome"], "completed");
    }
    assert!(tried >= 4 * SEEDS.len(), "{tried}");
}

/// SPI 8.
#[test]
fn a_hull_is_inspected_place_by_place() {
    for seed in SEEDS {
        let flight = Flight::of("hull-inspection", seed);
        let mut places = flight.said(&["BPGHP"]);
        places.dedup();
        assert_eq!(places.len(), 12, "{places:?}");
        assert_eq!((flight.count("BPSUS"), flight.count("BPRES")), (1, 1));
        // The three places beside the screw are refused by the box around it.
        assert_eq!(flight.report["requests"]["rejected"], 3, "{}", flight.report);
        assert!(
            flight.report["rejections"]
                .to_string()
                .contains("keep_out_hull 'screw'"),
            "{}",
            flight.report
        );
        assert!(flight.count("BPLIT") >= 24, "{}", flight.count("BPLIT"));
    }
}

#[test]
fn without_its_grants_no_example_is_flown() {
    for example in EXAMPLES {
        let mission = Mission::copy(example);
        let text = mission.read("mission.toml");
        let granted = text.lines().find(|line| line.starts_with("grants = ")).expect("grants");
        let mission = mission.edit("mission.toml", granted, "grants = []");
        for command in ["sim", "check"] {
            let refused = Backseat::new().arg(command).mission(&mission).run();
            let said = format!("{refused}");
            assert!(said.contains(&format!("plugin `{example}`")), "{said}");
            assert!(said.contains(": needs the grant"), "{said}");
            assert!(said.contains("to `grants` of this plugin in mission.toml"), "{said}");
            let _ = refused.exit(if command == "sim" { 2 } else { 1 });
        }
    }
}

#[test]
fn check_has_nothing_to_say_against_an_example() {
    for example in EXAMPLES {
        let checked = Backseat::new()
            .arg("check")
            .mission(&Mission::copy(example))
            .run()
            .exit(0);
        assert_eq!(checked.stdout.lines().last(), Some("ready"), "{checked}");
        assert!(!format!("{checked}").contains("WARN"), "{checked}");
    }
}
