//! Prints the speed table of the sentences: bytes to messages, messages to bytes, and a mixed stream.

use std::hint::black_box;

use backseat_bench::{HEADER, by_hand, in_turn, row};
use backseat_spi::{
    BehaviorId, Framer, FromVehicle, HorizontalMode, Interrupt, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode,
    Policy, Sentence, SpeedMode, ToVehicle, Trackline, VerticalMode, catalogue,
};
use backseat_units::{Position, TimeOfDay};

const NAVIGATION: &[u8] = b"$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E\r\n";
const VELOCITY: &[u8] = b"$BFNVR,081025.987,-0.5864,-1.3746,0.02,0.1,-0.25,1.5*51\r\n";
const ACKNOWLEDGEMENT: &[u8] = b"$BFACK,081025.987,RMB,081025.950,0,2,0,accepted*05\r\n";
const DOPPLER: &[u8] = b"$BFDVL,081025.987,1.5,-0.02,0.01,45.1,45.3,,45,10.25,081025.900*7A\r\n";

pub(crate) fn print() {
    println!("{HEADER}");
    decode("BFNVG", NAVIGATION, || {
        black_box(by_hand::navigation(black_box(NAVIGATION)).expect("it is one"));
    });
    decode("BFNVR", VELOCITY, || {
        black_box(by_hand::velocity(black_box(VELOCITY)).expect("it is one"));
    });
    decode("BFACK", ACKNOWLEDGEMENT, || {
        black_box(by_hand::acknowledgement(black_box(ACKNOWLEDGEMENT)).expect("it is one"));
    });
    decode("BFDVL", DOPPLER, || {
        black_box(by_hand::doppler(black_box(DOPPLER)).expect("it is one"));
    });
    encode();
    stream();
}

/// Nanoseconds of one call, for two in turn: many batches that are shorter than a time slice of a busy machine.
fn best(calls: u32, mut ours: impl FnMut(), mut floor: impl FnMut()) -> (f64, f64) {
    (0..20)
        .map(|_| in_turn(calls, &mut ours, &mut floor))
        .fold((f64::MAX, f64::MAX), |best, times| {
            (best.0.min(times.0), best.1.min(times.1))
        })
}

/// Bytes are pushed into a framer, and the message comes out.
fn decode(name: &str, line: &[u8], floor: impl FnMut()) {
    let mut framer = Framer::new(Policy::FromVehicle);
    let ours = || {
        framer.push(black_box(line));
        let sentence = framer.next_sentence().expect("a whole line was pushed");
        black_box(FromVehicle::decode(&sentence).expect("it is one"));
    };
    let times = best(2_000, ours, floor);
    row(
        &format!("{name} bytes to typed message"),
        times,
        "written by hand for this sentence",
        "ratio 1.3",
    );
}

fn encode() {
    let created = TimeOfDay::from_hms_nano(8, 10, 25, 987_000_000).expect("a time");
    let modify = ToVehicle::from(ModifyBehavior {
        created,
        horizontal: Some(92.5),
        vertical_m: Some(3.25),
        vertical_mode: Some(ModifyVerticalMode::Depth),
        speed: Some(1.5),
        speed_mode: Some(ModifySpeedMode::MetresPerSecond),
        horizontal_mode: Some(HorizontalMode::Heading),
    });
    let trackline = ToVehicle::from(Trackline {
        created,
        identifier: BehaviorId::new(1001),
        start: Position::from_deg(42.363_515_333_333, -71.114_100_5).expect("a position"),
        end: Position::from_deg(42.365_182, -71.114_100_5).expect("a position"),
        vertical_mode: VerticalMode::Altitude,
        vertical_m: 10.0,
        speed: 1.5,
        speed_mode: SpeedMode::MetresPerSecond,
        interrupt: Interrupt::AfterCurrent,
    });
    let millis = 29_425_987;
    let ends = [42.363_515_333_333, 71.114_100_5, 42.365_182, 71.114_100_5];
    compare("BPRMB", &modify, |out| {
        by_hand::modify(out, black_box(millis), black_box([92.5, 3.25, 1.5]));
    });
    compare("BPRTK", &trackline, |out| {
        by_hand::trackline(out, black_box(millis), 1001, black_box(ends), black_box([10.0, 1.5]));
    });
}

/// A message is written into a buffer with room; both ways must write the same bytes.
fn compare(name: &str, message: &ToVehicle, floor: impl Fn(&mut Vec<u8>)) {
    let (mut ours, mut by_hand) = (Vec::new(), Vec::new());
    message.encode(&mut ours).expect("it can be written");
    floor(&mut by_hand);
    assert_eq!(ours.escape_ascii().to_string(), by_hand.escape_ascii().to_string());
    let times = best(
        2_000,
        || {
            ours.clear();
            black_box(message).encode(&mut ours).expect("it can be written");
            black_box(&ours);
        },
        || {
            by_hand.clear();
            floor(&mut by_hand);
            black_box(&by_hand);
        },
    );
    row(
        &format!("typed {name} to bytes"),
        times,
        "written by hand for this sentence",
        "ratio 1.3",
    );
}

/// A minute of a busy vehicle as it would be read from a socket: 10 Hz of navigation, velocity, DVL and inertial data,
/// the slower sensors, the mission's messages, and a little noise. No number occurs twice, so that branch predictors
/// cannot learn them.
fn stream() {
    let stream = traffic();
    let reads = || stream.chunks(4096);
    let mut framer = Framer::new(Policy::FromVehicle);
    let mut ours = || {
        for read in reads() {
            framer.push(read);
            while let Some(sentence) = framer.next_sentence() {
                black_box(FromVehicle::decode(&sentence).expect("a good sentence"));
            }
        }
    };
    let mut floor = || {
        let mut lines = 0u64;
        for read in reads() {
            lines += memchr::memchr_iter(b'\n', black_box(read)).count() as u64;
        }
        black_box(lines);
    };
    let times = best(1, &mut ours, &mut floor);
    let speed = |nanos: f64| stream.len() as f64 / nanos * 1000.0;
    println!(
        "| mixed stream to typed messages | {:.0} MB/s | {:.0} MB/s (lines found by memchr, nothing read) | {:.1} | 300 MB/s |",
        speed(times.0),
        speed(times.1),
        times.0 / times.1
    );
}

fn traffic() -> Vec<u8> {
    let mut random = Random(1);
    let mut stream = String::new();
    for _ in 0..60 {
        for _ in 0..10 {
            for name in ["BFNVG", "BFNVR", "BFDVL", "BFIMU", "BFRNV"] {
                random.line(name, &mut stream);
            }
        }
        for name in [
            "BFACK", "BFMIS", "BFMBS", "BFCTD", "BFRBS", "BFRVL", "BFSVS", "BFERC", "BFRDP", "BFRCM", "BFPLN",
        ] {
            random.line(name, &mut stream);
        }
        stream.push_str("login: \r\n\r\n\n$BFNVG,081025.987,42");
        random.line("BFACK", &mut stream);
        stream.push_str("$BFCTL,081025.987,0*78\r\n");
    }
    stream.into_bytes()
}

/// A linear congruential generator of numbers that look like a vehicle's.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }

    /// The catalogue's example of a message, with other numbers.
    fn line(&mut self, name: &str, out: &mut String) {
        let entry = catalogue()
            .iter()
            .find(|entry| entry.name == name)
            .expect("it is in the catalogue");
        let formats = entry
            .fields
            .iter()
            .flat_map(|field| field.formats.iter().map(move |format| (*format, field.range)));
        let sentence = Sentence::parse(entry.example).expect("an example is a sentence");
        let mut body = name.to_owned();
        for ((format, range), example) in formats.zip(sentence.fields()) {
            body.push(',');
            if format == "x.x" {
                let sign = if range == "any" && self.below(3) == 0 { "-" } else { "" };
                let decimals = 1 + self.below(4) as usize;
                let value = self.below(100_000) as f64 / 1000.0;
                body.push_str(&format!("{sign}{value:.decimals$}"));
            } else {
                body.push_str(example);
            }
        }
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        out.push_str(&format!("${body}*{sum:02X}\r\n"));
    }
}
