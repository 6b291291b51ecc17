//! Prints the speed table of the plugins and the whole loop.

use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use backseat_bench::{HEADER, Stages, best_stages, in_turn, row};
use backseat_core::plugin::{NavigationSample, StepInput};
use backseat_core::{Envelope, Grant, Limits};
use backseat_fence::Fence;
use backseat_mission::{Layers, Mission};
use backseat_mvc::ClientId;
use backseat_plugin_host::{Brief, Budget, Host};
use backseat_plugin_loader::load_plugins;
use backseat_recorder::{Header, Rate, Recorder, Sources};
use backseat_scenario::Scenario;
use backseat_sim::Simulation;
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};

pub(crate) fn print() {
    println!("{HEADER}");
    step();
    whole_loop();
}

/// A square of 6 km around 42 N 70 W.
const SEA: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature",
    "properties":{"name":"sea","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},
    "geometry":{"type":"Polygon","coordinates":[[[-70.036,41.973],[-69.964,41.973],[-69.964,42.027],[-70.036,42.027],[-70.036,41.973]]]}}]}"#;

fn envelope() -> Envelope {
    let limits: Limits =
        serde_json::from_str(r#"{"speed_min_mps":1.0,"speed_max_mps":2.0,"turn_rate_dps":8.0,"current_max_mps":0.3}"#)
            .expect("these are limits");
    Envelope::new(Fence::from_geojson(SEA).expect("a square is a fence"), limits)
}

fn navigation() -> NavigationSample {
    NavigationSample {
        solution: Timestamp::ZERO,
        position: Position::from_deg(42.0, -70.0).expect("a position"),
        local: EastNorth::default(),
        depth: Depth::from_m(8.0).expect("a depth"),
        altitude: Altitude::from_m(22.0).ok(),
        heading: Heading::from_deg(90.0).expect("a heading"),
        roll_deg: 0.1,
        pitch_deg: 0.2,
        east_mps: 1.5,
        north_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_dps: 0.0,
        gps: false,
    }
}

fn step() {
    let host = Host::new().expect("an engine");
    let bytes = std::fs::read(backseat_test_support::plugins().join("template.wasm")).expect("the plugin was built");
    let component = host.load("idle", &bytes).expect("a component");
    let judge = std::sync::Arc::new(envelope());
    // Without control it makes no requests, so only the host's own work remains. No snapshot is taken in between.
    let budget = Budget {
        snapshot_every_steps: 0,
        ..Budget::default()
    };
    let brief = Brief {
        config_json: r#"{"heading_deg":90.0,"depth_m":10.0,"speed_mps":1.5}"#,
        grants: &[Grant::Modify],
        fence: judge.fence(),
        limits: judge.limits(),
    };
    let mut plugin = component
        .start(budget, &brief, judge.clone())
        .expect("it starts")
        .plugin;
    let mut input = StepInput {
        now: Timestamp::ZERO,
        utc: Utc::default(),
        clocks_apart: None,
        navigation: Some(navigation()),
        relative: None,
        cartesian: None,
        control: false,
        events: Vec::new(),
    };
    let (mut store, call) = flat_module();
    let times = in_turn(
        50_000,
        || {
            input.now = input.now + Duration::from_millis(100);
            let returned = plugin.step(black_box(&input));
            assert!(matches!(&returned.result, Ok(requests) if requests.is_empty()));
        },
        || {
            store.set_fuel(10_000_000).expect("fuel is on");
            black_box(call.call(&mut store, (1, 2.0, 3.0, 4.0)).expect("it cannot trap"));
        },
    );
    row(
        "plugin step, navigation in, no request",
        times,
        "wasmtime's call of a flat function, with fuel and epochs",
        "600 ns",
    );
}

type Flat = wasmtime::TypedFunc<(i64, f64, f64, f64), f64>;

fn flat_module() -> (wasmtime::Store<()>, Flat) {
    let mut config = wasmtime::Config::new();
    config.consume_fuel(true).epoch_interruption(true);
    let engine = wasmtime::Engine::new(&config).expect("an engine");
    let wasm = wat::parse_str(
        r#"(module (func (export "step") (param i64 f64 f64 f64) (result f64)
            local.get 1 local.get 2 f64.add local.get 3 f64.mul))"#,
    )
    .expect("this is a module");
    let module = wasmtime::Module::new(&engine, wasm).expect("this is a module");
    let mut store = wasmtime::Store::new(&engine, ());
    store.set_fuel(u64::MAX).expect("fuel is on");
    store.set_epoch_deadline(u64::MAX / 2);
    let instance = wasmtime::Instance::new(&mut store, &module, &[]).expect("it imports nothing");
    let step = instance.get_typed_func(&mut store, "step").expect("it exports this");
    (store, step)
}

/// The whole isobath mission with its log, beside its mock vehicle alone with one subscriber. One seed is flown several
/// times: each of its minutes is the same work each time, and the best time of each counts.
fn whole_loop() {
    const REPETITIONS: usize = 12;
    let mission = Mission::load(&backseat_test_support::mission("isobath"), &Layers::default()).expect("the mission");
    let scenario = Scenario::load(&mission).expect("a world");
    let folder = tempfile::tempdir().expect("a folder");
    let host = Host::new().expect("an engine");
    let (mut ours, mut floor, mut ticks) = (Vec::new(), Vec::new(), (0.0, 0.0));
    for _ in 0..REPETITIONS {
        let (flight, flown) = fly(&mission, &scenario, &host, &folder.path().join("log.mcap"));
        let (vehicle, stepped) = vehicle_alone(&scenario);
        ours.push(flight);
        floor.push(vehicle);
        ticks = (flown, stepped);
    }
    let (best, best_floor) = (best_stages(&ours) / ticks.0, best_stages(&floor) / ticks.1);
    println!(
        "| whole loop, isobath with log | {:.0} x life, {:.2} us a tick | {:.2} us a tick (the mock vehicle alone) | {:.2} | \
         20,000 x, 5 us a tick |",
        0.1 / best,
        best * 1e6,
        best_floor * 1e6,
        best / best_floor
    );
}

const SEED: u64 = 1;

/// The seconds of each minute, of the part before the first and of the part after the last, and the number of ticks of
/// 0.1 s.
fn fly(mission: &Mission, scenario: &Scenario, host: &Host, log: &Path) -> (Vec<f64>, f64) {
    let loaded = load_plugins(host, mission, Some(backseat_test_support::plugins())).expect("the plugins");
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
    let recorder = Recorder::create(log, &header).expect("a log");
    let mut stages = Stages::start();
    let mut simulation = Simulation::new(mission, scenario, SEED, loaded, Some(recorder)).expect("a world");
    simulation.run(|_| stages.end()).expect("a log that can be written");
    let (report, _, _) = simulation.finish().expect("a log that can be closed");
    stages.end();
    (stages.seconds(), report.sim_seconds * 10.0)
}

/// As [`fly`].
fn vehicle_alone(scenario: &Scenario) -> (Vec<f64>, f64) {
    let mut vehicle = scenario.vehicle(SEED).expect("a world");
    let client = ClientId(1);
    let mut out = Vec::new();
    vehicle.connect(Timestamp::ZERO, client);
    vehicle.receive(Timestamp::ZERO, client, b"$BPLOG,NVG,ON\r\n$BPLOG,NVR,ON\r\n");
    let mut stages = Stages::start();
    let mut ticks = 0u32;
    while !vehicle.mission_over()
        && let Some(due) = vehicle.poll_timeout()
    {
        vehicle.handle_timeout(due);
        while vehicle.poll_transmit(&mut out).is_some() {
            black_box(&out);
        }
        while vehicle.poll_event().is_some() {}
        ticks += 1;
        if ticks.is_multiple_of(600) {
            stages.end();
        }
    }
    stages.end();
    (stages.seconds(), f64::from(ticks))
}
