//! How soon the program at sea reacts, over TCP, with six plugins, a log, a console and viewers; and what ten browsers cost.
//!
//! The program must be there: `cargo build --release -p backseat`. `cargo bench -p backseat-bench -- console`.

#![expect(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "a benchmark runs in real time, and ends where something is missing"
)]

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Navigation comes a little more than three times a second: a modify that has changed is sent at once if the last BPRMB was
/// sent 0.2 s ago or more, and the plugin's period is shorter than this and longer than two thirds of it, so that each of its
/// steps comes with navigation.
const EVERY: Duration = Duration::from_millis(300);
/// How long each run is measured.
const LASTS: Duration = Duration::from_secs(30);
const BROWSERS: usize = 10;

pub(crate) fn print() {
    let program = program();
    println!("| work | ours | floor | aim |");
    println!("|---|---|---|---|");
    let floor = percentiles(&mut loopback(false));
    let handed = percentiles(&mut loopback(true));
    let plain = flown(&program, &[], 0);
    let shown = flown(&program, &["--console=0", "--foxglove=0"], BROWSERS);
    for (what, run) in [
        ("log and six plugins", &plain),
        ("the same, with console, viewers and ten browsers", &shown),
    ] {
        let (p50, p99, worst) = percentiles(&mut run.reactions.clone());
        println!(
            "| navigation in to BPRMB out, {what}, {} times: p50, p99, worst | {p50:.0}, {p99:.0}, {worst:.0} us | {:.0}, {:.0} us \
             (a round trip over loopback); {:.0}, {:.0} us (the same, handed to another thread and back) | 60, 1000 us |",
            run.reactions.len(),
            floor.0,
            floor.1,
            handed.0,
            handed.1
        );
        println!(
            "| processor, {what} | {:.2} % of a core | | |",
            100.0 * run.processor_s / LASTS.as_secs_f64()
        );
        println!(
            "| longest gap between two BPRMB, {what} | {:.0} ms | | 1500 ms |",
            1e3 * run.gap_s
        );
    }
    println!(
        "| console and viewers with ten browsers | {:.2} % of a core | | 3 % |",
        100.0 * (shown.processor_s - plain.processor_s) / LASTS.as_secs_f64()
    );
}

/// The program, which lies beside the folder of this benchmark.
fn program() -> PathBuf {
    let own = std::env::current_exe().unwrap();
    let program = own.parent().and_then(Path::parent).unwrap().join("backseat");
    assert!(
        program.is_file(),
        "{}: cargo build --release -p backseat",
        program.display()
    );
    program
}

/// p50, p99 and the largest, microseconds.
fn percentiles(times: &mut [f64]) -> (f64, f64, f64) {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| 1e6 * times[((times.len() - 1) as f64 * share).round() as usize];
    (at(0.5), at(0.99), at(1.0))
}

/// Round trips of a sentence over loopback between two threads that wait in `read`, seconds. They come as seldom as
/// navigation does: by then the processor sleeps, and its caches hold other things. With `handed`, the thread that answers
/// first hands the sentence to a third one and waits for it, as the loop does with a plugin.
fn loopback(handed: bool) -> Vec<f64> {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (hand, given) = channel();
    let (back, answered) = channel();
    let third = thread::spawn(move || {
        for read in given {
            back.send(read).unwrap();
        }
    });
    let echo = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_nodelay(true).unwrap();
        let mut bytes = [0; 256];
        while let Ok(mut read @ 1..) = stream.read(&mut bytes) {
            if handed {
                hand.send(read).unwrap();
                read = answered.recv().unwrap();
            }
            stream.write_all(&bytes[..read]).unwrap();
        }
    });
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_nodelay(true).unwrap();
    let mut bytes = [0; 256];
    let times = (0..100).map(|_| {
        thread::sleep(EVERY);
        let begun = Instant::now();
        stream.write_all(&[b'x'; 100]).unwrap();
        let _read = stream.read(&mut bytes).unwrap();
        begun.elapsed().as_secs_f64()
    });
    let times = times.collect();
    drop(stream);
    echo.join().unwrap();
    third.join().unwrap();
    times
}

struct Flown {
    /// From navigation to the BPRMB that follows it, seconds.
    reactions: Vec<f64>,
    gap_s: f64,
    /// Processor time of the program while it was measured, seconds.
    processor_s: f64,
}

fn flown(program: &Path, arguments: &[&str], browsers: usize) -> Flown {
    let folder = tempfile::tempdir().unwrap();
    let mission = mission(folder.path());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let errors = folder.path().join("errors");
    let mut child = Command::new(program)
        .arg("run")
        .arg(&mission)
        .args(["--arm", "--connect", &address, "--plugins"])
        .arg(plugins())
        .arg("--state")
        .arg(folder.path().join("state"))
        .arg("--log")
        .arg(folder.path().join("logs"))
        .args(arguments)
        .stderr(fs::File::create(&errors).unwrap())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let (stream, _) = listener.accept().unwrap();
    let vehicle = Vehicle::serve(stream);
    let deadline = Instant::now() + Duration::from_secs(60);
    while vehicle.modifies().len() < 20 {
        assert!(Instant::now() < deadline, "{}", fs::read_to_string(&errors).unwrap());
        thread::sleep(Duration::from_millis(50));
    }
    let over = Arc::new(AtomicBool::new(false));
    let readers: Vec<_> = (0..browsers).map(|_| browse(&errors, Arc::clone(&over))).collect();
    thread::sleep(Duration::from_secs(2));
    let (since, before) = (Instant::now(), processor_s(&child));
    thread::sleep(LASTS);
    let processor_s = processor_s(&child) - before;
    let until = Instant::now();
    over.store(true, Ordering::Relaxed);
    stop(&mut child);
    for reader in readers {
        reader.join().unwrap();
    }
    let navigated = vehicle.navigated.lock().unwrap().clone();
    let within = |at: &Instant| (since..until).contains(at);
    let modifies: Vec<Instant> = vehicle.modifies().into_iter().filter(within).collect();
    let reactions = modifies.iter().filter_map(|at| {
        let sent = navigated.iter().rev().find(|sent| *sent < at)?;
        let took = at.duration_since(*sent);
        // A refresh of the lease between two of them is not a reaction.
        (took < EVERY / 2).then_some(took.as_secs_f64())
    });
    let gaps = modifies
        .windows(2)
        .map(|pair| pair[1].duration_since(pair[0]).as_secs_f64());
    Flown {
        reactions: reactions.collect(),
        gap_s: gaps.fold(0.0, f64::max),
        processor_s,
    }
}

fn plugins() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/plugins")
}

/// The suite's steady mission, with one plugin that steers and five that would.
fn mission(folder: &Path) -> PathBuf {
    let from = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../suite/missions/steady");
    let mission = folder.join("steady");
    fs::create_dir(&mission).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let file = entry.unwrap().path();
        fs::copy(&file, mission.join(file.file_name().unwrap())).unwrap();
    }
    let path = mission.join("mission.toml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once("[[plugin]]").unwrap();
    let config = "[plugin.config]\nheading_deg = 90.0\ndepth_m = 8.0\nspeed_mps = 1.5\n";
    let mut text =
        format!("{head}[[plugin]]\nname = \"pilot\"\ncomponent = \"restless\"\ngrants = [\"modify\"]\n{config}");
    for number in 2..=6 {
        text += &format!(
            "[[plugin]]\nname = \"plugin-{number}\"\ncomponent = \"template\"\ngrants = [\"modify\"]\n{config}"
        );
    }
    fs::write(path, text).unwrap();
    mission
}

/// Utime and stime of a process, seconds.
fn processor_s(child: &Child) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap().split(' ').collect();
    let ticks: f64 = fields[11..13].iter().map(|field| field.parse::<f64>().unwrap()).sum();
    // Linux counts in hundredths, whatever the kernel's own clock.
    ticks / 100.0
}

fn stop(child: &mut Child) {
    let id = child.id().to_string();
    let _sent = Command::new("kill").args(["-TERM", &id]).status();
    let _ended = child.wait();
}

/// Reads the console's feed as a browser does.
fn browse(errors: &Path, over: Arc<AtomicBool>) -> thread::JoinHandle<()> {
    let said = fs::read_to_string(errors).unwrap();
    let address = said.split("console: http://").nth(1).unwrap();
    let address = address.split(';').next().unwrap().to_owned();
    thread::spawn(move || {
        let mut stream = TcpStream::connect(&address).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        let request = format!(
            "GET /api/feed?after=0 HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut bytes = vec![0; 1 << 16];
        let mut read = 0;
        while !over.load(Ordering::Relaxed) {
            match stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(more) => read += more,
                Err(_) => {}
            }
        }
        assert!(read > 10_000, "the feed has told {read} bytes");
    })
}

/// A vehicle that gives control, flies straight east, accepts everything, and knows when it said and heard what.
struct Vehicle {
    modifies: Arc<Mutex<Vec<Instant>>>,
    navigated: Arc<Mutex<Vec<Instant>>>,
}

impl Vehicle {
    fn serve(stream: TcpStream) -> Self {
        stream.set_nodelay(true).unwrap();
        let (modifies, navigated) = (Arc::default(), Arc::default());
        let vehicle = Self {
            modifies: Arc::clone(&modifies),
            navigated: Arc::clone(&navigated),
        };
        let writer = Arc::new(Mutex::new(stream.try_clone().unwrap()));
        let theirs = Arc::clone(&writer);
        let ready = Arc::new(AtomicBool::new(false));
        let is_ready = Arc::clone(&ready);
        thread::spawn(move || hear(stream, &theirs, &modifies, &ready));
        thread::spawn(move || navigate(&writer, &navigated, &is_ready));
        vehicle
    }

    fn modifies(&self) -> Vec<Instant> {
        self.modifies.lock().unwrap().clone()
    }
}

fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

fn hear(mut stream: TcpStream, writer: &Mutex<TcpStream>, modifies: &Mutex<Vec<Instant>>, ready: &AtomicBool) {
    let say = |text: &str| drop(writer.lock().unwrap().write_all(text.as_bytes()));
    say(&sentence(&format!("BFVER,{},1.12", utc())));
    let (mut bytes, mut line) = ([0; 4096], Vec::new());
    while let Ok(read @ 1..) = stream.read(&mut bytes) {
        let now = Instant::now();
        for byte in &bytes[..read] {
            line.push(*byte);
            if *byte != b'\n' {
                continue;
            }
            let text = String::from_utf8_lossy(&std::mem::take(&mut line)).into_owned();
            let fields: Vec<&str> = text.split(['*', '\r']).next().unwrap().split(',').collect();
            let name = fields[0].get(3..6).unwrap_or("NAK");
            if name == "RMB" {
                modifies.lock().unwrap().push(now);
            }
            let echo = if name == "LOG" { "000000.000" } else { fields[1] };
            if name == "RMP" {
                for (index, kind, east_m) in [(0, 1, -600.0), (1, 2, 600.0)] {
                    let minutes = (0.70 - east_m / 82_300.0) * 60.0;
                    say(&sentence(&format!(
                        "BFPLN,{},1,,{index},{kind},4221.000000,N,070{minutes:09.6},W,,,",
                        utc()
                    )));
                }
            }
            say(&sentence(&format!("BFACK,{},{name},{echo},0,2,0,", utc())));
            if name == "LOG" && fields.get(1) == Some(&"ACK") && !ready.swap(true, Ordering::Relaxed) {
                say(&sentence(&format!("BFMIS,{},dive,Running,", utc())));
                say(&sentence(&format!("BFCTL,{},1", utc())));
                say(&sentence(&format!("BFMBS,{},dive,1,,trackline", utc())));
            }
        }
    }
}

/// Straight east from 100 m west of 42.35 N 70.70 W at 1.5 m/s.
fn navigate(writer: &Mutex<TcpStream>, navigated: &Mutex<Vec<Instant>>, ready: &AtomicBool) {
    let began = Instant::now();
    let mut next = began;
    loop {
        next += EVERY;
        thread::sleep(next.saturating_duration_since(Instant::now()));
        if !ready.load(Ordering::Relaxed) {
            continue;
        }
        let minutes = (0.70 + (100.0 - 1.5 * began.elapsed().as_secs_f64()) / 82_300.0) * 60.0;
        let created = utc();
        // BFNVG's heading counts from grid north, which is 1.15 degrees east of true north here.
        let place = format!("4221.000000,N,070{minutes:09.6},W,0,42.0,8.0,91.15,0.0,0.0");
        let text = sentence(&format!("BFNVG,{created},{place},{created}"))
            + &sentence(&format!("BFNVR,{created},1.5,0.0,0.0,0.0,0.0,0.0"));
        let mut writer = writer.lock().unwrap();
        navigated.lock().unwrap().push(Instant::now());
        if writer.write_all(text.as_bytes()).is_err() {
            return;
        }
    }
}

fn utc() -> String {
    let millis = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis() % 86_400_000;
    let (hours, minutes) = (millis / 3_600_000, millis / 60_000 % 60);
    format!("{hours:02}{minutes:02}{:02}.{:03}", millis / 1000 % 60, millis % 1000)
}
