//! `spi connect` on a live vehicle.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Process, Signal, Vehicle, Way, eventually, free_address, settle};

use super::session::SOON;
use crate::spi::objects;

fn watch(address: &str, arguments: &[&str]) -> Process {
    Backseat::new()
        .args(["spi", "connect", address])
        .args(arguments.iter().copied())
        .spawn()
}

#[test]
fn connect_subscribes_shows_what_comes_and_sends_nothing_else() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut watch = watch(&vehicle.address, &["--json"]);
    let names = |watch: &Process| {
        let said = watch.stdout();
        let whole = said.rfind('\n').map_or("", |end| &said[..end]);
        objects(whole)
            .iter()
            .map(|object| object["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    for name in ["BFVER", "BFACK", "BFNVG", "BFNVR"] {
        eventually(
            SOON,
            || names(&watch).contains(&name.to_owned()).then_some(()),
            || format!("no {name}\n{}", watch.stdout()),
        );
    }
    watch.signal(Signal::INT);
    assert_eq!(watch.wait(SOON), Some(0), "{}", watch.stderr());
    let said = watch.stderr();
    let summary = said.lines().last().unwrap();
    assert!(summary.contains("1 connection") && summary.contains("BFNVG "), "{said}");
    for object in objects(&watch.stdout()) {
        assert!(
            object["received_s"].is_f64() && object["message"].is_object(),
            "{object}"
        );
    }
    vehicle.receives("BPLOG", 4, SOON);
    // The vehicle's log is written every half second, so that any further line would be there.
    settle(Duration::from_secs(2));
    let received: Vec<_> = vehicle
        .lines()
        .into_iter()
        .filter(|line| line.way == Way::Received)
        .collect();
    assert!(received.iter().all(|line| line.name() == "BPLOG"), "{received:?}");
    let subscribed: Vec<_> = received.iter().map(|line| line.field(1)).collect();
    assert_eq!(subscribed, ["CTL", "ACK", "MIS", "ALL"]);
}

#[test]
fn connect_asks_only_for_what_it_is_told_to() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut watch = watch(&vehicle.address, &["--only", "NVR,ctl", "--seconds", "3"]);
    assert_eq!(watch.wait(SOON), Some(0), "{}", watch.stderr());
    assert!(
        watch.stdout().contains("BFNVR  velocity and rate update: "),
        "{}",
        watch.stdout()
    );
    assert!(!watch.stdout().contains("BFNVG"), "{}", watch.stdout());
    vehicle.receives("BPLOG", 2, SOON);
    settle(Duration::from_secs(2));
    let lines = vehicle.lines();
    let subscribed: Vec<_> = lines
        .iter()
        .filter(|line| line.is_received("BPLOG"))
        .map(|line| line.field(1))
        .collect();
    assert_eq!(subscribed, ["NVR", "CTL"]);
}

/// A scripted vehicle: for each connection, the pieces that it sends after the subscriptions. It keeps the last
/// connection open. Returns the address, and what it has received on each.
fn scripted(connections: Vec<Vec<&'static [u8]>>) -> (String, Arc<Mutex<Vec<String>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("the machine has a free port");
    let address = listener.local_addr().expect("what is bound has an address").to_string();
    let received = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&received);
    std::thread::spawn(move || {
        let last = connections.len() - 1;
        for (index, pieces) in connections.into_iter().enumerate() {
            let (mut stream, _) = listener.accept().expect("the watch connects");
            stream.set_nodelay(true).expect("the stream is open");
            kept.lock().expect("nobody panics with it").push(String::new());
            let mut reader = BufReader::new(stream.try_clone().expect("the stream is open"));
            let mut hear = |count: usize| {
                for _ in 0..count {
                    let mut line = String::new();
                    if reader.read_line(&mut line).unwrap_or(0) == 0 {
                        return;
                    }
                    kept.lock().expect("nobody panics with it")[index].push_str(&line);
                }
            };
            hear(4);
            for piece in pieces {
                send(&mut stream, piece);
            }
            if index == last {
                hear(usize::MAX);
            }
        }
    });
    (address, received)
}

fn send(stream: &mut TcpStream, piece: &[u8]) {
    stream.write_all(piece).expect("the watch reads");
    settle(Duration::from_millis(20));
}

#[test]
fn connect_survives_a_vehicle_of_bad_manners_and_a_silent_one() {
    let (address, received) = scripted(vec![
        vec![
            b"\xff\xfenoise$BFVER,081025.9",
            b"87,1.12*4F\n$BFCTL,081025.987,1*78\n\n\r\n",
            b"$BFCTL,081025.987,1*79\n$BFWHAT,1\n$BFMIS,08",
        ],
        vec![b"$BFCTL,081025.987,0*79\r\n"],
    ]);
    let mut watch = watch(&address, &[]);
    watch.says("the vehicle closed the connection; next attempt in 0.5 s", SOON);
    watch.says("silent for 5", SOON);
    eventually(
        SOON,
        || {
            received
                .lock()
                .unwrap()
                .get(1)
                .filter(|heard| heard.contains("$BPLOG,NVG,ON"))
                .map(|_| ())
        },
        || format!("no second asking, by name\n{:?}", received.lock().unwrap()),
    );
    watch.signal(Signal::TERM);
    assert_eq!(watch.wait(SOON), Some(0), "{}", watch.stderr());
    let shown: Vec<_> = watch.stdout().lines().map(|line| line[11..].to_owned()).collect();
    assert_eq!(
        shown,
        [
            "BFVER  vehicle interface version: created 08:10:25.987, version \"1.12\"",
            "BFCTL  backseat control: created 08:10:25.987, granted yes",
            "BFCTL  error: checksum \"79\" is wrong: 78 is right  $BFCTL,081025.987,1*79",
            "BFWHAT  error: unknown message  $BFWHAT,1",
            "BFMIS  error: cut off: the input ends before the line does  $BFMIS,08",
            "BFCTL  backseat control: created 08:10:25.987, granted no",
        ]
    );
    let said = watch.stderr();
    let summary = said.lines().last().unwrap();
    for part in [
        "2 connections, 6 sentences, 3 read",
        "1 with a wrong checksum",
        "7 bytes of noise",
        "BFCTL 2",
    ] {
        assert!(summary.contains(part), "{part}: {summary}");
    }
    for heard in received.lock().unwrap().iter() {
        assert!(
            heard.starts_with("$BPLOG,CTL,ON*") && heard.lines().all(|line| line.starts_with("$BPLOG,")),
            "{heard}"
        );
    }
}

#[test]
fn connect_to_nobody_says_so_and_is_not_a_success() {
    let address = free_address();
    let watch = Backseat::new()
        .args(["spi", "connect", &address, "--seconds", "2"])
        .run()
        .exit(1);
    assert_eq!(watch.stdout, "");
    assert!(watch.stderr.contains(&format!("{address}: no connection: ")), "{watch}");
    assert!(watch.stderr.contains("next attempt in 1.0 s"), "{watch}");
    assert!(
        watch.stderr.trim_end().ends_with("0 connections, 0 sentences, 0 read"),
        "{watch}"
    );
}
