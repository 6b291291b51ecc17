//! Prints the speed table of the plugin platform: a request out, loading from the cache, restarts, replay, six plugins at once.

#![expect(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "a benchmark reads the clock, and ends where something is missing"
)]

use std::fs::{self, File};
use std::hint::black_box;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use backseat_bench::{HEADER, in_turn, row};
use backseat_core::plugin::{NavigationSample, StepInput};
use backseat_core::{Envelope, Grant};
use backseat_mission::{Layers, Mission};
use backseat_mvc::ClientId;
use backseat_plugin_host::{Brief, Budget, Cache, Component, Host, Origin, Plugin};
use backseat_plugin_loader::load_plugins;
use backseat_recorder::{Header, LogReader, Rate, Recorder, Sources};
use backseat_replay::{Configs, Replay, Task};
use backseat_scenario::Scenario;
use backseat_sim::Simulation;
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};

/// How often loading, restarting and flying are repeated; the best time counts.
const TIMES: usize = 15;
const SEED: u64 = 1;

pub(crate) fn print() {
    println!("{HEADER}");
    let folder = tempfile::tempdir().unwrap();
    request_out();
    for (language, component, config, aims) in [
        ("Rust", "template", STEERS, ["5 ms", "2 ms"]),
        ("Python", "thermocline", PROFILES, ["50 ms", "50 ms"]),
    ] {
        starts(folder.path(), language, component, config, aims);
    }
    replay(folder.path());
    six(folder.path());
}

const PROFILES: &str = r#"{"heading_deg":90.0,"speed_mps":1.5,"shallowest_m":5.0,"deepest_m":42.0,"half_span_m":5.0}"#;
const STEERS: &str = r#"{"heading_deg":90.0,"depth_m":10.0,"speed_mps":1.5}"#;

fn component_bytes(name: &str) -> Vec<u8> {
    fs::read(backseat_test_support::plugins().join(format!("{name}.wasm"))).unwrap()
}

fn mission(name: &str) -> Mission {
    Mission::load(&backseat_test_support::mission(name), &Layers::default()).unwrap()
}

fn start(component: &Component, config: &str, budget: Budget, judge: &Arc<Envelope>) -> Plugin {
    let brief = Brief {
        config_json: config,
        grants: &[Grant::Modify, Grant::Insert, Grant::Message],
        fence: judge.fence(),
        limits: judge.limits(),
    };
    component.start(budget, &brief, judge.clone()).unwrap().plugin
}

fn navigation() -> NavigationSample {
    NavigationSample {
        solution: Timestamp::ZERO,
        position: Position::from_deg(42.35, -70.7).unwrap(),
        local: EastNorth::default(),
        depth: Depth::from_m(8.0).unwrap(),
        altitude: Altitude::from_m(22.0).ok(),
        heading: Heading::from_deg(90.0).unwrap(),
        roll_deg: 0.1,
        pitch_deg: 0.2,
        east_mps: 1.5,
        north_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_dps: 0.0,
        gps: false,
    }
}

/// The least time of this work, seconds.
fn best_s<T>(mut work: impl FnMut() -> T) -> f64 {
    (0..TIMES)
        .map(|_| {
            let begun = Instant::now();
            let made = black_box(work());
            let took_s = begun.elapsed().as_secs_f64();
            drop(made);
            took_s
        })
        .fold(f64::MAX, f64::min)
}

/// A step that returns a modify, beside one of the same plugin that returns nothing.
fn request_out() {
    let host = Host::new().unwrap();
    let component = host.load("restless", &component_bytes("restless")).unwrap();
    let judge = Arc::clone(&mission("isobath").envelope);
    let budget = Budget {
        snapshot_every_steps: 0,
        ..Budget::default()
    };
    let [mut asks, mut idles] = [(); 2].map(|()| start(&component, STEERS, budget.clone(), &judge));
    let mut input = StepInput {
        now: Timestamp::ZERO,
        utc: Utc::default(),
        clocks_apart: None,
        navigation: Some(navigation()),
        relative: None,
        cartesian: None,
        control: true,
        events: Vec::new(),
    };
    let idle = StepInput {
        control: false,
        ..input.clone()
    };
    let times = in_turn(
        50_000,
        || {
            input.now = input.now + Duration::from_millis(100);
            let returned = asks.step(black_box(&input));
            assert!(matches!(&returned.result, Ok(requests) if requests.len() == 1));
        },
        || {
            let returned = idles.step(black_box(&idle));
            assert!(matches!(&returned.result, Ok(requests) if requests.is_empty()));
        },
    );
    row(
        "plugin step, navigation in, one request out",
        times,
        "the same without a request",
        "1500 ns",
    );
}

/// Loading from the cache, beside reading the component and the compiled code from the disk; and a restart, beside the first start.
fn starts(folder: &Path, language: &str, name: &str, config: &str, [load_aim, restart_aim]: [&str; 2]) {
    let folder = folder.join(format!("cache-{language}"));
    let file = backseat_test_support::plugins().join(format!("{name}.wasm"));
    if !file.is_file() {
        println!("| load and restart a {language} plugin | not measured: `cargo xtask python` builds it | | | |");
        return;
    }
    let bytes = fs::read(&file).unwrap();
    let host = || Host::new().unwrap().with_cache(Some(Cache::new(&folder, |_| {})));
    let _kept = host().load(name, &bytes).unwrap();
    let kept: Vec<PathBuf> = files(&folder);
    let loaded_s = best_s(|| {
        let component = host().load(name, &fs::read(&file).unwrap()).unwrap();
        assert_eq!(component.origin(), Origin::Cache);
        component
    });
    let read_s = best_s(|| (fs::read(&file).unwrap(), kept.iter().map(fs::read).collect::<Vec<_>>()));
    println!(
        "| load a {language} plugin from the cache, {:.1} MB | {:.2} ms | {:.2} ms (reading both files) | {:.2} | {load_aim} |",
        bytes.len() as f64 / 1e6,
        1e3 * loaded_s,
        1e3 * read_s,
        loaded_s / read_s
    );
    let judge = Arc::clone(&mission("thermocline").envelope);
    let component = host().load(name, &bytes).unwrap();
    let begun_s = best_s(|| start(&component, config, Budget::default(), &judge));
    let mut plugin = start(&component, config, Budget::default(), &judge);
    let restarted_s = best_s(|| assert!(plugin.restart().result.is_ok()));
    println!(
        "| restart a {language} plugin | {:.3} ms | {:.3} ms (its first start, with `describe`) | {:.2} | {restart_aim} |",
        1e3 * restarted_s,
        1e3 * begun_s,
        restarted_s / begun_s
    );
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found
}

/// Flies a mission with its log. Returns how long it took, and how long it lasted, seconds.
fn fly(mission: &Mission, host: &Host, log: &Path) -> (f64, f64) {
    let scenario = Scenario::load(mission).unwrap();
    let loaded = load_plugins(host, mission, Some(backseat_test_support::plugins())).unwrap();
    let header = Header {
        utc_at_start: scenario.world.start.utc,
        rate: Rate::Simulation,
        mission: &mission.name,
        seed: Some(SEED),
        resolved_mission: &mission.resolved,
        fence: &mission.fence_text,
        origin: mission.envelope.fence().frame().origin(),
        world: Some(&scenario.text),
        components: &loaded.components,
        version: env!("CARGO_PKG_VERSION"),
        sources: Sources::default(),
    };
    let recorder: Recorder<BufWriter<File>> = Recorder::create(log, &header).unwrap();
    let begun = Instant::now();
    let mut simulation = Simulation::new(mission, &scenario, SEED, loaded, Some(recorder)).unwrap();
    simulation.run(|_| {}).unwrap();
    let (report, _, _) = simulation.finish().unwrap();
    (begun.elapsed().as_secs_f64(), report.sim_seconds)
}

/// A recorded simulation replayed, beside the simulation.
fn replay(folder: &Path) {
    let host = Host::new()
        .unwrap()
        .with_cache(Some(Cache::new(folder.join("cache"), |_| {})));
    let (mission, log) = (mission("isobath"), folder.join("replay.mcap"));
    let (mut flown, mut played) = ((f64::MAX, 0.0), f64::MAX);
    for _ in 0..TIMES {
        let flight = fly(&mission, &host, &log);
        flown = if flight.0 < flown.0 { flight } else { flown };
        let mut reader = LogReader::open(&log).unwrap();
        let configs = Configs { set: &[], whole: &[] };
        let task = Task::of(&reader, configs).unwrap();
        let mut replay = Replay::new(task, &host, Vec::new(), 1).unwrap();
        let begun = Instant::now();
        while let Some(message) = reader.next_message().unwrap() {
            let _goes_on = replay.take(message).unwrap();
        }
        let report = replay.finish(reader.is_complete());
        played = played.min(begun.elapsed().as_secs_f64());
        assert_eq!(report.identical, Some(true), "{:?}", report.lines());
    }
    println!(
        "| replay of isobath | {:.0} x life | {:.0} x life (its simulation, with log) | {:.2} | the simulation's speed |",
        flown.1 / played,
        flown.1 / flown.0,
        played / flown.0
    );
}

/// Isobath with five more plugins that step as often, beside the mock vehicle alone.
fn six(folder: &Path) {
    let (from, to) = (backseat_test_support::mission("isobath"), folder.join("six"));
    fs::create_dir(&to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let file = entry.unwrap().path();
        fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
    }
    let path = to.join("mission.toml");
    let mut text = fs::read_to_string(&path).unwrap();
    for number in 2..=6 {
        text += &format!(
            "\n[[plugin]]\nname = \"plugin-{number}\"\ncomponent = \"isobath\"\ngrants = [\"modify\", \"message\"]\n\
             [plugin.config]\ncontour_m = 30.0\ndepth_m = 8.0\nspeed_mps = 1.5\nalong_deg = 90.0\ndeeper_toward_deg = 0.0\n"
        );
    }
    fs::write(&path, text).unwrap();
    let mission = Mission::load(&to, &Layers::default()).unwrap();
    let host = Host::new()
        .unwrap()
        .with_cache(Some(Cache::new(folder.join("cache"), |_| {})));
    let scenario = Scenario::load(&mission).unwrap();
    let (mut ours, mut alone) = ((f64::MAX, 0.0), f64::MAX);
    for _ in 0..TIMES {
        let flight = fly(&mission, &host, &folder.join("six.mcap"));
        ours = if flight.0 < ours.0 { flight } else { ours };
        alone = alone.min(vehicle_alone_s(&scenario));
    }
    println!(
        "| isobath with six plugins, on one core | {:.0} x life | {:.0} x life (the mock vehicle alone) | {:.2} | 10,000 x |",
        ours.1 / ours.0,
        ours.1 / alone,
        ours.0 / alone
    );
}

/// How long the mock vehicle takes for the same mission with one subscriber, seconds.
fn vehicle_alone_s(scenario: &Scenario) -> f64 {
    let mut vehicle = scenario.vehicle(SEED).unwrap();
    let (client, mut out) = (ClientId(1), Vec::new());
    let begun = Instant::now();
    vehicle.connect(Timestamp::ZERO, client);
    vehicle.receive(Timestamp::ZERO, client, b"$BPLOG,NVG,ON\r\n$BPLOG,NVR,ON\r\n");
    while !vehicle.mission_over()
        && let Some(due) = vehicle.poll_timeout()
    {
        vehicle.handle_timeout(due);
        while vehicle.poll_transmit(&mut out).is_some() {
            black_box(&out);
        }
        while vehicle.poll_event().is_some() {}
    }
    begun.elapsed().as_secs_f64()
}
