//! Prints the speed table of campaigns: the rate of runs with their results, and what a million runs cost beside being
//! flown.
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::fs;
use std::hint::black_box;
use std::io::{BufWriter, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use backseat_bench::HEADER;
use backseat_campaign::{Crew, Ended, Folder, Given, Order, Shard, Stop, finish, fly};
use backseat_campaign_report::{Outcomes, page, table, write};
use backseat_mission::{Layers, Mission};
use backseat_plugin_host::Host;
use backseat_plugin_loader::Components;
use backseat_scenario::Scenario;
use backseat_sim::Simulation;

/// Runs of a round.
const RUNS: u64 = 150;
/// The rounds of a rate; ours and the floor take turns, and the best of each counts.
const ROUNDS: usize = 2;
/// Runs of the campaign that is not flown.
const MANY: u64 = 1_000_000;
/// Runs of a shard, for what it costs to start one.
const OF_SHARD: f64 = 1000.0;

pub(crate) fn print() {
    println!("{HEADER}");
    let folder = tempfile::tempdir().expect("a folder");
    let run_s = rate(folder.path());
    many(folder.path(), run_s);
}

/// A mission that is flown, from a file of a campaign with so many seeds.
fn given(folder: &Path, seeds: u64) -> Given {
    let path = folder.join(format!("campaign-{seeds}.toml"));
    let mission = backseat_test_support::mission("isobath");
    fs::write(
        &path,
        format!(
            "missions = ['{}']\nseeds = \"1..{seeds}\"\n[report]\nmeasure = \"contour_rms_m\"\n",
            mission.display()
        ),
    )
    .expect("there is room");
    Given::read(&path, None, &[]).expect("a campaign")
}

fn crew() -> Crew {
    let host = Host::new().expect("an engine");
    Crew::new(host, Some(backseat_test_support::plugins().to_path_buf()))
}

fn workers() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Flies what is not flown yet, until told to stop.
fn flown(given: &Given, crew: &Crew, folder: &Folder, stop: &Stop) -> Ended {
    let order = Order {
        plan: &given.plan,
        crew,
        folder,
        shard: Shard::WHOLE,
        workers: workers(),
        stop_after: None,
        host: "bench",
    };
    fly(&order, stop, |progress| {
        if progress.now > 0 && given.plan.runs() == MANY {
            stop.set();
        }
    })
    .expect("it can be flown")
}

/// The rate of whole campaigns beside that of bare simulations, on all cores. Returns the seconds of a run.
fn rate(folder: &Path) -> f64 {
    let (mut ours, mut floor) = (f64::MAX, f64::MAX);
    for round in 0..ROUNDS {
        let began = Instant::now();
        let (given, crew) = (given(folder, RUNS), crew());
        let out = given
            .open(&crew, &folder.join(format!("rate-{round}")), "bench")
            .expect("a folder");
        flown(&given, &crew, &out, &Stop::default());
        finish(&given.plan, std::slice::from_ref(&out), &out).expect("the results");
        write(&out, &given.plan, Some(&crew)).expect("the report");
        ours = ours.min(began.elapsed().as_secs_f64());
        let began = Instant::now();
        bare();
        floor = floor.min(began.elapsed().as_secs_f64());
    }
    let an_hour = |seconds: f64| 3600.0 * RUNS as f64 / seconds;
    println!(
        "| isobath, {} threads, results and report | {:.0} runs an hour | {:.0} runs an hour (bare simulations) | {:.2} | \
         35,000; 1.11 |",
        workers(),
        an_hour(ours),
        an_hour(floor),
        ours / floor
    );
    floor / RUNS as f64
}

fn bare() {
    let mission = Mission::load(&backseat_test_support::mission("isobath"), &Layers::default()).expect("the mission");
    let scenario = Scenario::load(&mission).expect("a world");
    let host = Host::new().expect("an engine");
    let components = Components::load(&host, &mission, Some(backseat_test_support::plugins())).expect("the plugins");
    let next = AtomicU64::new(1);
    thread::scope(|scope| {
        for _ in 0..workers() {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > RUNS {
                        return;
                    }
                    let loaded = components.start(&mission).expect("the plugins");
                    let mut simulation = Simulation::new(&mission, &scenario, seed, loaded, None).expect("a world");
                    simulation.run(|_| ()).expect("no log");
                    black_box(simulation.finish().expect("no log"));
                }
            });
        }
    });
}

/// What a million runs cost beside being flown.
fn many(folder: &Path, run_s: f64) {
    let (given, crew) = (given(folder, MANY), crew());
    let began = Instant::now();
    let out = given.open(&crew, &folder.join("many"), "bench").expect("a folder");
    let first = Instant::now();
    flown(&given, &crew, &out, &Stop::default());
    let ready = first.duration_since(began).as_secs_f64() + first.elapsed().as_secs_f64() - run_s * workers() as f64;
    println!(
        "| {MANY} planned runs: from the file to the first row, less its flight | {ready:.2} s | {run_s:.2} s (one run, \
         all threads) | {:.2} | 1 s |",
        ready / run_s
    );

    let journal = out.path().join("journal/1-of-1.journal");
    multiply(
        &folder.join(format!("rate-{}/journal/1-of-1.journal", ROUNDS - 1)),
        &journal,
    );
    let size = fs::metadata(&journal).expect("it was written").len();
    let floor = (0..ROUNDS).map(|_| read(&journal)).fold(f64::MAX, f64::min);
    let row = |work: &str, seconds: f64, aim: &str| {
        println!(
            "| {MANY} rows: {work} | {seconds:.1} s | {floor:.2} s (reading {} MB and their CRC) | {:.1} | {aim} |",
            size / 1_000_000,
            seconds / floor
        );
    };
    // A process that starts and finds all flown: what a shard costs beside its runs.
    let began = Instant::now();
    flown(&given, &crew, &out, &Stop::default());
    row("journal taken up", began.elapsed().as_secs_f64(), "");
    let began = Instant::now();
    finish(&given.plan, std::slice::from_ref(&out), &out).expect("the results");
    row("merge", began.elapsed().as_secs_f64(), "10 s");
    let began = Instant::now();
    let outcomes = Outcomes::read(&out, &given.plan).expect("the results");
    black_box(page(&out, &given.plan, &outcomes, &Default::default()).expect("the report"));
    black_box(table(&outcomes));
    row("report without pictures", began.elapsed().as_secs_f64(), "");
    drop(outcomes);
    println!(
        "| {MANY} rows: most memory of all this | {} MB | | | |",
        most_memory_mb()
    );
    shard(folder, run_s);
}

/// The seconds of reading a file and its CRC.
fn read(path: &Path) -> f64 {
    let began = Instant::now();
    let mut file = fs::File::open(path).expect("it is there");
    let mut piece = vec![0; 1 << 20];
    let mut hash = crc32fast::Hasher::new();
    loop {
        let count = file.read(&mut piece).expect("it can be read");
        if count == 0 {
            break;
        }
        hash.update(&piece[..count]);
    }
    black_box(hash.finalize());
    began.elapsed().as_secs_f64()
}

/// What a shard costs beside its runs: opening everything, and a journal with its rows.
fn shard(folder: &Path, run_s: f64) {
    let mut least = f64::MAX;
    for round in 0..ROUNDS {
        let began = Instant::now();
        let (given, crew) = (given(folder, RUNS), crew());
        let out = given
            .open(&crew, &folder.join(format!("rate-{round}")), "bench")
            .expect("a folder");
        flown(&given, &crew, &out, &Stop::default());
        least = least.min(began.elapsed().as_secs_f64());
    }
    let runs = OF_SHARD * run_s;
    println!(
        "| a shard: all that is not flying, plugins compiled | {least:.3} s | {runs:.0} s (its 1000 runs) | {:.4} | 0.01 |",
        least / runs
    );
}

/// Writes a journal of a million runs from one with some rows, which come again and again under other numbers. The format
/// is that of the campaign's journals.
fn multiply(from: &Path, to: &PathBuf) {
    let few = fs::read(from).expect("it was flown");
    let written = fs::read(to).expect("it was begun");
    let head = |bytes: &[u8]| {
        let mut lines = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        lines.nth(1).map_or(0, |(place, _)| place + 1)
    };
    let mut out = BufWriter::new(fs::File::create(to).expect("there is room"));
    out.write_all(&written[..head(&written)]).expect("there is room");
    let (mut others, mut rows) = (Vec::new(), Vec::new());
    let mut rest = &few[head(&few)..];
    while rest.len() > 8 {
        let length = u32::from_le_bytes([rest[0], rest[1], rest[2], rest[3]]) as usize;
        let entry = &rest[8..8 + length];
        // The kind of an entry comes first; that of a row is 2, and then comes its run.
        if entry[0] == 2 {
            let number = entry[1..].iter().take_while(|byte| **byte >= 128).count() + 1;
            rows.push(&entry[1 + number..]);
        } else {
            others.push(entry);
        }
        rest = &rest[8 + length..];
    }
    let mut put = |entry: &[u8]| {
        let length = u32::try_from(entry.len()).expect("it is short");
        out.write_all(&length.to_le_bytes()).expect("there is room");
        out.write_all(&crc32fast::hash(entry).to_le_bytes())
            .expect("there is room");
        out.write_all(entry).expect("there is room");
    };
    others.iter().for_each(|entry| put(entry));
    let mut entry = Vec::new();
    for run in 0..MANY {
        entry.clear();
        entry.push(2);
        let mut left = run;
        while left >= 128 {
            entry.push(left as u8 & 127 | 128);
            left >>= 7;
        }
        entry.push(left as u8);
        entry.extend_from_slice(rows[(run % rows.len() as u64) as usize]);
        put(&entry);
    }
    out.flush().expect("there is room");
}

fn most_memory_mb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().split(' ').next()?.parse::<u64>().ok());
    kilobytes.unwrap_or(0) / 1000
}
