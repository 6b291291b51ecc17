//! Floods: what is held is bounded, and samples are copied nowhere but into their bins.

use allocation_counter::measure;
use backseat_sonar::{Decimation, EVENTS_MAX, Input, Order, Output, PINGS_MAX, SENDS_MAX, Sonar};
use backseat_units::Timestamp;

use crate::controller::enclosed;
use crate::imagery::{Ping, grant, seabed};
use crate::trial::{Trial, config, navigation, start};

/// A ping of two times 8192 samples, in pieces as a socket gives them.
fn large() -> Vec<u8> {
    let ping = Ping {
        channels: vec![seabed(8192, 2000), seabed(8192, 2000)],
        ..Ping::default()
    };
    enclosed(&ping.record())
}

fn drain(sonar: &mut Sonar) -> (usize, usize) {
    let (mut pings, mut others) = (0, 0);
    while let Some(output) = sonar.poll_output() {
        match output {
            Output::Ping(_) => pings += 1,
            _ => others += 1,
        }
    }
    (pings, others)
}

#[test]
fn ten_large_pings_a_second_take_no_memory_but_their_bins() {
    let mut trial = Trial::with(config(), vec![grant(512, Decimation::Maximum)]).until_ready();
    let bytes = large();
    let mut at = trial.now;
    let mut pings = 0;
    let mut seconds = |sonar: &mut Sonar, seconds: u64| {
        for _ in 0..seconds * 10 {
            at = at + std::time::Duration::from_millis(100);
            for piece in bytes.chunks(16_384) {
                sonar.handle(at, Input::Received(piece));
            }
            pings += drain(sonar).0;
        }
    };
    // The buffers grow once. (The health that is due meanwhile is not answered, so the test ends before it counts.)
    seconds(&mut trial.sonar, 1);
    let taken = measure(|| seconds(&mut trial.sonar, 6));
    assert_eq!(pings, 70);
    // 60 pings: a list of channels, and the bins of two channels.
    let bins = 2 * 512 * 4;
    let channel = std::mem::size_of::<backseat_sonar::PingChannel>() as u64;
    let a_ping = bins + 2 * channel;
    assert!(taken.bytes_total <= 60 * (a_ping + 200), "{taken:?}");
    assert!(taken.count_total <= 60 * 3 + 20, "{taken:?}");
    assert!(taken.bytes_max <= 2 * a_ping + 20_000, "{taken:?}");
    assert!(taken.bytes_current.abs() < 20_000, "{taken:?}");
    println!("{taken:?}");
}

#[test]
fn without_a_grant_a_ping_takes_no_memory_at_all() {
    let mut trial = Trial::with(config(), Vec::new()).until_ready();
    let bytes = large();
    let at = trial.now;
    trial.sonar.handle(at, Input::Received(&bytes));
    drain(&mut trial.sonar);
    let taken = measure(|| {
        for _ in 0..10 {
            trial.sonar.handle(at, Input::Received(&bytes));
            drain(&mut trial.sonar);
        }
    });
    assert_eq!(taken.count_total, 0, "{taken:?}");
}

#[test]
fn pings_that_the_driver_does_not_take_are_dropped_from_the_oldest() {
    let mut trial = Trial::with(config(), vec![grant(512, Decimation::Maximum)]).until_ready();
    let at = trial.now;
    let taken = measure(|| {
        for number in 0..1000 {
            let ping = Ping {
                number,
                ..Ping::default()
            };
            let bytes = enclosed(&ping.record());
            trial.sonar.handle(at, Input::Received(&bytes));
        }
    });
    assert!(taken.bytes_max < 2_000_000, "{taken:?}");
    assert_eq!(trial.sonar.counts().dropped_pings, 1000 - PINGS_MAX as u64);
    let mut numbers = Vec::new();
    while let Some(output) = trial.sonar.poll_output() {
        if let Output::Ping(ping) = output {
            numbers.push(ping.ping);
        }
    }
    let newest: Vec<u32> = (1000 - PINGS_MAX as u32..1000).collect();
    assert_eq!(numbers, newest);
}

#[test]
fn a_driver_that_takes_nothing_makes_no_queue_grow_without_end() {
    let mut sonar = Sonar::new(config(), start(Vec::new())).unwrap();
    let at = Timestamp::from_secs;
    sonar.handle(at(0), Input::Connected);
    let mut trial = Trial::ready();
    let taken = measure(|| {
        for second in 10..5000 {
            trial.sonar.handle(
                at(second),
                Input::Received(b"garbage that is no record at all, of no use"),
            );
            let sample = navigation(trial.now);
            trial.sonar.handle(at(second), Input::Navigation(sample));
            trial.sonar.handle(at(second), Input::Timeout);
        }
    });
    let (pings, others) = drain(&mut trial.sonar);
    assert!(others <= EVENTS_MAX + SENDS_MAX + 10, "{others}");
    assert_eq!(pings, 0);
    assert!(taken.bytes_max < 1_000_000, "{taken:?}");
}

#[test]
fn a_large_size_that_is_a_lie_holds_no_more_than_the_limit() {
    let settings = backseat_sonar::SonarConfig {
        frame_limit_bytes: 1 << 16,
        ..config()
    };
    let mut trial = Trial::with(settings, Vec::new()).until_ready();
    let mut lie = large();
    lie.truncate(200);
    // The packet says 60,000 bytes, and then others follow that say the same.
    lie[12..16].copy_from_slice(&60_000_u32.to_le_bytes());
    lie[44..48].copy_from_slice(&59_964_u32.to_le_bytes());
    let at = trial.now;
    let taken = measure(|| {
        for _ in 0..10_000 {
            trial.sonar.handle(at, Input::Received(&lie));
            drain(&mut trial.sonar);
        }
    });
    assert!(taken.bytes_max < 6 << 16, "{taken:?}");
    // The client notices by the health that nobody answers.
    trial.run_s(40.0);
    assert_eq!(trial.disconnects.len(), 1);
    assert!(trial.sonar.is_ready(), "the next connection is a good one");
    trial.order(Order::Shutdown);
    trial.run_s(10.0);
    assert!(trial.finished.is_some());
}

#[test]
fn vehicle_data_that_the_driver_does_not_take_is_dropped_and_goes_to_no_other_connection() {
    let mut trial = Trial::ready();
    let at = trial.now;
    for _ in 0..100 * 25 {
        let sample = navigation(at);
        trial.sonar.handle(at, Input::Navigation(sample));
    }
    assert_eq!(trial.sonar.counts().dropped_sends, 100 - SENDS_MAX as u64);
    trial.sonar.handle(at, Input::Lost);
    let (_, others) = drain(&mut trial.sonar);
    assert_eq!(others, 1, "the loss is reported, and nothing is sent any more");
}
