use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::Duration;

use backseat_mvc::{Activity, ClientId, Mvc, MvcEvent, Truth, WorldFile};
use backseat_units::Timestamp;

/// A vehicle with clients, on a clock that jumps from one wake-up to the next.
pub(crate) struct Payload {
    pub(crate) mvc: Mvc,
    pub(crate) now: Timestamp,
    pub(crate) events: Vec<MvcEvent>,
    pub(crate) cut_off: Vec<ClientId>,
    /// How many sentences a blank line followed.
    pub(crate) blank_lines: usize,
    lines: BTreeMap<ClientId, Vec<String>>,
    out: Vec<u8>,
}

/// The client of all tests that have only one.
pub(crate) const ME: ClientId = ClientId(1);

impl Payload {
    pub(crate) fn new(text: &str, seed: u64) -> Self {
        let file = WorldFile::from_toml(text).expect("the test's file is right");
        Self::of(Mvc::new(&file, seed).expect("the test's world is possible"))
    }

    pub(crate) fn of(mvc: Mvc) -> Self {
        Self {
            mvc,
            now: Timestamp::ZERO,
            events: Vec::new(),
            cut_off: Vec::new(),
            blank_lines: 0,
            lines: BTreeMap::new(),
            out: Vec::new(),
        }
    }

    /// A payload that is connected as [`ME`] and has these messages on. What it has received so far is dropped.
    pub(crate) fn connected(text: &str, seed: u64, messages: &[&str]) -> Self {
        let mut payload = Self::new(text, seed);
        payload.connect(ME);
        for message in messages {
            payload.say(&format!("$BPLOG,{message},ON"));
        }
        payload.heard();
        payload
    }

    pub(crate) fn connect(&mut self, client: ClientId) {
        self.connect_from(client, None);
    }

    pub(crate) fn connect_from(&mut self, client: ClientId, address: Option<SocketAddr>) {
        self.mvc.connect_from(self.now, client, address);
        self.drain();
    }

    pub(crate) fn say(&mut self, sentence: &str) {
        self.say_as(ME, sentence);
    }

    pub(crate) fn say_as(&mut self, client: ClientId, sentence: &str) {
        self.bytes(client, format!("{sentence}\r\n").as_bytes());
    }

    pub(crate) fn bytes(&mut self, client: ClientId, bytes: &[u8]) {
        self.mvc.receive(self.now, client, bytes);
        self.drain();
    }

    /// Lets the vehicle's operator act.
    pub(crate) fn operate<T>(&mut self, act: impl FnOnce(&mut Mvc, Timestamp) -> T) -> T {
        let done = act(&mut self.mvc, self.now);
        self.drain();
        done
    }

    /// Lets the time pass until this many seconds after the start.
    pub(crate) fn until(&mut self, seconds: f64) {
        let end = Timestamp::ZERO + Duration::from_secs_f64(seconds);
        while let Some(at) = self.mvc.poll_timeout().filter(|at| *at <= end) {
            self.now = at;
            self.mvc.handle_timeout(at);
            self.drain();
        }
        self.now = end;
    }

    /// Lets the time pass until the condition holds, at most until this many seconds after the start. Returns whether
    /// it holds.
    pub(crate) fn until_that(&mut self, seconds: f64, holds: impl Fn(&Truth) -> bool) -> bool {
        let end = Timestamp::ZERO + Duration::from_secs_f64(seconds);
        while let Some(at) = self.mvc.poll_timeout().filter(|at| *at <= end) {
            self.now = at;
            self.mvc.handle_timeout(at);
            self.drain();
            if holds(&self.mvc.truth()) {
                return true;
            }
        }
        false
    }

    /// What [`ME`] has received since the last call, without the checksums, which were checked.
    pub(crate) fn heard(&mut self) -> Vec<String> {
        self.heard_by(ME)
    }

    pub(crate) fn heard_by(&mut self, client: ClientId) -> Vec<String> {
        let mut lines = self.all_heard_by(client);
        lines.retain(|line| !line.starts_with("$BFBDL,") && !line.starts_with("$BFSDL,"));
        lines
    }

    /// The same as [`Payload::heard`], with BFBDL and BFSDL, which come for every line and circle of the plan, so that
    /// most tests would have to leave them out.
    pub(crate) fn all_heard(&mut self) -> Vec<String> {
        self.all_heard_by(ME)
    }

    pub(crate) fn all_heard_by(&mut self, client: ClientId) -> Vec<String> {
        self.lines.remove(&client).unwrap_or_default()
    }

    /// The vehicle's events since the last call, as its log shows them.
    pub(crate) fn log(&mut self) -> Vec<String> {
        self.events.drain(..).map(|event| event.to_string()).collect()
    }

    fn drain(&mut self) {
        while let Some(client) = self.mvc.poll_transmit(&mut self.out) {
            let text = std::str::from_utf8(&self.out).expect("sentences are ascii");
            self.blank_lines += text.matches("\r\n\n").count();
            let text = text.replace("\r\n\n", "\r\n");
            assert!(text.ends_with("\r\n"), "{text:?}");
            for line in text.split_terminator("\r\n") {
                self.lines.entry(client).or_default().push(checked(line));
            }
        }
        while let Some(client) = self.mvc.poll_disconnect() {
            self.cut_off.push(client);
        }
        while let Some(event) = self.mvc.poll_event() {
            self.events.push(event);
        }
    }
}

/// The sentence without its checksum. The test computes the checksum itself, because it shares no code with the writer.
fn checked(line: &str) -> String {
    let (body, sum) = line.split_at(line.len() - 3);
    let xor = body.trim_start_matches('$').bytes().fold(0, |xor, byte| xor ^ byte);
    assert_eq!(sum, format!("*{xor:02X}"), "{line}");
    body.to_owned()
}

/// A trackline of 100 m to the east, this many hundredths of a minute north of 42 degrees 18 minutes.
pub(crate) fn line(id: u32, hundredths: u32, interrupt: u32) -> String {
    format!(
        "$BPRTK,0700{:02}.000,{id},4218.{hundredths:02},N,07054.00,W,4218.{hundredths:02},N,07053.93,W,0,10,2,0,{interrupt}",
        id % 60
    )
}

/// BFMBS and BFMBE among some lines as `+3` and `-7`: number of the plan, or `i` and the identifier.
pub(crate) fn course(lines: &[String]) -> Vec<String> {
    let behavior = |line: &String| {
        let fields: Vec<&str> = line.split(',').collect();
        let sign = match fields[0] {
            "$BFMBS" => "+",
            "$BFMBE" => "-",
            _ => return None,
        };
        Some(if fields[4].is_empty() {
            format!("{sign}{}", fields[3])
        } else {
            format!("{sign}i{}", fields[4])
        })
    };
    lines.iter().filter_map(behavior).collect()
}

/// Lets the time pass until the mission is over.
pub(crate) fn done(payload: &mut Payload) {
    payload.until_that(5000.0, |truth| truth.activity == Activity::Stopped);
    assert!(payload.mvc.mission_over());
}
