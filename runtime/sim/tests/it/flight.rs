//! A run of the tests' own mission, driven from outside.

#![expect(clippy::unwrap_used, reason = "a flight that cannot be made fails its test")]

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use backseat_core::plugin::PluginId;
use backseat_mission::{Layers, Mission, PluginTable};
use backseat_mvc::Activity;
use backseat_oracle::Violation;
use backseat_plugin_host::{Cache, Host, Plugin};
use backseat_plugin_loader::{Components, Loaded};
use backseat_scenario::Scenario;
use backseat_sim::{Report, Simulation, Step, Trace};
use backseat_spi::ToVehicle;
use backseat_units::Timestamp;

/// The mission with its plugins, compiled once.
struct Hangar {
    mission: Mission,
    scenario: Scenario,
    components: Components,
}

fn hangar() -> &'static Hangar {
    static HANGAR: OnceLock<Hangar> = OnceLock::new();
    HANGAR.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions/pair");
        let mission = Mission::load(&folder, &Layers::default()).unwrap();
        let cache = Cache::new(backseat_test_support::cache(), |_| {});
        let host = Host::new().unwrap().with_cache(Some(cache));
        let components = Components::load(&host, &mission, Some(backseat_test_support::plugins())).unwrap();
        let scenario = Scenario::load(&mission).unwrap();
        Hangar {
            mission,
            scenario,
            components,
        }
    })
}

pub(crate) fn components() -> &'static Components {
    &hangar().components
}

pub(crate) fn mission() -> &'static Mission {
    &hangar().mission
}

/// The same mission, but a behavior begins every 20 s, and the vehicle refuses each trackline.
fn in_legs() -> &'static (Mission, Scenario) {
    static LEGS: OnceLock<(Mission, Scenario)> = OnceLock::new();
    LEGS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions/legs");
        let mission = Mission::load(&folder, &Layers::default()).unwrap();
        let scenario = Scenario::load(&mission).unwrap();
        (mission, scenario)
    })
}

/// The mission's plugins, started.
pub(crate) fn crew() -> Loaded {
    components().start(mission()).unwrap()
}

/// The plugin that steers.
pub(crate) const PILOT: PluginId = PluginId(0);
/// The plugin that may ask for inserts. It asks only while a substitute runs in its slot.
pub(crate) const SECOND: PluginId = PluginId(1);

/// The faulty plugin with this fault. With `cross_fence` it asks each second for a line, which lies inside this fence.
pub(crate) fn understudy(fault: &str) -> Plugin {
    started(fault, false)
}

/// The same, but its tracklines do not interrupt.
pub(crate) fn patient_understudy(fault: &str) -> Plugin {
    started(fault, true)
}

fn started(fault: &str, after_current: bool) -> Plugin {
    let mut table: PluginTable = mission().file.plugins[0].clone();
    table.config.insert("fault".into(), fault.into());
    table.config.insert("target_east_m".into(), 600.0.into());
    table.config.insert("target_north_m".into(), 100.0.into());
    table.config.insert("after_current".into(), after_current.into());
    components().start_one("faulty", &table, mission()).unwrap()
}

pub(crate) fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Duration::from_secs_f64(seconds)
}

pub(crate) const fn seconds(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

/// A run of the mission.
pub(crate) struct Flight {
    pub(crate) sim: Simulation,
}

impl Flight {
    pub(crate) fn new(seed: u64) -> Self {
        let sim = Simulation::new(mission(), &hangar().scenario, seed, crew(), None).unwrap();
        Self { sim }
    }

    /// A run in which a process that connects later soon learns that a behavior begins.
    pub(crate) fn in_legs(seed: u64) -> Self {
        let (mission, scenario) = in_legs();
        let sim = Simulation::new(mission, scenario, seed, crew(), None).unwrap();
        Self { sim }
    }

    /// Runs to a time, or to the end of the mission if that is earlier.
    pub(crate) fn towards(&mut self, seconds: f64) -> &mut Self {
        while self.sim.advance_until(at(seconds)).unwrap() == Step::Went {}
        self
    }

    /// Runs to a time.
    pub(crate) fn until(&mut self, seconds: f64) -> &mut Self {
        self.towards(seconds);
        assert_eq!(self.sim.now(), at(seconds), "the run ended too early");
        self
    }

    /// Runs until the condition holds, and returns when that was.
    pub(crate) fn until_it(&mut self, holds: impl Fn(&Simulation) -> bool) -> Timestamp {
        while !holds(&self.sim) {
            let step = self.sim.advance_until(Timestamp::MAX).unwrap();
            assert_eq!(step, Step::Went, "the run ended before the condition held");
        }
        self.sim.now()
    }

    /// Runs to the end of the mission.
    pub(crate) fn land(mut self) -> (Report, Trace) {
        self.sim.run(|_| {}).unwrap();
        self.end()
    }

    /// Ends the run here.
    pub(crate) fn end(self) -> (Report, Trace) {
        let (report, trace, _) = self.sim.finish().unwrap();
        (report, trace)
    }
}

/// Whether the vehicle truly flies a modify.
pub(crate) fn is_modified(sim: &Simulation) -> bool {
    matches!(sim.truth().activity, Activity::Modified { .. })
}

/// The SPI identifiers of the inserts that were sent, in order.
pub(crate) fn identifiers(trace: &Trace) -> Vec<u32> {
    let identifier = |insert: &ToVehicle| {
        if let ToVehicle::Trackline(line) = insert {
            Some(line.identifier.get())
        } else {
            None
        }
    };
    trace.inserts.iter().filter_map(identifier).collect()
}

pub(crate) const NO_VIOLATION: [Violation; 0] = [];
