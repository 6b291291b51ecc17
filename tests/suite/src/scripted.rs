//! A simple vehicle over TCP, written from the interface's specification alone: it shares no code with the runtime or
//! the mock. It flies straight east, answers as a test tells it, and can be late, deaf or wrong.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::clock::{Stopwatch, settle, utc_millis};

/// The most lines of noise that wait to be sent, each of a KiB.
const NOISE_WAITING_MAX: usize = 1024;

/// The vehicle's behavior from now on.
#[derive(Clone, Debug)]
pub struct Behavior {
    /// Its sentences leave this much later, in order.
    pub late: Duration,
    /// It receives sentences this much later, in order.
    pub slow: Duration,
    /// It reads nothing.
    pub deaf: bool,
    /// It acknowledges nothing.
    pub mute: bool,
    /// It does not answer BPRMP.
    pub hides_plan: bool,
    /// The dive file that it reports.
    pub dive: &'static str,
    /// Its position moves north at this speed, metres a second, in contradiction to its velocity.
    pub creep_mps: f64,
    /// It sends BFNVR as well as BFNVG.
    pub velocities: bool,
    /// The number of BFMSC a second.
    pub commands_per_s: u32,
    /// The number of BFMBS a second for behaviors that are not in its plan.
    pub begins_per_s: u32,
    /// Unknown sentences, KiB a second, as far as the other side reads them.
    pub noise_kib_per_s: u32,
}

impl Default for Behavior {
    fn default() -> Self {
        Self {
            late: Duration::ZERO,
            slow: Duration::ZERO,
            deaf: false,
            mute: false,
            hides_plan: false,
            dive: "steady.dive",
            creep_mps: 0.0,
            velocities: true,
            commands_per_s: 0,
            begins_per_s: 0,
            noise_kib_per_s: 0,
        }
    }
}

/// A sentence that it received, with the time, seconds since the vehicle's start.
#[derive(Clone, Debug, PartialEq)]
pub struct Heard {
    /// Seconds since the vehicle's start.
    pub at_s: f64,
    /// From `$` to the checksum.
    pub sentence: String,
}

/// The vehicle.
pub struct Scripted {
    /// The address on which it listens.
    pub address: String,
    behavior: Arc<Mutex<Behavior>>,
    heard: Arc<Mutex<Vec<Heard>>>,
    shut_down: Arc<AtomicBool>,
    stop: Arc<AtomicBool>,
    since: Stopwatch,
    thread: Option<JoinHandle<()>>,
}

impl Scripted {
    /// Starts to listen.
    pub fn start(behavior: Behavior) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("it is bound").to_string();
        let behavior = Arc::new(Mutex::new(behavior));
        let heard = Arc::new(Mutex::new(Vec::new()));
        let (stop, shut_down) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let since = Stopwatch::start();
        let serving = Serving {
            behavior: Arc::clone(&behavior),
            heard: Arc::clone(&heard),
            stop: Arc::clone(&stop),
            shut_down: Arc::clone(&shut_down),
            since,
        };
        listener.set_nonblocking(true).expect("it is a socket");
        let thread = std::thread::spawn(move || serving.listen(&listener));
        Self {
            address,
            behavior,
            heard,
            shut_down,
            stop,
            since,
            thread: Some(thread),
        }
    }

    /// Changes its behavior.
    pub fn change(&self, change: impl FnOnce(&mut Behavior)) {
        change(&mut self.behavior.lock().expect("no thread panicked"));
    }

    /// It announces that the power goes off (BFSHT).
    pub fn shut_down(&self) {
        self.shut_down.store(true, Ordering::Relaxed);
    }

    /// Seconds since its start.
    pub fn now_s(&self) -> f64 {
        self.since.elapsed().as_secs_f64()
    }

    /// The sentences of this name that it received.
    pub fn heard(&self, name: &str) -> Vec<Heard> {
        let heard = self.heard.lock().expect("no thread panicked");
        let is = |heard: &&Heard| heard.sentence.get(1..6) == Some(name);
        heard.iter().filter(is).cloned().collect()
    }

    /// The same since a time.
    pub fn heard_since(&self, name: &str, since_s: f64) -> Vec<Heard> {
        let mut heard = self.heard(name);
        heard.retain(|heard| heard.at_s >= since_s);
        heard
    }

    /// Waits until it has received this many sentences of a name.
    ///
    /// # Panics
    ///
    /// If it does not receive them in time.
    pub fn hears(&self, name: &str, count: usize, within: Duration) {
        let watch = Stopwatch::start();
        while self.heard(name).len() < count {
            assert!(
                watch.elapsed() < within,
                "{name}: {} of {count} within {within:?}",
                self.heard(name).len()
            );
            settle(Duration::from_millis(10));
        }
    }
}

impl Drop for Scripted {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ended = thread.join();
        }
    }
}

struct Serving {
    behavior: Arc<Mutex<Behavior>>,
    heard: Arc<Mutex<Vec<Heard>>>,
    stop: Arc<AtomicBool>,
    shut_down: Arc<AtomicBool>,
    since: Stopwatch,
}

/// A connection: what waits in each direction, with the times when it is due.
struct Connection {
    stream: TcpStream,
    partial: Vec<u8>,
    to_hear: VecDeque<(Duration, String)>,
    to_say: VecDeque<(Duration, String)>,
    acknowledges: bool,
    told_s: f64,
}

impl Serving {
    fn listen(&self, listener: &TcpListener) {
        while !self.stop.load(Ordering::Relaxed) {
            match listener.accept() {
                Ok((stream, _)) => self.serve(stream),
                Err(_) => settle(Duration::from_millis(5)),
            }
        }
    }

    fn serve(&self, stream: TcpStream) {
        stream.set_nodelay(true).expect("it is a socket");
        stream.set_nonblocking(true).expect("it is a socket");
        let mut connection = Connection {
            stream,
            partial: Vec::new(),
            to_hear: VecDeque::new(),
            to_say: VecDeque::new(),
            acknowledges: false,
            told_s: self.since.elapsed().as_secs_f64(),
        };
        let (mut navigated, mut said_dive) = (self.since.elapsed(), "");
        let began = self.since.elapsed();
        let mut crept_m = 0.0;
        self.say(&mut connection, format!("BFVER,{},1.12", utc()));
        while !self.stop.load(Ordering::Relaxed) {
            let behavior = self.behavior.lock().expect("no thread panicked").clone();
            let now = self.since.elapsed();
            if !behavior.deaf && !self.read(&mut connection, &behavior) {
                self.hear_the_rest(&mut connection, &behavior);
                return;
            }
            while connection.to_hear.front().is_some_and(|(due, _)| *due <= now) {
                if let Some((_, sentence)) = connection.to_hear.pop_front() {
                    self.obey(&mut connection, &behavior, &sentence);
                }
            }
            if connection.acknowledges && behavior.dive != said_dive {
                said_dive = behavior.dive;
                self.say(&mut connection, format!("BFMIS,{},{said_dive},Running,", utc()));
                self.say(&mut connection, format!("BFCTL,{},1", utc()));
                self.say(&mut connection, format!("BFMBS,{},{said_dive},1,,trackline", utc()));
            }
            if now - navigated >= Duration::from_millis(100) {
                navigated += Duration::from_millis(100);
                let along_s = (now - began).as_secs_f64();
                crept_m += 0.1 * behavior.creep_mps;
                self.navigate(&mut connection, &behavior, along_s, crept_m);
                self.flood(&mut connection, &behavior);
            }
            if self.shut_down.swap(false, Ordering::Relaxed) {
                self.say(&mut connection, format!("BFSHT,{}", utc()));
            }
            if !self.write(&mut connection, now) {
                return;
            }
            settle(Duration::from_millis(1));
        }
    }

    /// The other side has closed the connection. What it sent before is still received, each sentence when it is due.
    fn hear_the_rest(&self, connection: &mut Connection, behavior: &Behavior) {
        while let Some((due, sentence)) = connection.to_hear.pop_front() {
            settle(due.saturating_sub(self.since.elapsed()));
            self.obey(connection, behavior, &sentence);
        }
    }

    /// Straight east from 600 m west of 42.35 N 70.70 W at 1.5 m/s.
    fn navigate(&self, connection: &mut Connection, behavior: &Behavior, along_s: f64, crept_m: f64) {
        let latitude = 42.35 + crept_m / 111_190.0;
        let longitude = 70.70 + (600.0 - 1.5 * along_s) / 82_300.0;
        let minutes = |degrees: f64| (degrees.floor(), (degrees - degrees.floor()) * 60.0);
        let ((lat_deg, lat_min), (lon_deg, lon_min)) = (minutes(latitude), minutes(longitude));
        let created = utc();
        // BFNVG's heading is relative to grid north, which here, at 70.7 W in zone 19, is 1.15 degrees east of true
        // north.
        let grid_deg = 90.0 + 1.146;
        self.say(
            connection,
            format!(
                "BFNVG,{created},{lat_deg:02}{lat_min:09.6},N,{lon_deg:03}{lon_min:09.6},W,0,42.0,8.0,{grid_deg:.2},0.0,0.0,{created}"
            ),
        );
        if behavior.velocities {
            self.say(connection, format!("BFNVR,{created},1.5,0.0,0.0,0.0,0.0,0.0"));
        }
    }

    /// A tenth of a second of the flood.
    fn flood(&self, connection: &mut Connection, behavior: &Behavior) {
        for number in 0..behavior.commands_per_s / 10 {
            self.say(connection, format!("BFMSC,{},flood {number}", utc()));
        }
        for number in 0..behavior.begins_per_s / 10 {
            let unknown = 100 + number + (connection.told_s * 10.0) as u32 % 1000;
            self.say(
                connection,
                format!("BFMBS,{},{},{unknown},,trackline", utc(), behavior.dive),
            );
        }
        // With more waiting, the navigation behind it would be late.
        let room = usize::saturating_sub(NOISE_WAITING_MAX, connection.to_say.len());
        for _ in 0..room.min(behavior.noise_kib_per_s as usize / 10) {
            // The names are not in the interface: lines that are not sentences could have hidden a sentence.
            let body = format!("BFXYZ,{},{}", utc(), "-".repeat(180));
            let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
            let noise = format!("${body}*{sum:02X}\r\n").repeat(5);
            connection.to_say.push_back((self.since.elapsed(), noise));
        }
        connection.told_s += 0.1;
    }

    fn say(&self, connection: &mut Connection, body: String) {
        let late = self.behavior.lock().expect("no thread panicked").late;
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let due = self.since.elapsed() + late;
        let after = connection.to_say.back().map_or(due, |(before, _)| due.max(*before));
        connection.to_say.push_back((after, format!("${body}*{sum:02X}\r\n")));
    }

    fn write(&self, connection: &mut Connection, now: Duration) -> bool {
        while let Some((due, line)) = connection.to_say.front() {
            if *due > now {
                break;
            }
            match connection.stream.write(line.as_bytes()) {
                Ok(written) if written == line.len() => {
                    connection.to_say.pop_front();
                }
                Ok(written) => {
                    let rest = line.get(written..).unwrap_or_default().to_owned();
                    connection.to_say[0].1 = rest;
                    break;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            }
        }
        true
    }

    fn read(&self, connection: &mut Connection, behavior: &Behavior) -> bool {
        let mut bytes = [0; 4096];
        let open = loop {
            match connection.stream.read(&mut bytes) {
                Ok(0) => break false,
                Ok(read) => connection.partial.extend_from_slice(&bytes[..read]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break true,
                Err(_) => break false,
            }
        };
        let due = self.since.elapsed() + behavior.slow;
        while let Some(end) = connection.partial.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = connection.partial.drain(..=end).collect();
            let sentence = String::from_utf8_lossy(&line).trim_end().to_owned();
            let after = connection.to_hear.back().map_or(due, |(before, _)| due.max(*before));
            connection.to_hear.push_back((after, sentence));
        }
        open
    }

    fn obey(&self, connection: &mut Connection, behavior: &Behavior, sentence: &str) {
        self.heard.lock().expect("no thread panicked").push(Heard {
            at_s: self.since.elapsed().as_secs_f64(),
            sentence: sentence.to_owned(),
        });
        let body = sentence.split('*').next().unwrap_or_default();
        let fields: Vec<&str> = body.split(',').collect();
        let name = fields[0].get(3..6).unwrap_or("NAK");
        let created = fields.get(1).copied().unwrap_or_default();
        if name == "LOG" && created == "ACK" {
            connection.acknowledges = true;
        }
        if !connection.acknowledges || behavior.mute {
            return;
        }
        let echo = if name == "LOG" { "000000.000" } else { created };
        if name == "RMP" {
            if behavior.hides_plan {
                return;
            }
            self.say(connection, format!("BFACK,{},RMP,{echo},0,3,0,", utc()));
            for (index, kind, east_m) in [(0, 1, -600.0), (1, 2, 600.0)] {
                let minutes = (0.70 - east_m / 82_300.0) * 60.0;
                self.say(
                    connection,
                    format!("BFPLN,{},1,,{index},{kind},4221.000000,N,070{minutes:09.6},W,,,", utc()),
                );
            }
        }
        self.say(connection, format!("BFACK,{},{name},{echo},0,2,0,done", utc()));
    }
}

/// UTC in the interface's format, `hhmmss.sss`.
fn utc() -> String {
    let millis = utc_millis() % 86_400_000;
    let (hours, minutes) = (millis / 3_600_000, millis / 60_000 % 60);
    format!("{hours:02}{minutes:02}{:02}.{:03}", millis / 1000 % 60, millis % 1000)
}
