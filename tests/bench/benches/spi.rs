//! Prints the speed table of the sentences: bytes to messages, messages to bytes, and a mixed stream.

use std::hint::black_box;

use backseat_bench::{HEADER, by_hand, in_turn, row};
use backseat_spi::{
    BehaviorId, Framer, FromVehicle, HorizontalMode, Interrupt, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode,
    Policy, SpeedMode, ToVehicle, Trackline, VerticalMode, catalogue,
};
use backseat_units::{Position, TimeOfDay};

const NAVIGATION: &[u8] = b"$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E\r\n";
const VELOCITY: &[u8] = b"$BFNVR,081025.987,-0.5864,-1.3746,0.02,0.1,-0.25,1.5*51\r\n";
const ACKNOWLEDGEMENT: &[u8] = b"$BFACK,081025.987,RMB,081025.950,0,2,0,accepted*05\r\n";
const DOPPLER: &[u8] = b"$BFDVL,081025.987,1.5,-0.02,0.01,45.1,45.3,,45,10.25,081025.900*7A\r\n";

fn main() {
    // `cargo test --benches` runs this too, and has no time for it.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
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

/// Bytes pushed into a framer, and the message out.
fn decode(name: &str, line: &[u8], floor: impl FnMut()) {
    let mut framer = Framer::new(Policy::FromVehicle);
    let ours = || {
        framer.push(black_box(line));
        let sentence = framer.next_sentence().expect("a whole line was pushed");
        black_box(FromVehicle::decode(&sentence).expect("it is one"));
    };
    let times = in_turn(100_000, ours, floor);
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

/// A message into a buffer with room; both must write the same bytes.
fn compare(name: &str, message: &ToVehicle, floor: impl Fn(&mut Vec<u8>)) {
    let (mut ours, mut by_hand) = (Vec::new(), Vec::new());
    message.encode(&mut ours).expect("it can be written");
    floor(&mut by_hand);
    assert_eq!(ours.escape_ascii().to_string(), by_hand.escape_ascii().to_string());
    let times = in_turn(
        100_000,
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

/// A second of a busy vehicle, over and over, as it would be read from a socket: 10 Hz of navigation, velocity, DVL and
/// inertial data, the slower sensors, what the mission says, and a little noise.
fn stream() {
    let stream = traffic();
    let reads = || stream.chunks(4096);
    let mut framer = Framer::new(Policy::FromVehicle);
    let times = in_turn(
        1,
        || {
            for read in reads() {
                framer.push(read);
                while let Some(sentence) = framer.next_sentence() {
                    black_box(FromVehicle::decode(&sentence).expect("a good sentence"));
                }
            }
        },
        || {
            let mut lines = 0u64;
            for read in reads() {
                lines += memchr::memchr_iter(b'\n', black_box(read)).count() as u64;
            }
            black_box(lines);
        },
    );
    let speed = |nanos: f64| stream.len() as f64 / nanos * 1000.0;
    println!(
        "| mixed stream to typed messages | {:.0} MB/s | {:.0} MB/s (lines found by memchr, nothing read) | {:.1} | 300 MB/s |",
        speed(times.0),
        speed(times.1),
        times.0 / times.1
    );
}

fn traffic() -> Vec<u8> {
    let line = |name: &str| {
        let entry = catalogue().iter().find(|entry| entry.name == name);
        format!("{}\r\n", entry.expect("it is in the catalogue").example)
    };
    let fast: String = ["BFNVG", "BFNVR", "BFDVL", "BFIMU", "BFRNV"].map(line).concat();
    let mut second = fast.repeat(10);
    for name in [
        "BFACK", "BFMIS", "BFMBS", "BFCTD", "BFRBS", "BFRVL", "BFSVS", "BFERC", "BFRDP", "BFRCM", "BFPLN",
    ] {
        second.push_str(&line(name));
    }
    second.push_str("login: \r\n\r\n\n$BFNVG,081025.987,42");
    second.push_str(&line("BFACK"));
    second.push_str("$BFCTL,081025.987,0*78\r\n");
    second.repeat(500).into_bytes()
}
