//! Bytes that are no records, and records that are not what they say.

use backseat_s7k::record::{AlarmMode, MessageType};
use backseat_s7k::{DeviceId, FrameHeader, Time7k};
use backseat_sonar::{Decimation, Event};

use crate::controller::{framed, message};
use crate::imagery::{Ping, grant};
use crate::trial::{Trial, config};

fn malformed(trial: &Trial) -> usize {
    let malformed = |event: &Event| matches!(event, Event::Malformed { .. });
    trial.events.iter().filter(|(_, event)| malformed(event)).count()
}

#[test]
fn records_between_garbage_are_found() {
    let mut trial = Trial::with(config(), vec![grant(8, Decimation::Maximum)]).until_ready();
    let noise: Vec<u8> = (0..5000_u32).map(|index| ((index * index) >> 3) as u8).collect();
    for _ in 0..20 {
        let mut bytes = noise.clone();
        bytes.extend_from_slice(&crate::controller::enclosed(&Ping::default().record()));
        for piece in bytes.chunks(777) {
            trial.send(piece.to_vec());
        }
        trial.run_s(0.1);
    }
    assert_eq!(trial.pings.len(), 20);
    assert!(trial.sonar.counts().skipped_bytes >= 20 * 5000);
    assert_eq!(malformed(&trial), 1, "the log gets one line in ten seconds");
    trial.run_s(10.0);
    assert!(trial.has("bytes skipped"));
    assert!(trial.sonar.is_ready());
}

#[test]
fn records_that_are_too_short_are_counted() {
    let mut trial = Trial::ready();
    for record_type in [3000, 3001, 3100, 7200, 7300, 7400, 11_000, 11_001, 11_002] {
        for length in 0..12 {
            let header = FrameHeader::new(record_type, DeviceId(11_001));
            trial.send(framed(header, &vec![0xFF; length]));
        }
    }
    trial.run_s(0.1);
    assert!(trial.sonar.counts().malformed > 80, "{:?}", trial.sonar.counts());
    assert_eq!(malformed(&trial), 1);
    trial.run_s(20.0);
    assert!(trial.sonar.is_ready());
}

#[test]
fn statuses_that_cannot_be_read_still_answer() {
    let mut trial = Trial::ready();
    trial.controller.health = "Sensors: no idea".to_owned();
    trial.run_s(30.0);
    assert_eq!(trial.disconnects.len(), 0);
    assert!(trial.sonar.counts().malformed >= 2);
    let asked = trial.controller.heard.len();
    assert_eq!(asked, 3, "once each time: asking again would bring the same");
}

#[test]
fn statuses_that_nobody_asked_for_are_bounded() {
    let mut trial = Trial::ready();
    let status = |id: i32, text: &str| message(Time7k::NONE, MessageType::Status, AlarmMode::Unspecified, id, text);
    let entries = |count: usize| (0..count).map(|index| format!(", {index}, 1")).collect::<String>();
    trial.send(status(6, &format!("Sensors: 100000{}", entries(100_000))));
    trial.send(status(3, &format!("Logging = 1, {}, 1.0", "x".repeat(100_000))));
    trial.send(status(5, &format!("LoggingSetup = 1, 1, {}", "x".repeat(5000))));
    trial.send(status(99, "something new"));
    trial.send(message(
        Time7k::NONE,
        MessageType::Other(5),
        AlarmMode::Unspecified,
        0,
        "",
    ));
    for _ in 0..5000 {
        trial.send(status(0, "1.0203"));
    }
    trial.run_s(0.1);
    assert_eq!(trial.sonar.counts().unknown_messages, 2);
    assert!(trial.events.len() < 100, "{}", trial.events.len());
    let longest = trial.log().iter().map(String::len).max().unwrap();
    assert!(longest < 9000, "{longest}");
    assert!(trial.sonar.is_ready());
}
