//! The loop beside threads that panic (safety requirement 022). No known input from outside makes one of them panic, so
//! these tests run the loop itself and not the program.

use std::io::{self, Write};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use backseat_core::plugin::{Returned, StepInput, Version};
use backseat_core::{Core, Restarted, Start};
use backseat_plugin_host::{Cache, Host, Plugin, Seat};
use backseat_recorder::{Header, Rate};
use backseat_suite::{Behavior, Heard, Scripted, Signal, settle};
use rustix::process::{getpid, kill_process};
use tokio::sync::mpsc::unbounded_channel;

use crate::clock::Clock;
use crate::external::Ports;
use crate::helm::Helm;
use crate::keeper::Keeper;
use crate::operator::Signals;
use crate::plugins::{Crew, Steps};
use crate::recording::Recording;
use crate::run::driver::{Around, Driver, Inbox};
use crate::run::shadow::Shadows;

/// The machine may be busy.
const SOON: Duration = Duration::from_secs(30);

/// A plugin whose host panics in every step and restart.
struct Panics;

impl Steps for Panics {
    fn step(&mut self, _: &StepInput) -> Returned {
        panic!("the test panics in a step")
    }

    fn restart(&mut self) -> Restarted {
        panic!("the test panics in a restart")
    }

    fn offer(&mut self, _: Plugin, _: Version) {
        panic!("the test panics in a swap")
    }

    fn take_passed(&mut self) -> Option<Version> {
        None
    }
}

impl Write for Panics {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        panic!("the test panics in the log")
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn signal(signal: Signal) {
    kill_process(getpid(), signal).expect("this process exists");
}

/// Seconds until the vehicle receives the end of the lease.
fn ended_after_s(vehicle: &Scripted, act: Signal) -> f64 {
    let (since_s, before) = (vehicle.now_s(), vehicle.heard("BPEMB").len());
    signal(act);
    vehicle.hears("BPEMB", before + 1, SOON);
    vehicle.heard("BPEMB")[before].at_s - since_s
}

fn worst_gap_s(heard: &[Heard]) -> f64 {
    heard
        .windows(2)
        .map(|pair| pair[1].at_s - pair[0].at_s)
        .fold(0.0, f64::max)
}

#[test]
fn sr_022_log_state_and_a_plugin_panic_and_the_vehicle_is_steered_on() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let _within = runtime.enter();
    let signals = Signals::new().unwrap();
    let folder = backseat_suite::Mission::steady().append(
        "mission.toml",
        "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = [\"modify\"]",
    );
    let layers = backseat_mission::Layers::default();
    let mission = backseat_mission::Mission::load(folder.path(), &layers).unwrap();
    let cache = Cache::new(backseat_test_support::cache(), |_| {});
    let host = Host::new().unwrap().with_cache(Some(cache));
    let loaded = backseat_plugin_loader::load_plugins(&host, &mission, Some(backseat_test_support::plugins())).unwrap();
    let clock = Clock::start();
    let header = Header {
        utc_at_start: clock.utc_at_start(),
        rate: Rate::Deployed,
        mission: &mission.name,
        seed: None,
        resolved_mission: &mission.resolved,
        fence: &mission.fence_text,
        origin: mission.envelope.fence().frame().origin(),
        world: None,
        components: &[],
        version: "0",
        sources: backseat_recorder::Sources::default(),
    };
    let start = Start {
        utc: clock.utc_at_start(),
        identifiers: None,
        armed: true,
        held: false,
        jitter: 1,
    };
    let mut plugins: Vec<Box<dyn Steps>> = Vec::new();
    for plugin in loaded.plugins {
        plugins.push(Box::new(Seat::new(plugin)));
    }
    plugins[1] = Box::new(Panics);
    let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
    let core = Core::new(
        mission.file.session.clone(),
        mission.envelope.clone(),
        loaded.setups,
        start,
    );
    let vehicle = Scripted::start(Behavior::default());
    let (sender, answers) = unbounded_channel();
    let (keeps, kept) = unbounded_channel();
    let (ports, heard) = Ports::open(&[]).unwrap();
    let around = Around {
        crew: Crew::of(plugins, clock, sender).unwrap(),
        ports,
        keeper: Keeper::panicking(keeps).unwrap(),
        recorder: Recording::to(Panics, "a log".to_owned(), &header).unwrap(),
        sonars: None,
        helm: Helm::new(true, PathBuf::from("hold"), 1.0),
        swaps: None,
        shadows: Shadows::default(),
    };
    let driver = Driver::new(core, clock, vehicle.address.clone(), around, names);

    let operator = thread::spawn(move || {
        vehicle.hears("BPRMB", 6, SOON);
        let held_s = ended_after_s(&vehicle, Signal::USR1);
        settle(Duration::from_millis(1500));
        let steered = vehicle.heard("BPRMB");
        signal(Signal::USR2);
        vehicle.hears("BPRMB", steered.len() + 2, SOON);
        (worst_gap_s(&steered), held_s, ended_after_s(&vehicle, Signal::TERM))
    });
    let driven = runtime.block_on(driver.drive(Inbox { answers, kept }, heard, signals));
    let (gap_s, held_s, ended_s) = operator.join().expect("the loop steered, held, released and ended");
    assert!(driven.is_ok(), "{driven:?}");
    assert!(gap_s < 2.5, "{gap_s:.3} s without a modify");
    assert!(
        held_s < 1.0 && ended_s < 1.0,
        "held after {held_s:.3} s, ended after {ended_s:.3} s"
    );
}
