//! Prints the speed table of the sonars: the simulation with a sidescan, and the client beside core.

use std::hint::black_box;

use backseat_bench::{HEADER, Stages, best_stages};
use backseat_mission::{Layers, Mission};
use backseat_plc::{ClientId, Ping, Plc, PlcConfig, Pose, Pulse, SensorKind, Sonar as Acoustics, Stored};
use backseat_plugin_host::Host;
use backseat_plugin_loader::load_plugins;
use backseat_scenario::Scenario;
use backseat_sim::Simulation;
use backseat_sonar::{Input, SonarConfig};
use backseat_sonar_bridge::{Act, Bridge};
use backseat_units::{EastNorth, LocalFrame, Position, Timestamp, Utc};

pub(crate) fn print() {
    println!("{HEADER}");
    whole_loop("quick look: 455 samples a side, 5 pings/s", 455, 220, 200, "5,000 x");
    whole_loop("full: 8,333 samples a side, 10 pings/s", 8333, 12, 100, "100 x");
    client();
}

const SEED: u64 = 1;
const REPETITIONS: usize = 3;
/// The two-way time of 75 m at 1500 m/s.
const RANGE_M: f64 = 75.0;

/// The isobath mission with a sidescan that pings all the time, beside the acoustics of as many pings alone.
fn whole_loop(name: &str, samples: usize, interval_us: u32, period_ms: u32, aim: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let mission = with_sonar(folder.path(), interval_us, period_ms);
    let scenario = Scenario::load(&mission).expect("a world");
    let host = Host::new().expect("an engine");
    let (mut ours, mut floor, mut seconds) = (Vec::new(), Vec::new(), 0.0);
    for _ in 0..REPETITIONS {
        let loaded = load_plugins(&host, &mission, Some(backseat_test_support::plugins())).expect("the plugins");
        let mut stages = Stages::start();
        let mut simulation = Simulation::new(&mission, &scenario, SEED, loaded, None).expect("a world");
        simulation.run(|_| stages.end()).expect("nothing is written");
        let (report, _, _) = simulation.finish().expect("nothing is written");
        stages.end();
        seconds = report.sim_seconds;
        ours.push(stages.seconds());
        floor.push(acoustics_alone(
            &scenario,
            samples,
            interval_us,
            seconds * 1000.0 / f64::from(period_ms),
        ));
    }
    let (best, best_floor) = (best_stages(&ours) / seconds, best_stages(&floor) / seconds);
    println!(
        "| sim with sonar, {name} | {:.0} x life, {:.0} us a second | {:.0} us a second (the acoustics alone) | {:.2} | {aim} |",
        1.0 / best,
        best * 1e6,
        best_floor * 1e6,
        best / best_floor
    );
}

/// A copy of the isobath mission with a sidescan.
fn with_sonar(folder: &std::path::Path, interval_us: u32, period_ms: u32) -> Mission {
    let from = backseat_test_support::mission("isobath");
    for entry in std::fs::read_dir(from).expect("the mission is there") {
        let file = entry.expect("its files can be listed").path();
        std::fs::copy(&file, folder.join(file.file_name().expect("a name"))).expect("it can be copied");
    }
    let append = |file: &str, text: &str| {
        let path = folder.join(file);
        let old = std::fs::read_to_string(&path).expect("it is there");
        std::fs::write(path, old + text).expect("it can be written");
    };
    append(
        "mission.toml",
        "\n[sonar]\n[[sonar.sensor]]\nindex = 0\ndevice = 11001\nrecords = [3000]\n\n[[plugin.ping]]\nsensor = 0\n\
         samples = 455\ndecimation = \"maximum\"\n",
    );
    append(
        "world.toml",
        &format!(
            "\n[plc]\nauto_start = true\n[plc.sidescan_low]\nrange_m = {RANGE_M}\nperiod_ms = {period_ms}\n\
             sample_interval_us = {interval_us}\n\n[[plc.sensor]]\nkind = \"sidescan_low\"\nname = \"SSL\"\n\
             \n[[plc.sensor]]\nkind = \"bluefin\"\nname = \"AUV\"\n"
        ),
    );
    Mission::load(folder, &Layers::default()).expect("the mission")
}

fn acoustics_alone(scenario: &Scenario, samples: usize, interval_us: u32, pings: f64) -> Vec<f64> {
    let mut soundings = scenario.soundings(SEED).expect("a world");
    let (mut port, mut starboard) = (Vec::new(), Vec::new());
    let mut stages = Stages::start();
    let pings = pings as u32;
    for number in 1..=pings {
        let ping = Ping {
            number,
            time: Timestamp::from_millis(u64::from(number) * 100),
            pose: Pose {
                at: EastNorth::new(f64::from(number % 1000) * 0.3, 0.0),
                depth_m: 8.0,
                heading_deg: 90.0,
                ..Pose::default()
            },
            range_m: RANGE_M,
            pulse: Pulse {
                id: 0,
                start_hz: 105_000.0,
                end_hz: 135_000.0,
                length_s: 0.01,
            },
            power_percent: 100.0,
            gain_steps: 0,
            samples,
            sample_interval_us: interval_us,
            sound_speed_mps: 1500.0,
        };
        port.clear();
        starboard.clear();
        soundings.side_scan(SensorKind::SidescanLow, &ping, &mut port, &mut starboard);
        black_box((&port, &starboard));
        if number.is_multiple_of(600) {
            stages.end();
        }
    }
    stages.end();
    stages.seconds()
}

/// Samples without acoustics.
struct Flat;

impl Acoustics for Flat {
    fn side_scan(&mut self, _: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>) {
        port.resize(ping.samples, 1000);
        starboard.resize(ping.samples, 2000);
    }

    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>) {
        out.resize(ping.samples, [1, 2]);
    }
}

/// The client with ten pings a second of 2 x 8,333 samples, decimated to 4,096 for a plugin, beside a pass over the bytes.
fn client() {
    const SECONDS: u64 = 30;
    let config: SonarConfig =
        toml::from_str("[[sensor]]\nindex = 0\ndevice = 11001\nrecords = [3000]\n").expect("settings");
    let plc: PlcConfig = toml::from_str(
        "auto_start = true\n[sidescan_low]\nrange_m = 75\nperiod_ms = 100\nsample_interval_us = 12\n\
         [[sensor]]\nkind = \"sidescan_low\"\nname = \"SSL\"\n",
    )
    .expect("settings");
    let grant = backseat_sonar::PingGrant {
        sensor: 0,
        samples: 4096,
        decimation: backseat_sonar::Decimation::Maximum,
    };
    let pings = vec![backseat_sonar_bridge::PluginPing {
        plugin: backseat_core::plugin::PluginId(0),
        grant,
    }];
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("a position"));
    let utc = Utc::from_unix_nanos(1_780_000_000_000_000_000);
    let mut bridge = Bridge::new(config, pings, frame, utc).expect("settings");
    let mut plc = Plc::new(&plc, SEED, utc, &Stored::default()).expect("settings");
    let (mut bytes, mut received, mut seen) = (Vec::new(), 0_u64, 0_u32);
    let (mut ours, mut floor) = (0.0, 0.0);
    let mut now = Timestamp::ZERO;
    let spent = |work: &mut dyn FnMut()| -> f64 {
        let mut stages = Stages::start();
        work();
        stages.end();
        stages.seconds().iter().sum()
    };
    while now < Timestamp::from_secs(SECONDS) {
        let due = [bridge.poll_timeout(), plc.poll_timeout()];
        now = due.into_iter().flatten().min().unwrap_or(Timestamp::MAX).max(now);
        plc.truth(now, Pose::default());
        plc.handle_timeout(now, &mut Flat);
        while plc.poll_transmit(&mut bytes).is_some() {
            ours += spent(&mut || bridge.handle(now, Input::Received(&bytes)));
            received += bytes.len() as u64;
            floor += spent(&mut || {
                black_box(bytes.iter().fold(0_u32, |sum, byte| sum.wrapping_add(u32::from(*byte))));
            });
        }
        ours += spent(&mut || bridge.handle(now, Input::Timeout));
        loop {
            let mut act = None;
            ours += spent(&mut || act = bridge.poll());
            match act {
                Some(Act::Connect) => {
                    plc.connect(now, ClientId(1));
                    bridge.handle(now, Input::Connected);
                }
                Some(Act::Send(bytes)) => plc.receive(now, ClientId(1), &bytes),
                Some(Act::Report(backseat_core::FromSonar::Ping(..))) => seen += 1,
                Some(_) => {}
                None => break,
            }
        }
        while plc.poll_file().is_some() || plc.poll_event().is_some() {}
    }
    assert!(u64::from(seen) > SECONDS * 5, "{seen} pings");
    let seconds = SECONDS as f64;
    println!(
        "| client, {:.1} pings/s of 2 x 8,333 samples, {:.0} kB/s | {:.2} % of a core | {:.2} % (a sum over the bytes) | {:.2} | \
         3 % of a core |",
        f64::from(seen) / seconds,
        received as f64 / seconds / 1000.0,
        ours / seconds * 100.0,
        floor / seconds * 100.0,
        ours / floor
    );
}
