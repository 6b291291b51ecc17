//! Prints the speed table of the fence, the plugins and the whole loop.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use backseat_bench::{HEADER, Stages, best_stages, in_turn, row};
use backseat_core::plugin::{NavigationSample, StepInput};
use backseat_core::{Envelope, Limits};
use backseat_fence::{Fence, Shape, Sweep, VerticalExtent};
use backseat_mission::{Layers, Mission};
use backseat_mvc::ClientId;
use backseat_plugin_host::{Budget, Host};
use backseat_plugin_loader::load_plugins;
use backseat_recorder::{Header, Rate, Recorder};
use backseat_scenario::Scenario;
use backseat_sim::Simulation;
use backseat_units::{Altitude, Depth, EastNorth, Heading, LocalFrame, Position, Timestamp, Utc};

fn main() {
    // `cargo test --benches` runs this too, and has no time for it.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("{HEADER}");
    fence(100);
    fence(10_000);
    reachable();
    index(10_000);
    step();
    whole_loop();
}

/// A star-shaped fence with so many vertices, around 42 N 70 W.
fn star(vertices: usize) -> (String, Vec<EastNorth>) {
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("a position"));
    let points: Vec<EastNorth> = (0..vertices)
        .map(|vertex| {
            let bearing = 360.0 * vertex as f64 / vertices as f64;
            let radius = 3000.0 + if vertex % 2 == 0 { 0.0 } else { 2.0e3 / vertices as f64 };
            EastNorth::default().offset(bearing, radius)
        })
        .collect();
    let mut ring = String::new();
    for point in points.iter().chain(points.first()) {
        let position = frame.to_position(*point);
        let comma = if ring.is_empty() { "" } else { "," };
        write!(
            ring,
            "{comma}[{},{}]",
            position.longitude.as_deg(),
            position.latitude.as_deg()
        )
        .expect("a string");
    }
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{"name":"star","kind":"inclusion","margin_m":10,"depth_max_m":50,"altitude_min_m":3}},"geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}]}}"#
    );
    (text, points)
}

fn fence(vertices: usize) {
    let (text, points) = star(vertices);
    let fence = Fence::from_geojson(&text).expect("a star is a fence");
    let extent = VerticalExtent {
        depth_min_m: 10.0,
        depth_max_m: 20.0,
        altitude_min_m: 5.0,
    };
    let legs: Vec<(EastNorth, EastNorth)> = (0..64)
        .map(|leg| {
            let start = EastNorth::default().offset(f64::from(leg) * 37.0, f64::from(leg) * 40.0);
            (start, start.offset(f64::from(leg) * 101.0, 300.0))
        })
        .collect();
    let (mut ours, mut floor) = (0, 0);
    let times = in_turn(
        // All legs some times over in each part.
        if vertices > 1000 { 16 * 256 } else { 16 * 1024 },
        || {
            let (start, end) = legs[ours % legs.len()];
            ours += 1;
            black_box(
                fence
                    .check(
                        &Sweep {
                            shape: Shape::leg(start, end),
                            radius_m: 20.0,
                        },
                        &extent,
                    )
                    .is_ok(),
            );
        },
        || {
            let (start, end) = legs[floor % legs.len()];
            floor += 1;
            black_box(scan(&points, start, end));
        },
    );
    let aim = if vertices > 1000 { "2000 ns" } else { "400 ns" };
    row(
        &format!("leg + margin against {vertices} vertices"),
        times,
        "plain scan of the edges",
        aim,
    );
}

/// What core asks of the fence for a modify: the reachable set with the way back to the planned leg, and with that to
/// what comes next. The fence is a jagged coast: its radius jumps by up to 20 m from vertex to vertex.
fn reachable() {
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("a position"));
    let vertices = 10_000;
    let points: Vec<EastNorth> = (0..vertices)
        .map(|vertex| {
            let jag = f64::from((vertex * 7919) % 101) / 5.0;
            EastNorth::default().offset(360.0 * f64::from(vertex) / f64::from(vertices), 3000.0 + jag)
        })
        .collect();
    let ring: Vec<String> = points
        .iter()
        .chain(points.first())
        .map(|point| {
            let position = frame.to_position(*point);
            format!("[{},{}]", position.longitude.as_deg(), position.latitude.as_deg())
        })
        .collect();
    let fence = Fence::from_geojson(&format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{"name":"coast","kind":"inclusion","margin_m":10,"depth_max_m":50,"altitude_min_m":3}},"geometry":{{"type":"Polygon","coordinates":[[{}]]}}}}]}}"#,
        ring.join(",")
    ))
    .expect("a coast is a fence");
    let extent = VerticalExtent {
        depth_min_m: 10.0,
        depth_max_m: 20.0,
        altitude_min_m: 5.0,
    };
    let places: Vec<[EastNorth; 5]> = (0..64)
        .map(|at| {
            let (at, start) = (
                f64::from(at),
                EastNorth::default().offset(f64::from(at) * 37.0, f64::from(at) * 30.0),
            );
            let end = start.offset(at * 53.0, 600.0);
            let here = start + (end - start) * 0.4;
            [
                here,
                here.offset(at * 101.0, 12.0),
                start,
                end,
                end.offset(at * 53.0 + 90.0, 100.0),
            ]
        })
        .collect();
    let (mut ours, mut floor) = (0, 0);
    let times = in_turn(
        5_000,
        || {
            let [here, ahead, start, end, next] = places[ours % places.len()];
            ours += 1;
            let ways = [
                Shape::quadrilateral([here, ahead, start, end]),
                Shape::triangle(here, ahead, next),
            ];
            black_box(
                fence
                    .check_all(&ways, 55.0, &extent, [extent.depth_min_m, extent.depth_max_m])
                    .is_ok(),
            );
        },
        || {
            let [here, ahead, start, end, _] = places[floor % places.len()];
            floor += 1;
            black_box(scan(&points, here, ahead).min(scan(&points, start, end)));
        },
    );
    row(
        "a modify's reachable set against a coast of 10000 vertices",
        times,
        "plain scan of the edges for its corners",
        "5000 ns",
    );
}

/// A fence from its file to its first answer: text, projection, all that makes a polygon refused, and the index.
fn index(vertices: usize) {
    let (text, _) = star(vertices);
    let times = in_turn(
        5,
        || {
            black_box(Fence::from_geojson(black_box(&text)).expect("a star is a fence"));
        },
        || {
            black_box(serde_json::from_str::<serde_json::Value>(black_box(&text)).expect("it is JSON"));
        },
    );
    row(
        &format!("index built, {vertices} vertices, from the file's text"),
        times,
        "the text read as JSON",
        "10000000 ns",
    );
}

/// The least distance of a leg's ends from the edges, every edge looked at.
fn scan(points: &[EastNorth], start: EastNorth, end: EastNorth) -> f64 {
    let mut least = f64::MAX;
    for (index, from) in points.iter().enumerate() {
        let to = points[(index + 1) % points.len()];
        let along = to - *from;
        let length = along.east_m * along.east_m + along.north_m * along.north_m;
        for end in [start, end] {
            let out = end - *from;
            let share = ((out.east_m * along.east_m + out.north_m * along.north_m) / length).clamp(0.0, 1.0);
            let off = out - along * share;
            least = least.min(off.east_m * off.east_m + off.north_m * off.north_m);
        }
    }
    least.sqrt()
}

fn envelope() -> Envelope {
    let limits: Limits =
        serde_json::from_str(r#"{"speed_min_mps":1.0,"speed_max_mps":2.0,"turn_rate_dps":8.0,"current_max_mps":0.3}"#)
            .expect("these are limits");
    Envelope::new(Fence::from_geojson(&star(100).0).expect("a star is a fence"), limits)
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
    // Without control it asks for nothing: what is left is the host's own work. No snapshot comes between.
    let budget = Budget {
        snapshot_every_steps: 0,
        ..Budget::default()
    };
    let mut plugin = component
        .start(budget, r#"{"heading_deg":90.0,"depth_m":10.0,"speed_mps":1.5}"#, judge)
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

/// The isobath mission whole, with its log, beside its mock vehicle alone with one subscriber. One seed some times over:
/// each minute of it is the same work each time, and its best time counts.
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

/// The seconds of each minute, of what is before the first and of what comes after the last, and the ticks of 0.1 s.
fn fly(mission: &Mission, scenario: &Scenario, host: &Host, log: &Path) -> (Vec<f64>, f64) {
    let loaded = load_plugins(host, mission, Some(backseat_test_support::plugins())).expect("the plugins");
    let header = Header {
        utc_at_start: scenario.world.start.utc,
        rate: Rate::Simulation,
        mission: &mission.name,
        seed: Some(SEED),
        resolved_mission: &mission.resolved,
        fence: &mission.fence_text,
        components: &loaded.components,
        version: env!("CARGO_PKG_VERSION"),
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
