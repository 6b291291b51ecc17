//! Prints the speed table of the mock vehicle: its own step, and a hundred clients over TCP.
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::fs;
use std::hint::black_box;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use backseat_bench::{HEADER, by_hand, in_turn, row};
use backseat_mission::{Layers, Mission};
use backseat_mvc::{ClientId, Mvc};
use backseat_scenario::Scenario;
use backseat_units::Timestamp;

const CLIENTS: usize = 100;
const HZ: u32 = 10;
const SERVED_FOR: Duration = Duration::from_secs(10);

pub(crate) fn print() {
    println!("{HEADER}");
    kinematic(false);
    kinematic(true);
    hundred_clients();
}

/// An hour of a mission. BFNVG and BFNVR are built in each step, whoever receives them: no client, or a client in the
/// same process whose bytes are dropped. The floor reads one BFNVG by hand.
fn kinematic(listening: bool) {
    let mission = Mission::load(&backseat_test_support::mission("isobath"), &Layers::default()).expect("a mission");
    let world = Scenario::load(&mission).expect("a world").world;
    let mut vehicle = Mvc::new(&world, 1).expect("a vehicle");
    let mut out = Vec::with_capacity(4096);
    if listening {
        let client = ClientId(1);
        vehicle.connect(Timestamp::ZERO, client);
        vehicle.receive(Timestamp::ZERO, client, b"$BPLOG,NVG,ON\r\n$BPLOG,NVR,ON\r\n");
    }
    let line = b"$BFNVG,081025.987,4221.810920,N,07106.846030,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E";
    let step = Duration::from_nanos(1_000_000_000 / u64::from(world.vehicle.tick_hz));
    let times = in_turn(
        // 15 rounds make an hour.
        3600 * world.vehicle.tick_hz / 15,
        || {
            if let Some(at) = vehicle.poll_timeout() {
                vehicle.handle_timeout(at);
                while vehicle.poll_transmit(&mut out).is_some() {
                    black_box(out.len());
                }
                while vehicle.poll_event().is_some() {}
            }
        },
        || {
            black_box(by_hand::navigation(black_box(line)));
        },
    );
    let life = step.as_nanos() as f64 / times.0;
    row(
        &format!(
            "step of the mock, kinematic, {}: {life:.0} x life",
            if listening { "one client" } else { "nobody connected" }
        ),
        times,
        "one BFNVG read",
        "50000 x life",
    );
}

/// Processor time of the server while a hundred clients receive navigation ten times a second. The floor writes as many
/// bytes to as many sockets as often.
fn hundred_clients() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let steady = backseat_test_support::workspace().join("tests/suite/missions/steady");
    for entry in fs::read_dir(&steady).expect("the mission is there") {
        let path = entry.expect("it can be listed").path();
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("the folder is ours");
    }
    let world = folder.path().join("world.toml");
    let text = fs::read_to_string(&world).expect("it was copied");
    fs::write(
        &world,
        text.replace("[mission]", "[spi]\nclients_max = 128\n\n[mission]"),
    )
    .expect("ours");
    let errors = folder.path().join("stderr");
    let child = Command::new(backseat_test_support::program())
        .args(["mvc", "--listen", "127.0.0.1:0"])
        .arg(folder.path())
        .stderr(fs::File::create(&errors).expect("ours"))
        .stdout(Stdio::null())
        .spawn()
        .expect("the program was just built");
    let child = Guard(child);
    let address = listening(&errors);
    let mut clients: Vec<TcpStream> = (0..CLIENTS)
        .map(|_| {
            let mut stream = TcpStream::connect(&address).expect("it listens");
            stream
                .write_all(b"$BPLOG,NVG,ON\r\n$BPLOG,NVR,ON\r\n")
                .expect("it reads");
            stream.set_nonblocking(true).expect("a socket");
            stream
        })
        .collect();
    sleep(Duration::from_secs(1));
    drain(&mut clients);
    let process = child.0.id().to_string();
    let (before, start) = (processor_ns(&process), Instant::now());
    let mut bytes = 0;
    while start.elapsed() < SERVED_FOR {
        sleep(Duration::from_millis(50));
        bytes += drain(&mut clients);
    }
    let seconds = start.elapsed().as_secs_f64();
    let ours = (processor_ns(&process) - before) / seconds;
    let each = bytes / CLIENTS / (f64::from(HZ) * seconds) as usize;
    drop(child);
    let floor = writes_only(each);
    row(
        &format!("100 clients at 10 Hz over TCP: {:.1} % of a core, a second", ours / 1e7),
        (ours, floor),
        "the writes alone",
        "200000000 ns, 20 %",
    );
}

/// Processor time in nanoseconds for each second, for as many writes to each of the sockets.
fn writes_only(each: usize) -> f64 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("it is bound");
    let mut pairs: (Vec<TcpStream>, Vec<TcpStream>) = (0..CLIENTS)
        .map(|_| {
            let near = TcpStream::connect(address).expect("it listens");
            let (far, _) = listener.accept().expect("one has connected");
            near.set_nodelay(true).expect("a socket");
            far.set_nonblocking(true).expect("a socket");
            (near, far)
        })
        .unzip();
    let bytes = vec![b'x'; each];
    let mut spent = 0.0;
    for _ in 0..HZ * 3 {
        let before = processor_ns("thread-self");
        for stream in &mut pairs.0 {
            stream.write_all(&bytes).expect("it is read");
        }
        spent += processor_ns("thread-self") - before;
        drain(&mut pairs.1);
        sleep(Duration::from_millis(20));
    }
    spent / 3.0
}

struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        // If it has ended already, nothing is left to do.
        let _ended = self.0.kill();
        let _status = self.0.wait();
    }
}

fn listening(errors: &Path) -> String {
    for _ in 0..100 {
        let text = fs::read_to_string(errors).unwrap_or_default();
        if let Some(line) = text.lines().find(|line| line.contains("listening on ")) {
            return line.rsplit(' ').next().unwrap_or_default().to_owned();
        }
        sleep(Duration::from_millis(100));
    }
    panic!("the program does not listen")
}

/// Reads everything that has arrived, bytes.
fn drain(streams: &mut [TcpStream]) -> usize {
    let (mut buffer, mut bytes) = ([0; 16_384], 0);
    for stream in streams {
        loop {
            match stream.read(&mut buffer) {
                Ok(0) => panic!("the connection was closed"),
                Ok(count) => bytes += count,
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) => panic!("{error}"),
            }
        }
    }
    bytes
}

/// Processor time of a process's first thread, nanoseconds: the server has only one.
fn processor_ns(process: &str) -> f64 {
    let text = fs::read_to_string(format!("/proc/{process}/schedstat")).expect("the kernel tells it");
    let number = text.split_whitespace().next().and_then(|number| number.parse().ok());
    number.expect("a number")
}
