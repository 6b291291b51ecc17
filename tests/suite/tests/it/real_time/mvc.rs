//! The mock vehicle as a separate program: clients in other languages, hostile clients, roles, its log.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Signal, Stopwatch, Vehicle, Way, eventually, settle};

const SOON: Duration = Duration::from_secs(20);

/// A client on a plain socket.
pub(super) struct Client {
    stream: TcpStream,
    heard: Vec<u8>,
}

impl Client {
    pub(super) fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("the vehicle listens");
        stream
            .set_read_timeout(Some(Duration::from_millis(50)))
            .expect("a time that is not zero");
        stream
            .set_write_timeout(Some(Duration::from_secs(10)))
            .expect("a time that is not zero");
        stream.set_nodelay(true).expect("a socket");
        Self {
            stream,
            heard: Vec::new(),
        }
    }

    pub(super) fn say(&mut self, sentence: &str) {
        self.stream
            .write_all(format!("{sentence}\r\n").as_bytes())
            .expect("the vehicle reads");
    }

    /// Reads once; returns false if the vehicle has closed the connection.
    pub(super) fn read(&mut self) -> bool {
        let mut buffer = [0; 16 * 1024];
        match self.stream.read(&mut buffer) {
            Ok(0) => false,
            Ok(count) => {
                self.heard.extend_from_slice(&buffer[..count]);
                true
            }
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
        }
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let text = String::from_utf8_lossy(&self.heard);
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        whole.lines().map(str::to_owned).collect()
    }

    pub(super) fn hears(&mut self, text: &str) {
        let wanted = text.to_owned();
        eventually(
            SOON,
            || {
                self.read();
                self.lines().iter().any(|line| line.contains(text)).then_some(())
            },
            || format!("{wanted} was not heard"),
        );
    }

    /// The vehicle closes the connection soon.
    fn is_cut_off(&mut self) {
        eventually(SOON, || (!self.read()).then_some(()), || "still connected".to_owned());
    }
}

fn vehicle_with(mission: &Mission, flags: &[&str]) -> Vehicle {
    Vehicle::start_with(mission, "127.0.0.1:0", flags)
}

#[test]
fn a_client_in_python_turns_the_vehicle_and_flies_a_line() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 6000");
    let vehicle = vehicle_with(&mission, &["--speed", "20"]);
    let (host, port) = vehicle.address.rsplit_once(':').unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/fly.py");
    let output = Command::new("python3").arg(script).args([host, port, "20"]).output();
    let output = output.unwrap_or_else(|error| panic!("python3 is needed (its standard library is enough): {error}"));
    let (said, complained) = (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    );
    assert!(output.status.success(), "{said}{complained}\n{}", vehicle.story());
    for line in ["control at heading", "modified to heading", "trackline 41 flown"] {
        assert!(said.contains(line), "{said}");
    }
    vehicle.sees("the end of the line", SOON, |line| {
        line.text == "inserted trackline 41 ended: done"
    });
}

/// Sets the flag when dropped.
struct Stops<'a>(&'a AtomicBool);

impl Drop for Stops<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Each kind of hostile client at once, and among them one that receives navigation.
#[test]
fn hostile_clients_cost_nobody_else_anything() {
    let mission = Mission::steady().edit("world.toml", "[mission]", "[spi]\nclients_max = 24\n\n[mission]");
    let vehicle = vehicle_with(&mission, &[]);
    let address = vehicle.address.clone();
    let before = vehicle.process.memory_kib();
    // Before the others, because during a storm of connections every place is taken, and any new client is refused.
    let mut friend = Client::connect(&address);
    friend.say("$BPLOG,NVG,ON");
    friend.hears("$BFNVG");
    let told = friend.lines().len();
    let stop = AtomicBool::new(false);
    let mut gaps = Vec::new();
    let going = || !stop.load(Ordering::Relaxed);
    std::thread::scope(|scope| {
        // The others also end if this fails; otherwise the failure would wait for them for ever.
        let _stops = Stops(&stop);
        let spam = |bytes: Vec<u8>, reads: bool| {
            let (address, going) = (&address, &going);
            scope.spawn(move || {
                while going() {
                    let Ok(mut stream) = TcpStream::connect(address) else {
                        continue;
                    };
                    stream.set_write_timeout(Some(Duration::from_millis(300))).unwrap();
                    stream.set_nonblocking(false).unwrap();
                    let mut sink = [0; 65536];
                    stream.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
                    while going() {
                        match stream.write(&bytes) {
                            Err(error) if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => break,
                            _ => {}
                        }
                        if reads {
                            let _read = stream.read(&mut sink);
                        }
                    }
                }
            });
        };
        // Garbage, commands, half lines, ten megabytes without a line end, oversized fields.
        spam((0..=255).cycle().take(100_000).collect(), true);
        spam(
            b"$BPLOG,ACK,ON\r\n$BPRMP,070000.000\r\n$BPRCN,070000.000,7\r\n".repeat(500),
            true,
        );
        spam(
            b"$BPLOG,ALL,ON\r\n$BPLOG,ACK,ON\r\n$BPMSG,070000.000,never read\r\n".repeat(500),
            false,
        );
        spam(b"$BPRMB,0700".to_vec(), true);
        spam(vec![b'A'; 10 << 20], true);
        spam(
            format!("$BPRTK,070000.000,{},1\r\n", "9".repeat(4000))
                .repeat(20)
                .into_bytes(),
            true,
        );
        // Storms of connections.
        for _ in 0..2 {
            let (address, going) = (&address, &going);
            scope.spawn(move || {
                while going() {
                    for _ in 0..50 {
                        if let Ok(mut stream) = TcpStream::connect(address) {
                            let _gone = stream.write_all(b"$BPLOG,ALL,ON\r\n");
                        }
                    }
                    settle(Duration::from_millis(20));
                }
            });
        }
        let watch = Stopwatch::start();
        let mut last = watch.elapsed();
        while watch.elapsed() < Duration::from_secs(8) {
            let before = friend.heard.len();
            assert!(friend.read(), "the friend was cut off");
            if friend.heard.len() > before {
                gaps.push(watch.elapsed() - last);
                last = watch.elapsed();
            }
        }
        stop.store(true, Ordering::Relaxed);
        let told = friend.lines().into_iter().skip(told);
        let navigation = told.filter(|line| line.starts_with("$BFNVG")).count();
        assert!((75..=90).contains(&navigation), "{navigation}");
    });
    let longest = gaps.iter().max().unwrap();
    assert!(*longest < Duration::from_millis(500), "{longest:?}");
    let grown = vehicle.process.memory_kib().saturating_sub(before);
    assert!(grown < 64 * 1024, "{grown} KiB more");
    // A new client is served as usual.
    let mut late = Client::connect(&vehicle.address);
    late.hears("$BFVER");
}

#[test]
fn who_never_reads_is_cut_off_at_any_speed() {
    let mission = Mission::steady();
    for speed in ["200", "max"] {
        let vehicle = vehicle_with(&mission, &["--speed", speed]);
        let mut deaf = Client::connect(&vehicle.address);
        deaf.say("$BPLOG,ALL,ON");
        vehicle.sees("that it does not read", Duration::from_secs(60), |line| {
            line.text.contains("client 1 does not read: cut off")
        });
    }
}

#[test]
fn as_fast_as_its_clients_read() {
    let mission = Mission::steady();
    let vehicle = vehicle_with(&mission, &["--speed", "max", "--duration", "20000"]);
    // It waits for its first client, however late that comes.
    settle(Duration::from_secs(1));
    let mut client = Client::connect(&vehicle.address);
    client.hears("$BFVER,080000.");
    client.say("$BPLOG,NVG,ON");
    let watch = Stopwatch::start();
    while client.read() {
        assert!(watch.elapsed() < Duration::from_secs(60), "it goes on");
    }
    // From its subscription to the end no update is missing, and the last is that of the last step.
    let lines = client.lines();
    let stamps: Vec<u64> = lines
        .iter()
        .filter(|line| line.starts_with("$BFNVG"))
        .map(|line| tenths(line))
        .collect();
    assert!(stamps.len() > 1000, "{}", stamps.len());
    assert!(stamps.windows(2).all(|pair| pair[1] == (pair[0] + 1) % 864_000));
    assert_eq!(stamps.last().copied(), Some(8 * 36_000 + 200_000));
}

/// Tenths of a second since midnight.
fn tenths(line: &str) -> u64 {
    let stamp = &line[7..17];
    let number = |range: std::ops::Range<usize>| stamp[range].parse::<u64>().expect("a stamp is of digits");
    (number(0..2) * 3600 + number(2..4) * 60 + number(4..6)) * 10 + number(7..8)
}

#[test]
fn a_role_is_one_connections_and_free_after_it() {
    let mission = Mission::steady().append(
        "world.toml",
        "[[mission.commands]]\nat_s = 3\nrole = \"sonar\"\ntext = \"start line 3\"",
    );
    let vehicle = vehicle_with(&mission, &["--iprole", "127.0.0.1::sonar,192.168.10.10::other"]);
    let mut first = Client::connect(&vehicle.address);
    first.hears("$BFVER");
    let mut second = Client::connect(&vehicle.address);
    second.is_cut_off();
    assert_eq!(second.lines(), Vec::<String>::new());
    first.hears("start line 3");
    first.stream.shutdown(Shutdown::Both).unwrap();
    vehicle.sees("the role free", SOON, |line| {
        line.text == "the role sonar of client 1 is free"
    });
    let mut third = Client::connect(&vehicle.address);
    third.hears("$BFVER");
    vehicle.sees("the role", SOON, |line| line.text == "client 3 has the role sonar");
    let line = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0", "--iprole", "sonar"])
        .mission(&mission)
        .run()
        .exit(2);
    assert!(line.stderr.contains("ADDRESS:PORT:ROLE"), "{line}");
}

#[test]
fn the_log_has_every_sentence_whole_and_in_order() {
    let mission = Mission::steady();
    let mut vehicle = vehicle_with(&mission, &["--speed", "5"]);
    let mut client = Client::connect(&vehicle.address);
    let address: SocketAddr = client.stream.local_addr().unwrap();
    client.say("$BPLOG,ALL,ON");
    client.say("$BPLOG,ACK,ON");
    // One sentence in three reads, two in one, one that is not text.
    for piece in [
        "$BPMSG,0700",
        "00.000,in ",
        "pieces\r\n$BPMSG,070000.001,and\n$BPMSG,070000.002,two\r\n\n",
    ] {
        client.stream.write_all(piece.as_bytes()).unwrap();
        settle(Duration::from_millis(60));
    }
    client.stream.write_all(b"$BPMSG,070000.003,\xe9t\xe9\\\n").unwrap();
    for count in 0..2000 {
        client.say(&format!("$BPMSG,{:06}.{:03},x", 70_000 + count / 1000, count % 1000));
    }
    client.hears("MSG,070001.999");
    // The copy of what the vehicle sent stops early; the client received everything to the end.
    vehicle.process.signal(Signal::TERM);
    assert_eq!(vehicle.process.wait(SOON), Some(0));
    while client.read() {}
    let lines = vehicle.lines();
    let sent: Vec<&str> = lines
        .iter()
        .filter(|line| line.way == Way::Sent)
        .map(|line| line.text.as_str())
        .collect();
    let heard = client.lines();
    let same = sent
        .iter()
        .zip(&heard)
        .take_while(|(sent, heard)| sent == heard)
        .count();
    assert_eq!(sent[same..], heard[same..], "{same} are the same");
    let received: Vec<&str> = lines
        .iter()
        .filter(|line| line.way == Way::Received)
        .map(|line| line.text.as_str())
        .collect();
    assert_eq!(received.len(), 2 + 3 + 1 + 2000);
    assert_eq!(
        received[2..6],
        [
            "$BPMSG,070000.000,in pieces",
            "$BPMSG,070000.001,and",
            "$BPMSG,070000.002,two",
            "$BPMSG,070000.003,\\xe9t\\xe9\\\\"
        ]
    );
    assert_eq!(received.last().copied(), Some("$BPMSG,070001.999,x"));
    assert!(lines.windows(2).all(|pair| pair[0].at_s <= pair[1].at_s));
    assert!(
        lines
            .iter()
            .any(|line| line.text == format!("client 1 connected from {address}"))
    );
    // The clock of a line is that of the sentence, to the millisecond.
    for line in lines
        .iter()
        .filter(|line| line.way == Way::Sent && line.name() == "BFNVG")
    {
        assert_eq!(tenths(&line.text), 8 * 36_000 + (line.at_s * 10.0).round() as u64);
    }
}

#[test]
fn what_cannot_be_flown_is_refused_with_its_place() {
    for (from, to, told) in [
        (
            "speed_mps = 1.5",
            "speed_mps = 99",
            ["world.toml", "plan element 1", "speed_mps is 99"],
        ),
        ("depth_m = 50", "depth_m = -5", ["world.toml", "seabed", "depth"]),
        (
            "[mission]",
            "[spi]\nclients_max = 0\n[mission]",
            ["world.toml", "spi.clients_max is 0", "1 to 256"],
        ),
    ] {
        let mission = Mission::steady().edit("world.toml", from, to);
        let line = Backseat::new()
            .args(["mvc", "--listen", "127.0.0.1:0"])
            .mission(&mission)
            .run()
            .refusal();
        for text in told {
            assert!(line.contains(text), "{line}");
        }
    }
}

#[test]
fn it_ends_by_itself_and_tells_a_person_what_goes_on() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let done = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0", "--speed", "500", "--duration", "120"])
        .mission(&mission)
        .run()
        .exit(0);
    for text in [
        "listening on 127.0.0.1:",
        "2.000 s: control given to the payload",
        "mission Completed",
        "| control: ",
        "m above ground | heading",
        "120.0 s of the vehicle's time",
    ] {
        assert!(done.stderr.contains(text), "{text}: {done}");
    }
}

#[test]
fn faults_of_a_file_are_played_on_the_link_too() {
    let mission = Mission::steady();
    let file = mission.beside("faults.toml");
    std::fs::write(
        &file,
        "[[fault]]\nat_s = 3\nkind = \"stall\"\nfor_s = 2\n[[fault]]\nat_s = 8\nkind = \"link_cut\"\nfor_s = 1\n",
    )
    .unwrap();
    let vehicle = vehicle_with(&mission, &["--faults", file.to_str().unwrap()]);
    let mut client = Client::connect(&vehicle.address);
    client.say("$BPLOG,NVG,ON");
    let (watch, mut last, mut longest) = (Stopwatch::start(), Duration::ZERO, Duration::ZERO);
    loop {
        let before = client.heard.len();
        let open = client.read();
        if client.heard.len() > before {
            longest = longest.max(watch.elapsed() - last);
            last = watch.elapsed();
        }
        if !open {
            break;
        }
        assert!(watch.elapsed() < SOON, "the link was not cut");
    }
    assert!(
        longest > Duration::from_millis(1500) && longest < Duration::from_secs(3),
        "{longest:?}"
    );
    vehicle.sees("the cut", SOON, |line| line.text == "client 1 is cut off by a fault");
    // While the link is cut no client can connect, and afterwards every client can.
    Client::connect(&vehicle.address).is_cut_off();
    settle(Duration::from_millis(1200));
    Client::connect(&vehicle.address).hears("$BFVER");

    std::fs::write(&file, "[[fault]]\nat_s = -1\nkind = \"link_cut\"\nfor_s = 1\n").unwrap();
    let refused = Backseat::new()
        .args(["mvc", "--faults"])
        .arg(&file)
        .mission(&mission)
        .run()
        .refusal();
    assert!(refused.contains("faults.toml") && refused.contains("at_s"), "{refused}");
}
