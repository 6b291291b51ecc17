//! A client that does not read loses records. It costs no more memory than its buffer, and nobody else anything.

use backseat_plc::PlcEventKind;
use backseat_s7k::plc::{Command, Generic};

use crate::rig::{A, B, Got, HIGH, LOW, Rig};

const BUFFER: usize = 65_536;

fn two_clients() -> Rig {
    let mut rig = Rig::ready("send_buffer_bytes = 65536");
    rig.connect(B);
    for client in [A, B] {
        for sensor in [LOW, HIGH] {
            rig.tell(
                client,
                Command::Subscribe {
                    sensor,
                    record_type: 3000,
                },
            );
        }
    }
    for sensor in [LOW, HIGH] {
        rig.generic(A, sensor, &Generic::Ping { on: true });
    }
    rig.take(A);
    rig
}

#[test]
fn records_beyond_the_buffer_are_lost_and_counted() {
    let mut rig = two_clients();
    rig.run(1.0);
    rig.plc.set_blocked(rig.now, B, true);
    rig.take(B);
    let before = rig.take(A).len();
    rig.run(30.0);
    assert!(before > 10 && rig.take(A).len() > 20 * before);
    assert_eq!(rig.take(B), []);
    let waiting = rig.plc.waiting(B);
    assert!((BUFFER / 2..=BUFFER).contains(&waiting), "{waiting}");
    let lost = |rig: &Rig| -> u64 {
        let lost = |kind: &PlcEventKind| {
            let PlcEventKind::Lost { client, records } = kind else {
                return 0;
            };
            assert_eq!(*client, B);
            *records
        };
        rig.events.iter().map(|event| lost(&event.kind)).sum()
    };
    assert!(lost(&rig) > 400, "{}", lost(&rig));
    // At most one event a second says so.
    let events = rig
        .events
        .iter()
        .filter(|event| matches!(event.kind, PlcEventKind::Lost { .. }))
        .count();
    assert!((20..=31).contains(&events), "{events}");
    // Then it reads again: what waited comes first, whole, and then what is new.
    rig.plc.set_blocked(rig.now, B, false);
    rig.run(1.0);
    let counts: Vec<u32> = rig
        .take(B)
        .iter()
        .filter_map(|got| {
            if let Got::Data(3000, device, count) = got {
                (device.0 == 11_001).then_some(*count)
            } else {
                None
            }
        })
        .collect();
    assert!(counts.windows(2).any(|pair| pair[1] - pair[0] > 100), "{counts:?}");
    assert_eq!(rig.skipped_bytes, 0);
}

#[test]
fn messages_have_room_beyond_the_data() {
    let mut rig = two_clients();
    rig.plc.set_blocked(rig.now, B, true);
    rig.run(30.0);
    rig.tell(B, Command::Version {});
    rig.plc.set_blocked(rig.now, B, false);
    rig.run(0.1);
    assert!(rig.take(B).iter().any(|got| matches!(got, Got::Status(_))));
}

#[test]
fn a_client_that_asks_and_never_reads_is_bounded_too() {
    let mut rig = two_clients();
    rig.plc.set_blocked(rig.now, B, true);
    for _ in 0..5000 {
        rig.tell(B, Command::RunList {});
    }
    let waiting = rig.plc.waiting(B);
    assert!((2 * BUFFER - 1000..=2 * BUFFER).contains(&waiting), "{waiting}");
}

#[test]
fn one_client_more_than_the_limit_is_turned_away() {
    let mut rig = Rig::new("clients_max = 2");
    for client in 0..4 {
        rig.connect(backseat_plc::ClientId(client));
    }
    assert_eq!(rig.closed, [backseat_plc::ClientId(2), backseat_plc::ClientId(3)]);
    rig.disconnect(backseat_plc::ClientId(0));
    rig.connect(B);
    assert_eq!(rig.closed.len(), 2);
}
