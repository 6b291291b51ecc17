//! The web console of a run, as a process: hold and release at a browser, and browsers that misbehave.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use backseat_suite::{Backseat, Behavior, Mission, Process, Scripted, eventually, settle};
use serde_json::Value;

use super::heard::{ended_after_s, worst_gap_s};
use super::session::{SOON, command, runtime};

/// Where the console of a process is.
pub(super) fn address(process: &Process) -> String {
    let line = process.says("console: http://", SOON);
    let rest = line.split("http://").nth(1).expect("the line has it");
    rest.split(';').next().expect("a word").to_owned()
}

fn ask(address: &str, request: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("the console listens");
    stream.set_read_timeout(Some(SOON)).expect("a socket");
    stream.write_all(request.as_bytes()).expect("it reads");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("it answers");
    answer
}

pub(super) fn get(address: &str, path: &str) -> String {
    let answer = ask(
        address,
        &format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"),
    );
    answer.split("\r\n\r\n").skip(1).collect()
}

fn act(address: &str, token: &str, act: &str) -> String {
    let body = format!(r#"{{"act":"{act}","who":"Ann"}}"#);
    ask(
        address,
        &format!(
            "POST /api/operator HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Authorization: Bearer {token}\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        ),
    )
}

#[test]
fn sr_015_the_console_holds_and_releases_and_the_log_has_who() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let mut process = runtime(&mission, &vehicle.address, &["--arm", "--console=127.0.0.1:0"]);
    let console = address(&process);
    vehicle.hears("BPRMB", 3, SOON);
    let token = std::fs::read_to_string(mission.beside("state/console.token")).expect("the token is beside the hold");
    assert!(act(&console, "0123", "hold").starts_with("HTTP/1.1 401"));
    let at_s = vehicle.now_s();
    assert!(act(&console, token.trim(), "hold").starts_with("HTTP/1.1 202"));
    let ended_s = ended_after_s(&vehicle, at_s, SOON);
    assert!(ended_s < 1.0, "{ended_s} s from the hold to BPEMB");
    assert!(mission.beside("state/hold").exists());
    let held: Vec<Value> = eventually(
        SOON,
        || {
            let history = get(&console, "/api/history");
            let items: Vec<Value> = history
                .lines()
                .filter_map(|line| serde_json::from_str(line).ok())
                .collect();
            items.iter().any(|item| item["kind"] == "operator").then_some(items)
        },
        || "the console does not show the hold".to_owned(),
    );
    assert!(
        held.iter().any(|item| item["text"] == "Ann at the console: hold"),
        "{held:?}"
    );
    let steered = |item: &Value| item["kind"] == "steering" && item["owner"] == "pilot";
    assert!(held.iter().any(steered), "{held:?}");
    let steered = vehicle.heard("BPRMB").len();
    assert!(act(&console, token.trim(), "release").starts_with("HTTP/1.1 202"));
    vehicle.hears("BPRMB", steered + 2, SOON);
    vehicle.shut_down();
    process.signal(backseat_suite::Signal::TERM);
    process.wait(SOON);
    let logs = std::fs::read_dir(mission.beside("logs")).expect("there is a log");
    let log = logs.filter_map(Result::ok).next().expect("there is one").path();
    let shown = Backseat::new()
        .args(["log", "view", "--listen", "127.0.0.1:0"])
        .arg(&log)
        .spawn();
    let line = eventually(
        SOON,
        || shown.stdout().lines().next().map(str::to_owned),
        || "log view says nothing".to_owned(),
    );
    let viewed = line
        .trim_start_matches("http://")
        .split(' ')
        .next()
        .expect("a word")
        .to_owned();
    let history = get(&viewed, "/api/history");
    assert!(
        history.contains("Ann at the console: hold") && history.contains(r#""kind":"end""#),
        "{history}"
    );
    assert!(act(&viewed, token.trim(), "hold").starts_with("HTTP/1.1 409"));
}

#[test]
fn sr_022_browsers_that_take_nothing_cost_the_loop_nothing() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let process = runtime(&mission, &vehicle.address, &["--arm", "--console=127.0.0.1:0"]);
    let console = address(&process);
    vehicle.hears("BPRMB", 3, SOON);
    let since_s = vehicle.now_s();
    // Browsers that ask and never read, ask for the feed and never read it, and that say nothing at all.
    let feed = format!(
        "GET /api/feed?after=0 HTTP/1.1\r\nHost: {console}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    let history = format!("GET /api/history HTTP/1.1\r\nHost: {console}\r\n\r\n");
    let mut browsers = Vec::new();
    for place in 0..300 {
        let Ok(mut stream) = TcpStream::connect(&console) else {
            continue;
        };
        match place % 3 {
            0 => drop(stream.write_all(feed.as_bytes())),
            1 => drop(stream.write_all(history.as_bytes())),
            _ => {}
        }
        browsers.push(stream);
    }
    settle(Duration::from_secs(8));
    let steered = vehicle.heard_since("BPRMB", since_s);
    let gap_s = worst_gap_s(&steered);
    assert!(
        steered.len() >= 6 && gap_s < 2.5,
        "{gap_s} s without a modify, {} of them",
        steered.len()
    );
    let memory = process.memory_kib();
    assert!(memory < 400 << 10, "{memory} KiB");
    drop(browsers);
}

/// Where viewers of a process are served.
fn viewers(process: &Process) -> String {
    let line = process.says("open the connection ws://", SOON);
    line.rsplit("ws://").next().expect("the line has it").trim().to_owned()
}

/// The first text that a viewer gets after its handshake.
fn greeted(address: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("viewers are served");
    stream.set_read_timeout(Some(SOON)).expect("a socket");
    let request = format!(
        "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).expect("it reads");
    let mut answer = Vec::new();
    let mut piece = [0; 4096];
    while !String::from_utf8_lossy(&answer).contains("\"serverInfo\"") {
        let read = stream.read(&mut piece).expect("it answers");
        assert!(read > 0, "{}", String::from_utf8_lossy(&answer));
        answer.extend(&piece[..read]);
    }
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn sr_022_viewers_look_at_a_run_and_cost_the_loop_nothing() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let process = runtime(&mission, &vehicle.address, &["--arm", "--foxglove=0", "--console=0"]);
    let (viewers, _console) = (viewers(&process), address(&process));
    vehicle.hears("BPRMB", 3, SOON);
    assert!(greeted(&viewers).contains("\"steady\""), "its name is the mission's");
    // Sockets that say nothing, and ones that say nonsense.
    let silent: Vec<TcpStream> = (0..300).filter_map(|_| TcpStream::connect(&viewers).ok()).collect();
    for mut socket in &silent[..50] {
        let _refused = socket.write_all(&[0xff; 4096]);
    }
    let count = vehicle.heard("BPRMB").len();
    vehicle.hears("BPRMB", count + 6, SOON);
    let gap_s = worst_gap_s(&vehicle.heard("BPRMB"));
    assert!(gap_s < 1.5, "{gap_s:.3} s without BPRMB");
    drop(silent);
    let other = Mission::steady();
    let open = runtime(&other, &vehicle.address, &["--foxglove=0.0.0.0:0"]);
    open.says("viewers are served on this computer alone", SOON);
}

/// A process may have 1024 files by default; here 256, so that the test needs fewer sockets itself.
#[test]
fn sr_022_floods_of_pages_and_viewers_leave_files_for_the_vehicle_and_the_hold() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let arguments = ["--arm", "--foxglove=0", "--console=0", "--log-split=10s"];
    let process = command(&mission, &vehicle.address, &arguments).files_max(256).spawn();
    let (viewers, console) = (viewers(&process), address(&process));
    vehicle.hears("BPRMB", 3, SOON);
    let upgrade = |address: &str, path: &str, more: &str| {
        let mut stream = TcpStream::connect(address).ok()?;
        let request = format!(
            "GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{more}\r\n"
        );
        stream.write_all(request.as_bytes()).ok()?;
        Some(stream)
    };
    let flood: Vec<_> = (0..150)
        .flat_map(|_| {
            [
                upgrade(&console, "/api/feed?after=0", ""),
                upgrade(&viewers, "/", "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n"),
                TcpStream::connect(&console).ok(),
            ]
        })
        .collect();
    // Parts of the log begin meanwhile.
    let count = vehicle.heard("BPRMB").len();
    vehicle.hears("BPRMB", count + 12, SOON);
    let token = std::fs::read_to_string(mission.beside("state/console.token")).expect("the token is beside the hold");
    assert!(act(&console, token.trim(), "hold").starts_with("HTTP/1.1 202"));
    eventually(
        SOON,
        || mission.beside("state/hold").exists().then_some(()),
        || format!("the hold is not saved\n{}", process.stderr()),
    );
    assert!(
        !process.stderr().contains("Too many open files"),
        "{}",
        process.stderr()
    );
    // Who comes later is served.
    assert!(greeted(&viewers).contains("\"steady\""));
    drop(flood);
}

#[test]
fn a_flight_is_shown_to_viewers() {
    let mission = Mission::steady();
    let mut flight = Backseat::new()
        .args(["fly", "--speed", "4", "--foxglove=0", "--log"])
        .arg(mission.beside("flight.mcap"))
        .mission(&mission)
        .spawn();
    assert!(greeted(&viewers(&flight)).contains("\"steady\""));
    flight.signal(backseat_suite::Signal::INT);
    assert_eq!(flight.wait(SOON), Some(0), "{}", flight.stderr());
}

#[test]
fn a_run_goes_on_without_a_console_where_its_token_has_no_room() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    // A folder in its place prevents the token as a full disk does.
    std::fs::create_dir_all(mission.beside("state/console.token")).expect("there is room");
    let process = runtime(&mission, &vehicle.address, &["--arm", "--console=127.0.0.1:0"]);
    process.says("no console, the run goes on without", SOON);
    vehicle.hears("BPRMB", 3, SOON);
}

#[test]
fn sr_015_a_hold_before_the_start_is_shown_and_reported() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    std::fs::create_dir_all(mission.beside("state")).expect("there is room");
    std::fs::write(mission.beside("state/hold"), "").expect("there is room");
    let mut process = runtime(&mission, &vehicle.address, &["--arm", "--console=127.0.0.1:0"]);
    let console = address(&process);
    eventually(
        SOON,
        || {
            let held = get(&console, "/metrics").contains("\nbackseat_operator_hold 1");
            held.then_some(())
        },
        || get(&console, "/metrics"),
    );
    vehicle.hears("BPSTS", 3, SOON);
    process.signal(backseat_suite::Signal::INT);
    assert_eq!(process.wait(SOON), Some(0), "{}", process.stderr());
    assert!(vehicle.heard("BPRMB").is_empty());
    let log = std::fs::read_dir(mission.beside("logs")).expect("it has a log").next();
    let log = log.expect("one").expect("it can be read").path();
    let told = Backseat::new().args(["log", "report"]).arg(&log).run().exit(0).stdout;
    for line in [
        "hold: it was set before the start",
        "no control at any time: the operator's hold is set",
    ] {
        assert!(told.contains(line), "{line}: {told}");
    }
}

#[test]
fn a_service_goes_on_without_a_console_whose_port_is_taken() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let other = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let taken = format!("--console={}", other.local_addr().expect("it is bound"));
    let begin = || {
        let runtime = Backseat::new().args(["run", "--arm", "--connect", &vehicle.address, &taken]);
        let runtime = runtime.arg("--log").arg(mission.beside("logs"));
        runtime.arg("--state").arg(mission.beside("state")).mission(&mission)
    };
    // By hand, somebody can give another port; a script can try again.
    let refusal = begin().run().refusal_for_now();
    assert!(
        refusal.starts_with("error: --console: ") && refusal.contains("give another port"),
        "{refusal}"
    );
    let viewers = taken.replace("--console", "--foxglove");
    let process = begin()
        .args([viewers.as_str()])
        .env("NOTIFY_SOCKET", "/nonexistent/notify")
        .spawn();
    process.says("ERROR the run goes on without --console: ", SOON);
    process.says("ERROR the run goes on without --foxglove: ", SOON);
    vehicle.hears("BPRMB", 3, SOON);
}

#[test]
fn a_service_goes_on_without_a_console_whose_certificate_cannot_be_read() {
    let mission = Mission::steady();
    let vehicle = Scripted::start(Behavior::default());
    let begin = || {
        let runtime = Backseat::new().args(["run", "--arm", "--connect", &vehicle.address, "--console=127.0.0.1:0"]);
        let runtime = runtime.args([
            "--console-cert",
            "/nonexistent/cert",
            "--console-key",
            "/nonexistent/key",
        ]);
        let runtime = runtime.arg("--log").arg(mission.beside("logs"));
        runtime.arg("--state").arg(mission.beside("state")).mission(&mission)
    };
    let refusal = begin().run().refusal();
    assert!(refusal.contains("--console-cert and --console-key: "), "{refusal}");
    let process = begin().env("NOTIFY_SOCKET", "/nonexistent/notify").spawn();
    process.says(
        "ERROR the run goes on without --console: --console-cert and --console-key: ",
        SOON,
    );
    vehicle.hears("BPRMB", 3, SOON);
}

#[test]
fn lines_in_the_journal_have_their_priority() {
    let mission = Mission::steady();
    let path = mission.beside("journal");
    let journal = std::fs::File::create(&path).expect("there is room");
    let about = journal.metadata().expect("it is there");
    let stream = {
        use std::os::unix::fs::MetadataExt as _;
        format!("{}:{}", about.dev(), about.ino())
    };
    let _refused = Backseat::new()
        .args(["run", "--connect", "127.0.0.1:1", "--locked", "/nonexistent/ann.pub"])
        .env("JOURNAL_STREAM", stream)
        .stderr_to(journal)
        .mission(&mission)
        .run();
    let told = std::fs::read_to_string(&path).expect("it is there");
    assert!(told.starts_with("<3>error: "), "{told}");
}
