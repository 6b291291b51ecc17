//! A day at sea in one run: from before midnight over a leap second to the next evening, on a link that splits, joins,
//! corrupts and breaks, with a plugin that asks for modifies and inserts all the time. Core loses nothing except the
//! sentences that were cut, and at the end every request has its outcome.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use backseat_core::plugin::{EndCause, Ended, Rule};
use backseat_core::plugin::{Event, Request, RequestState, Sample, StepInput, Topic, VerticalRequest};
use backseat_core::refusal::Uncontrolled;
use backseat_core::{Limits, Note, RequestKind};
use backseat_spi::{Direction, FrameCounts, MAX_LINE, catalogue};
use backseat_units::{EastNorth, TimeOfDay, Timestamp, Utc};

use crate::course::{self, line};
use crate::trial::{Seen, Setup, Trial};
use crate::vehicle::Reply;

const DAY_S: f64 = 86_400.0;
/// The dive begins this many seconds before midnight on the vehicle's clock.
const BEFORE_MIDNIGHT_S: u64 = 1800;
/// Our clock is this many seconds behind the vehicle's, so that the two midnights are two events.
const BEHIND_S: u64 = 300;
/// For this many seconds before and after each midnight nothing else happens.
const QUIET_S: f64 = 40.0;

/// Splitmix64 (Steele, Lea, Flood, OOPSLA 2014): the day is the same each time.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }

    fn one_in(&mut self, many: u64) -> bool {
        self.below(many) == 0
    }
}

/// The bad line between vehicle and payload, and what core must have counted on it.
struct BadLine {
    chance: Chance,
    counts: FrameCounts,
    /// Whether nothing is wrong with the line at the moment.
    good: bool,
}

fn checked(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

impl BadLine {
    fn pass(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::with_capacity(bytes.len() + 64);
        for sentence in bytes.split_inclusive(|byte| *byte == b'\n') {
            if !self.good && self.chance.one_in(40) {
                self.disturb(sentence, &mut out);
            }
            let navigation = sentence.starts_with(b"$BFNV");
            if !self.good && navigation && self.chance.one_in(200) {
                self.corrupt(sentence, &mut out);
            } else {
                out.extend_from_slice(sentence);
                self.counts.sentences += 1;
            }
        }
        out
    }

    /// Writes the sentence with one digit changed.
    fn corrupt(&mut self, sentence: &[u8], out: &mut Vec<u8>) {
        let mut copy = sentence.to_vec();
        let digits: Vec<usize> = (0..copy.len()).filter(|at| copy[*at].is_ascii_digit()).collect();
        let at = digits[usize::try_from(self.chance.below(digits.len() as u64)).unwrap()];
        copy[at] = b'0' + (copy[at] - b'0' + 1) % 10;
        out.extend_from_slice(&copy);
        self.counts.checksum_invalid += 1;
    }

    /// Writes something that does not belong there, before a sentence.
    fn disturb(&mut self, sentence: &[u8], out: &mut Vec<u8>) {
        let bare = &sentence[..sentence.len() - "*HH\r\n".len()];
        match self.chance.below(12) {
            0..2 => self.corrupt(sentence, out),
            2 => {
                out.extend_from_slice(bare);
                out.extend_from_slice(b"\r\n");
                self.counts.checksum_absent += 1;
            }
            3..5 => {
                let cut = usize::try_from(1 + self.chance.below(bare.len() as u64 - 1)).unwrap();
                out.extend_from_slice(&bare[..cut]);
                self.counts.cut_short += 1;
            }
            5 => {
                out.extend_from_slice(bare);
                out.extend_from_slice(b"\xff*00\r\n");
                self.counts.not_utf8 += 1;
            }
            6 => {
                out.extend_from_slice(b"$,1*1D\r\n");
                self.counts.malformed += 1;
            }
            7 => {
                let noise = ["login: ", "\0\0\0", "x", "BFNVG,", "\r\n\n\r\n"];
                let noise = noise[usize::try_from(self.chance.below(noise.len() as u64)).unwrap()];
                out.extend_from_slice(noise.as_bytes());
                self.counts.noise_bytes += noise.trim_matches(['\r', '\n']).len() as u64;
            }
            8 => {
                out.extend_from_slice(&checked("BFXYZ,1,2,3"));
                self.counts.sentences += 1;
            }
            9 => {
                // A well-formed sentence with invalid fields.
                out.extend_from_slice(&checked("BFNVG,at noon,,,,,"));
                self.counts.sentences += 1;
            }
            10 if self.chance.one_in(10) => {
                let length = MAX_LINE + usize::try_from(self.chance.below(500)).unwrap();
                out.push(b'$');
                out.extend(std::iter::repeat_n(b'A', length));
                out.extend_from_slice(b"\r\n");
                self.counts.too_long += 1;
                self.counts.noise_bytes += (1 + length - MAX_LINE) as u64;
            }
            _ => out.extend_from_slice(b"\r\n\n"),
        }
    }
}

/// The message of the vehicle that an event of the plugin comes from.
fn message_of(event: &Event) -> Option<&'static str> {
    match event {
        Event::Ctd(_) => Some("BFCTD"),
        Event::MissionCommand(_) => Some("BFMSC"),
        Event::LoggingBegan(_) => Some("BFBDL"),
        Event::LoggingEnded(_) => Some("BFSDL"),
        Event::Sample(sample) => Some(match sample {
            Sample::Telemetry(_) => "BFTEL",
            Sample::SoundVelocity(_) => "BFSVS",
            Sample::Compass(_) => "BFRCM",
            Sample::Pressure(_) => "BFRDP",
            Sample::VehicleSpeed(_) => "BFRVL",
            Sample::Battery(_) => "BFRBS",
            Sample::Surfaces(_) => "BFERC",
            Sample::Dvl(_) => "BFDVL",
            Sample::DvlBeams(_) => "BFDV2",
            Sample::Imu(_) => "BFIMU",
            Sample::Servo(_) => "BFPIT",
            Sample::Trim(_) => "BFTRM",
            Sample::Buoyancy(_) => "BFBOY",
        }),
        _ => None,
    }
}

const HEARD: [&str; 15] = [
    "BFCTD", "BFMSC", "BFBDL", "BFSDL", "BFTEL", "BFSVS", "BFRCM", "BFRDP", "BFRVL", "BFRBS", "BFERC", "BFDVL",
    "BFDV2", "BFIMU", "BFPIT",
];

/// The example of each message of the vehicle, with the vehicle's time, except those on which control, navigation, plan
/// or acknowledgements depend.
fn traffic(time: TimeOfDay) -> Vec<(&'static str, Vec<u8>)> {
    let (hour, minute, second, nanos) = time.hms_nano();
    let time = format!("{hour:02}{minute:02}{second:02}.{:03}", nanos / 1_000_000);
    let steers = [
        "BFNVG", "BFNVR", "BFCTL", "BFMIS", "BFMBS", "BFMBE", "BFACK", "BFPLN", "BFSHT", "BFVER",
    ];
    let rows = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::FromVehicle);
    rows.filter(|entry| !steers.contains(&entry.name))
        .map(|entry| {
            let (body, _) = entry.example[1..].split_once('*').unwrap();
            let fields: Vec<&str> = body
                .split(',')
                .map(|field| {
                    if field.starts_with("08102") {
                        time.as_str()
                    } else {
                        field
                    }
                })
                .collect();
            (entry.name, checked(&fields.join(",")))
        })
        .collect()
}

/// How often each request has ended, and the other counts of the day.
#[derive(Default)]
struct Books {
    ends: BTreeMap<u64, u32>,
    kinds: BTreeMap<&'static str, u64>,
    lost: BTreeMap<Option<Uncontrolled>, u64>,
    connections: u64,
    resets: u64,
    counts: FrameCounts,
    events: BTreeMap<&'static str, u64>,
    open_most: usize,
}

impl Books {
    /// Counts what the trial has seen, and clears it.
    fn enter(&mut self, trial: &mut Trial) {
        for (at, seen) in trial.seen.drain(..) {
            match seen {
                Seen::Note(Note::Request(transition)) => {
                    let ends = self.ends.entry(transition.request).or_default();
                    let (kind, over) = match transition.state {
                        RequestState::Rejected(refusal) => {
                            assert_ne!(refusal.rule(), Rule::Limit, "{refusal} at {at}");
                            ("rejected", true)
                        }
                        RequestState::Sent if transition.kind == RequestKind::Modify => ("modify sent", false),
                        RequestState::Sent if transition.kind == RequestKind::Trackline => ("insert sent", false),
                        RequestState::Sent => ("other sent", false),
                        RequestState::Pending => ("pending", false),
                        RequestState::Accepted => ("accepted", false),
                        RequestState::Failed(_) => ("failed", true),
                        RequestState::TimedOut => ("timed out", true),
                        RequestState::Unknown => ("unknown", false),
                        RequestState::Started => ("started", false),
                        RequestState::Ended(_) => ("ended", true),
                        RequestState::Cancelled => ("cancelled", true),
                    };
                    *self.kinds.entry(kind).or_default() += 1;
                    *ends += u32::from(over);
                }
                Seen::Note(Note::Control { granted: false, reason }) => {
                    *self.lost.entry(reason).or_default() += 1;
                }
                Seen::Note(Note::LinkUp) => self.connections += 1,
                Seen::Note(Note::LinkDown { counts, .. }) => self.counts = counts,
                Seen::Note(Note::Late { .. }) => panic!("late at {at}"),
                Seen::Note(Note::PluginFailed { fault, .. }) => panic!("{fault:?} at {at}"),
                Seen::Reset => self.resets += 1,
                Seen::Invoke(_, StepInput { events, .. }) => {
                    assert!(events.len() <= 256);
                    for message in events.iter().filter_map(message_of) {
                        *self.events.entry(message).or_default() += 1;
                    }
                }
                _ => {}
            }
        }
        self.open_most = self.open_most.max(trial.core.open_requests());
    }
}

/// Asks for modifies and inserts in turn, and takes some of them back.
fn surveyor(mut chance: Chance) -> impl FnMut(&StepInput) -> Vec<Request> {
    let (mut tag, mut inserted) = (0, 0);
    move |input| {
        if !input.control || chance.below(4) > 0 {
            return Vec::new();
        }
        tag += 1;
        match chance.below(10) {
            0 => vec![Request::EndModify],
            1 => vec![Request::Cancel(inserted)],
            2..4 => {
                inserted = tag;
                let north_m = 200.0 + chance.below(300) as f64;
                vec![Request::Trackline(line(tag, (0.0, north_m), (40.0, north_m)))]
            }
            _ => vec![Request::Modify(backseat_core::plugin::ModifyRequest {
                tag,
                heading_deg: chance.below(360) as f64,
                vertical: VerticalRequest::DepthM(15.0 + chance.below(20) as f64),
                speed_mps: 1.5,
                duration: Duration::from_secs(2 + chance.below(10)),
            })],
        }
    }
}

fn setup() -> Setup {
    let mut plugin = course::plugin("surveyor");
    plugin.description.step_period = Duration::from_secs(1);
    plugin.description.topics = vec![
        Topic::Ctd,
        Topic::MissionCommand,
        Topic::Behavior,
        Topic::Logging,
        Topic::Telemetry,
        Topic::SoundVelocity,
        Topic::Compass,
        Topic::Pressure,
        Topic::VehicleSpeed,
        Topic::Battery,
        Topic::Surfaces,
        Topic::Dvl,
        Topic::DvlBeams,
        Topic::Imu,
        Topic::Servo,
    ];
    let mut setup = Setup {
        limits: Limits {
            inserts_total_max: 1_000_000,
            inserts_open_max: 50,
            inserts_duration_max_s: 100_000.0,
            ..course::limits()
        },
        plugins: vec![plugin],
        ..Setup::default()
    };
    setup.start.utc = Utc::from_unix_nanos((1_700_006_400 - BEFORE_MIDNIGHT_S - BEHIND_S) * 1_000_000_000);
    setup
}

/// Makes one thing happen, or none, between the quiet times.
fn happen(trial: &mut Trial, chance: &mut Chance) {
    let now = trial.now;
    match chance.below(1000) {
        // The link breaks in the middle of a sentence, and only that sentence is lost.
        0..11 if trial.is_connected() => {
            if chance.one_in(3) {
                // Some inserts have been sent but not answered.
                let late = Reply::Late(Duration::from_millis(900), backseat_spi::AckStatus::Succeeded);
                trial.vehicle.replies.insert("RTK", late);
                trial.run_for(1.5);
                trial.vehicle.replies.clear();
            }
            trial.feed(backseat_core::Input::Received(b"$BFNVG,0000"));
            trial.cut();
        }
        11..13 => {
            trial.unreachable = true;
            trial.cut();
            trial.run_for(20.0);
            trial.unreachable = false;
        }
        13..18 => trial.stalled_until = now + Duration::from_millis(200 + chance.below(6000)),
        18 => {
            trial.vehicle.navigates = false;
            trial.run_for(16.0 * chance.below(2) as f64 + 6.0);
            trial.vehicle.navigates = true;
        }
        19..22 => {
            trial.vehicle.set_control(now, false);
            let back = now + Duration::from_secs(1 + chance.below(10));
            trial.run_for(back.since(now).as_secs_f64());
            trial.vehicle.set_control(back, true);
        }
        22..30 => {
            let reply = match chance.below(5) {
                0 => Reply::Refuse,
                1 => Reply::Silent,
                2 => Reply::Pending(Duration::from_millis(900), backseat_spi::AckStatus::Succeeded),
                3 => Reply::Late(Duration::from_millis(700), backseat_spi::AckStatus::Succeeded),
                _ => Reply::Nak,
            };
            let name = ["RTK", "RMB", "RCN", "RMP"][usize::try_from(chance.below(4)).unwrap()];
            trial.vehicle.replies.insert(name, reply);
        }
        30..80 => trial.vehicle.replies.clear(),
        80..140 => {
            // The vehicle flies an insert.
            if let Some(identifier) = trial.vehicle.inserted.first().copied() {
                trial.vehicle.begin(now, None, Some(identifier));
                trial.vehicle.end(now + Duration::from_secs(5), None, Some(identifier));
                goes_on(trial, now + Duration::from_secs(5));
                trial.vehicle.inserted.remove(&identifier);
            }
        }
        // One mission ends and the next begins: nothing of the first stays in doubt.
        140 if chance.one_in(5) => {
            trial.vehicle.set_status(now, "Completed");
            trial.vehicle.inserted.clear();
            trial.run_for(5.0);
            let next = trial.now;
            trial.vehicle.set_status(next, "Running");
            trial.vehicle.begin(next, Some(1), None);
        }
        141..180 => trial.read_max = usize::try_from(1 + chance.below(400)).unwrap(),
        _ => {}
    }
}

#[test]
fn sr_009_sr_013_a_day_of_traffic_loses_only_cut_sentences_and_every_request_ends() {
    let mut trial = Trial::with(setup());
    let midnight = Timestamp::from_secs(BEFORE_MIDNIGHT_S);
    let ours = midnight + Duration::from_secs(BEHIND_S);
    let vehicle_start = (1_700_006_400 - BEFORE_MIDNIGHT_S) * 1_000_000_000;
    trial.vehicle.utc = Utc::from_unix_nanos(vehicle_start);
    trial.vehicle.leap_at = Some(midnight);
    trial.vehicle.speed_mps = 0.0;
    let mut survey = surveyor(Chance(1));
    trial.script(0, move |input| (Duration::from_millis(2), Ok(survey(input))));
    let bad = Rc::new(RefCell::new(BadLine {
        chance: Chance(5),
        counts: FrameCounts::default(),
        good: false,
    }));
    let way = Rc::clone(&bad);
    trial.way = Some(Box::new(move |bytes| way.borrow_mut().pass(&bytes)));
    let (mut chance, mut books) = (Chance(3), Books::default());
    let mut said: BTreeMap<&'static str, u64> = BTreeMap::new();

    while trial.now.as_secs_f64() < DAY_S {
        let around =
            |event: Timestamp, now: Timestamp| (-QUIET_S..QUIET_S).contains(&(now.as_secs_f64() - event.as_secs_f64()));
        let quiet = around(midnight, trial.now) || around(ours, trial.now);
        let turn = trial.now.as_secs_f64() / 50.0;
        trial.vehicle.jump = EastNorth::default().offset(turn.to_degrees() % 360.0, 40.0);
        if quiet {
            bad.borrow_mut().good = true;
            settle(&mut trial, &mut books, midnight, ours);
            bad.borrow_mut().good = false;
            continue;
        }
        // The line is bad for one minute of ten.
        let good = trial.now.as_secs_f64() % 600.0 >= 60.0;
        if core::mem::replace(&mut bad.borrow_mut().good, good) != good && good {
            // While the line was bad a begin may have been lost: the vehicle says again what it flies.
            let now = trial.now;
            goes_on(&mut trial, now);
        }
        happen(&mut trial, &mut chance);
        if trial.is_connected() && chance.one_in(10) {
            for (name, bytes) in traffic(trial.vehicle.clock(trial.now)) {
                trial.hear_bytes(&bytes);
                *said.entry(name).or_default() += 1;
            }
        }
        trial.run_for(1.0);
        books.enter(&mut trial);
    }

    trial.vehicle.replies.clear();
    (trial.vehicle.navigates, trial.unreachable) = (true, false);
    trial.run_for(30.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(20.0);
    assert_eq!(trial.core.open_requests(), 0, "no request is open");
    trial.cut();
    books.enter(&mut trial);

    let expected = bad.borrow().counts;
    assert_eq!(
        books.counts, expected,
        "core takes every intact sentence and counts every other one under its cause"
    );
    for message in HEARD {
        assert_eq!(books.events.get(message), said.get(message), "{message}");
    }
    let counts = trial.core.request_counts();
    assert_eq!(counts.proposed, books.ends.len() as u64);
    assert!(
        books.ends.values().all(|ends| *ends == 1),
        "each request ends exactly once"
    );
    let of = |kind: &str| books.kinds.get(kind).copied().unwrap_or(0);
    assert_eq!(
        (counts.rejected, counts.sent),
        (of("rejected"), of("modify sent") + of("insert sent") + of("other sent"))
    );
    assert!(counts.add_up() && counts.waiting + counts.undecided == 0, "{counts:?}");
    // What failed after the vehicle had accepted it counts as accepted.
    assert!((1..=of("failed")).contains(&counts.failed), "{counts:?}");
    assert!(counts.unanswered >= of("timed out"), "{counts:?}");
    assert_eq!(
        counts.proposed,
        of("rejected") + of("failed") + of("timed out") + of("ended") + of("cancelled")
    );
    assert_eq!(trial.core.late_count(), 0);
    // The day was as busy as it should be.
    assert!(books.connections > 1000, "{} connections", books.connections);
    assert!(
        expected.sentences > 1_500_000 && books.resets > 5,
        "{expected:?}, {} resets",
        books.resets
    );
    assert!(
        of("modify sent") > 5000 && of("insert sent") > 1000 && of("started") > 200,
        "{:?}",
        books.kinds
    );
    assert!(
        of("unknown") > 0 && of("cancelled") > 0 && of("pending") > 0,
        "{:?}",
        books.kinds
    );
    assert!(books.open_most <= 60, "{} requests were open at once", books.open_most);
}

/// The plan goes on: with a behavior that is over at once, and with the first one anew. So the vehicle cannot take up what
/// it flew before a sentence was lost.
fn goes_on(trial: &mut Trial, at: Timestamp) {
    trial.vehicle.begin(at, Some(2), None);
    trial.vehicle.end(at, Some(2), None);
    trial.vehicle.begin(at, Some(1), None);
}

/// Lets a midnight pass. Nothing else is wrong, so no lease ends before its time.
fn settle(trial: &mut Trial, books: &mut Books, midnight: Timestamp, ours: Timestamp) {
    trial.vehicle.replies.clear();
    (trial.read_max, trial.stalled_until) = (usize::MAX, trial.now);
    trial.run_for(19.0);
    // A lost sentence may have been the end of the current behavior.
    goes_on(trial, trial.now);
    trial.run_for(1.0);
    assert!(trial.core.has_control(), "at {}", trial.now);
    books.enter(trial);
    let before = trial.now;
    let event = if before < midnight + Duration::from_secs(1) {
        midnight
    } else {
        ours
    };
    assert!(event > before, "the event at {event} is yet to come at {before}");
    trial.run_for(40.0);
    for (at, seen) in &trial.seen {
        let wrong = match seen {
            Seen::Note(Note::Control { .. } | Note::Navigation { .. } | Note::LinkDown { .. }) | Seen::Reset => true,
            Seen::Note(Note::Request(transition)) => transition.state == RequestState::TimedOut,
            Seen::Note(Note::LeaseEnded { reason, .. }) => {
                !matches!(reason, Ended::By(EndCause::TermOver | EndCause::PluginEnded))
            }
            _ => false,
        };
        assert!(!wrong, "{seen:?} at {at}");
    }
    assert!(trial.sent_since("RMB", before).len() > 5);
    trial.run_for(25.0);
    books.enter(trial);
}
