//! Measures what the host adds to the cost of a step. Run `cargo run --release --example step_overhead -p
//! backseat-plugin-host -- FAULTY.wasm` with the faulty plugin that `cargo xtask plugins` builds.

#![expect(clippy::disallowed_methods, reason = "a measurement reads the clock")]

use std::sync::Arc;
use std::time::Instant;

use backseat_core::Limits;
use backseat_core::plugin::{Judge, NavigationSample, Refusal, Request, StepInput};
use backseat_fence::Fence;
use backseat_plugin_host::{Brief, Budget, Host, Plugin};
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};

/// Steps of one measurement: few, so that some measurements run without interruption by another process.
const STEPS: u64 = 2_000;
/// The number of measurements; the best one counts.
const MEASUREMENTS: u32 = 500;

const FENCE: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature",
    "properties": {"name": "bay", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3},
    "geometry": {"type": "Polygon", "coordinates": [
        [[-70.01, 41.99], [-69.99, 41.99], [-69.99, 42.01], [-70.01, 42.01], [-70.01, 41.99]]]}}]}"#;
const LIMITS: &str = r#"{"speed_min_mps": 1.0, "speed_max_mps": 2.0, "turn_rate_dps": 8.0, "current_max_mps": 0.3}"#;

struct Yes;

impl Judge for Yes {
    fn judge(&self, _: &Request, _: &StepInput) -> Result<f64, Refusal> {
        Ok(1.0)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("expected the path of faulty.wasm")?;
    let host = Host::new()?;
    let began = Instant::now();
    let component = host.load("faulty", &std::fs::read(path)?)?;
    println!("load: {:?}", began.elapsed());
    let fence = Fence::from_geojson(FENCE)?;
    let limits: Limits = serde_json::from_str(LIMITS)?;
    let start = |config: &str, snapshot_every_steps| {
        let budget = Budget {
            snapshot_every_steps,
            ..Budget::default()
        };
        let brief = Brief {
            config_json: config,
            grants: &[],
            fence: &fence,
            limits: &limits,
        };
        component
            .start(budget, &brief, Arc::new(Yes))
            .map(|started| started.plugin)
    };
    let began = Instant::now();
    for _ in 0..100 {
        start("{}", 0)?;
    }
    println!("start: {:?}", began.elapsed() / 100);
    let input = input()?;
    // With "stale" the plugin makes one request and none after that.
    measure(
        "navigation in, no request",
        &mut start(r#"{"fault": "stale"}"#, 0)?,
        &input,
    );
    measure(
        "the same, snapshot every 10 steps",
        &mut start(r#"{"fault": "stale"}"#, 10)?,
        &input,
    );
    measure("navigation in, a modify out", &mut start("{}", 0)?, &input);
    let empty = StepInput {
        navigation: None,
        ..input
    };
    measure(
        "nothing in, no request",
        &mut start(r#"{"fault": "stale"}"#, 0)?,
        &empty,
    );
    Ok(())
}

fn measure(what: &str, plugin: &mut Plugin, input: &StepInput) {
    let mut best = f64::MAX;
    let mut fuel = 0;
    for _ in 0..MEASUREMENTS {
        let began = Instant::now();
        for _ in 0..STEPS {
            let returned = plugin.step(input);
            assert!(returned.result.is_ok());
            fuel = returned.fuel;
        }
        best = best.min(began.elapsed().as_secs_f64() * 1e9 / STEPS as f64);
    }
    println!("{what}: {best:.0} ns a step, {fuel} fuel");
}

fn input() -> Result<StepInput, Box<dyn std::error::Error>> {
    let now = Timestamp::from_secs(100);
    Ok(StepInput {
        now,
        utc: Utc::from_unix_nanos(1_790_000_000_000_000_000),
        clocks_apart: None,
        navigation: Some(NavigationSample {
            solution: now,
            position: Position::from_deg(42.0, -70.0)?,
            local: EastNorth::new(100.0, 200.0),
            depth: Depth::from_m(10.0)?,
            altitude: Some(Altitude::from_m(15.0)?),
            heading: Heading::from_deg(45.0)?,
            roll_deg: 0.5,
            pitch_deg: -1.0,
            east_mps: 1.0,
            north_mps: 1.0,
            down_mps: 0.0,
            yaw_rate_dps: 0.1,
            gps: false,
        }),
        relative: None,
        cartesian: None,
        control: true,
        events: Vec::new(),
    })
}
