//! The controller's clock, time messages and what is periodic.

use core::time::Duration;

use backseat_plc::PlcEventKind;
use backseat_s7k::Time7k;
use backseat_s7k::plc::{CalendarTime, Command, Generic};
use backseat_s7k::record::Record;
use backseat_units::{Timestamp, Utc};

use crate::rig::{A, B, Got, LOW, Rig, START, SUB_BOTTOM, frame};

fn seconds_ahead(rig: &Rig) -> f64 {
    let truth = (START + rig.now.since(Timestamp::ZERO)).as_unix_nanos();
    (rig.plc.utc(rig.now).as_unix_nanos() as f64 - truth as f64) / 1e9
}

#[test]
fn the_clock_is_off_and_drifts_until_a_client_sets_it() {
    let mut rig = Rig::ready("clock_offset_s = -3.0\nclock_drift_ppm = 50.0\nsync_delay_s = 0.2");
    rig.run(995.0);
    assert!((seconds_ahead(&rig) + 2.95).abs() < 1e-6, "{}", seconds_ahead(&rig));
    let now = START + rig.now.since(Timestamp::ZERO);
    rig.tell(
        A,
        Command::TimeSync {
            time: CalendarTime::from_utc(now),
        },
    );
    assert!((seconds_ahead(&rig) + 0.2).abs() < 1e-6);
    assert!(
        rig.events
            .iter()
            .any(|event| matches!(event.kind, PlcEventKind::ClockSet(by) if by.abs() > 2_000_000_000))
    );
}

#[test]
fn a_time_message_goes_to_every_client_about_once_a_minute() {
    let mut rig = Rig::ready("");
    rig.connect(B);
    rig.run(200.0);
    assert_eq!(rig.take(B), []);
    rig.tell(A, Command::TimeMessages { on: true });
    rig.take(A);
    rig.run(150.0);
    let times: Vec<Time7k> = [205, 265, 325]
        .map(|seconds| Time7k::from_utc(START + Duration::from_secs(seconds)))
        .to_vec();
    let got = |rig: &mut Rig, client| {
        let time = |got| {
            if let Got::Time(time) = got {
                time
            } else {
                panic!("{got:?}")
            }
        };
        rig.take(client).into_iter().map(time).collect::<Vec<_>>()
    };
    assert_eq!(got(&mut rig, A), times);
    assert_eq!(got(&mut rig, B), times);
    // It is one switch for all.
    rig.tell(B, Command::TimeMessages { on: false });
    rig.run(150.0);
    assert_eq!((got(&mut rig, A), got(&mut rig, B)), (vec![], vec![]));
}

#[test]
fn records_have_the_time_of_their_ping_on_the_controllers_clock() {
    let mut rig = Rig::ready("clock_offset_s = 10.0");
    rig.tell(
        A,
        Command::Subscribe {
            sensor: LOW,
            record_type: 3000,
        },
    );
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(1.0);
    let pinged = rig.sonar.pings[0].1.time.since(Timestamp::ZERO);
    let record = frame(&rig.records[&A][0]);
    assert_eq!(
        record.header().time,
        Time7k::from_utc(START + pinged + Duration::from_secs(10))
    );
    let Ok(Record::SideScan(imagery)) = Record::read(&record) else {
        panic!()
    };
    assert_eq!(u128::from(imagery.header.time_ms), pinged.as_millis());
}

#[test]
fn a_sensor_that_does_not_set_its_time_keeps_its_own() {
    let table = "[[fault]]\nat_s = 0\nfor_s = 100\nkind = \"time_refused\"\nsensor = \"sidescan_low\"\n";
    let mut rig = Rig::ready(table);
    let noon: Utc = START + Duration::from_secs(3600);
    rig.tell(
        A,
        Command::TimeSync {
            time: CalendarTime::from_utc(noon),
        },
    );
    assert_eq!(rig.alarms(A).len(), 1);
    for sensor in [SUB_BOTTOM, LOW] {
        rig.tell(
            A,
            Command::Subscribe {
                sensor,
                record_type: 3000,
            },
        );
        rig.tell(
            A,
            Command::Subscribe {
                sensor,
                record_type: 3001,
            },
        );
        rig.generic(A, sensor, &Generic::Ping { on: true });
    }
    rig.run(0.9);
    let mut hours = Vec::new();
    for bytes in &rig.records[&A] {
        match Record::read(&frame(bytes)) {
            Ok(Record::SideScan(imagery)) => {
                let header = imagery.side_scan_headers().next().expect("a header");
                hours.push((3000, header.hour, header.day_ms / 3_600_000));
            }
            Ok(Record::SubBottom(imagery)) => {
                let header = imagery.segy_headers().next().expect("a header");
                hours.push((3001, header.hour.cast_unsigned(), header.day_ms / 3_600_000));
            }
            other => panic!("{other:?}"),
        }
    }
    hours.sort_unstable();
    hours.dedup();
    assert_eq!(hours, [(3000, 14, 14), (3001, 15, 15)]);
}

#[test]
fn what_a_driver_slept_through_is_not_made_up_for() {
    let mut rig = Rig::ready("time_messages = true\nhealth_period_s = 1.0");
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(0.5);
    let before = rig.sonar.pings.len();
    rig.take(A);
    rig.sleep(600.0);
    let got = rig.take(A);
    let times = got.iter().filter(|got| matches!(got, Got::Time(_))).count();
    assert_eq!(times, 1, "{got:?}");
    rig.run(1.0);
    // 150 ms a ping: those of the ten minutes are dropped, with alarm 3.
    assert!(rig.sonar.pings.len() < before + 10);
    assert!(rig.sonar.pings.last().expect("a ping").1.number > 3990);
    let alarms = rig.alarms(A);
    assert!(format!("{alarms:?}").contains("PingDropped"), "{alarms:?}");
}
