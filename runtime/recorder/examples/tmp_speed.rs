//! tmp
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]
use backseat_core::{plugin::*, *};
use backseat_recorder::*;
use backseat_units::*;
use std::time::Instant;
fn main() {
    let rate = if std::env::args().nth(2).is_some() {
        Rate::Deployed
    } else {
        Rate::Simulation
    };
    let header = Header {
        utc_at_start: Utc::from_unix_nanos(1_780_000_000_000_000_000),
        rate,
        mission: "isobath",
        seed: Some(3),
        resolved_mission: "a = 1\n",
        fence: "{}",
        components: &[("isobath".into(), vec![0; 1000])],
        version: "0.1.0",
    };
    let path = std::env::args().nth(1).unwrap();
    let mut r = Recorder::create(path.as_ref(), &header).unwrap();
    let bytes = [b'x'; 180];
    let n = 1_000_000u64;
    let t = Instant::now();
    for i in 0..n {
        r.input(Timestamp::from_millis(100 * i), &Input::Received(&bytes))
            .unwrap();
    }
    println!("chunk {:.0} ns", t.elapsed().as_nanos() as f64 / n as f64);
    let base = 100 * n;
    let ret = Input::Returned(
        PluginId(0),
        Returned {
            fuel: 12345,
            log: vec![],
            result: Ok(vec![]),
        },
    );
    let t = Instant::now();
    for i in 0..n {
        r.input(Timestamp::from_millis(base + 100 * i), &ret).unwrap();
    }
    println!("returned {:.0} ns", t.elapsed().as_nanos() as f64 / n as f64);
    let base = 2 * base;
    let t = Instant::now();
    for i in 0..n {
        r.output(
            Timestamp::from_millis(base + 100 * i),
            &Output::Note(Note::Control {
                granted: true,
                reason: String::new(),
            }),
        )
        .unwrap();
    }
    println!("note {:.0} ns", t.elapsed().as_nanos() as f64 / n as f64);
    r.vehicle_event(Timestamp::from_millis(2 * base), "the end").unwrap();
    if rate == Rate::Deployed {
        std::process::abort();
    }
    r.finish().unwrap();
}
