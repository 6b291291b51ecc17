//! Each client gets what it subscribed to, and nothing else.

use backseat_plc::ClientId;
use backseat_s7k::plc::{Command, Generic};
use backseat_s7k::{DeviceId, SensorIndex};

use crate::rig::{A, B, BLUEFIN, Got, HIGH, LOW, Rig, SUB_BOTTOM, enclosed, navigation_record};

fn pinging() -> Rig {
    let mut rig = Rig::ready("");
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        rig.generic(A, sensor, &Generic::Ping { on: true });
    }
    rig.take(A);
    rig
}

fn subscribe(rig: &mut Rig, client: ClientId, sensor: SensorIndex, record_type: u32) {
    rig.tell(client, Command::Subscribe { sensor, record_type });
    rig.take(client);
}

/// Type and device of the records that a client got.
fn kinds(rig: &mut Rig, client: ClientId) -> Vec<(u32, u32)> {
    let mut kinds: Vec<(u32, u32)> = rig
        .take(client)
        .into_iter()
        .map(|got| {
            let Got::Data(record_type, DeviceId(device), _) = got else {
                panic!("{got:?}")
            };
            (record_type, device)
        })
        .collect();
    kinds.dedup();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

#[test]
fn a_client_without_subscriptions_gets_no_data() {
    let mut rig = pinging();
    rig.run(3.0);
    assert!(rig.sonar.pings.len() > 30);
    assert_eq!(rig.take(A), []);
}

#[test]
fn subscriptions_are_each_clients_own() {
    let mut rig = pinging();
    rig.connect(B);
    subscribe(&mut rig, A, LOW, 3000);
    subscribe(&mut rig, B, SUB_BOTTOM, 3001);
    subscribe(&mut rig, B, HIGH, 3000);
    subscribe(&mut rig, B, HIGH, 3000);
    // A record that the sensor never sends.
    subscribe(&mut rig, A, HIGH, 3001);
    rig.run(2.0);
    assert_eq!(kinds(&mut rig, A), [(3000, 11_001)]);
    assert_eq!(kinds(&mut rig, B), [(3000, 11_002), (3001, 11_000)]);
    rig.tell(
        B,
        Command::Unsubscribe {
            sensor: HIGH,
            record_type: 3000,
        },
    );
    rig.run(2.0);
    assert_eq!(kinds(&mut rig, A), [(3000, 11_001)]);
    assert_eq!(kinds(&mut rig, B), [(3001, 11_000)]);
}

#[test]
fn a_client_that_comes_back_has_no_subscriptions() {
    let mut rig = pinging();
    subscribe(&mut rig, A, LOW, 3000);
    rig.run(1.0);
    assert_eq!(kinds(&mut rig, A), [(3000, 11_001)]);
    rig.disconnect(A);
    rig.connect(A);
    rig.run(1.0);
    assert_eq!(rig.take(A), []);
}

#[test]
fn the_same_record_has_the_same_count_for_every_client() {
    let mut rig = pinging();
    rig.connect(B);
    subscribe(&mut rig, A, LOW, 3000);
    rig.run(1.0);
    subscribe(&mut rig, B, LOW, 3000);
    rig.take(A);
    rig.run(1.0);
    let (a, b) = (rig.take(A), rig.take(B));
    assert_eq!(a, b);
    // The low frequency pings every 150 ms; the first second was for A alone.
    assert!(
        matches!(a[0], Got::Data(3000, DeviceId::SIDESCAN_LOW, count) if count > 4),
        "{a:?}"
    );
}

#[test]
fn what_a_client_says_of_the_vehicle_goes_to_those_who_subscribed() {
    let mut rig = Rig::ready("");
    rig.connect(B);
    subscribe(&mut rig, B, BLUEFIN, 3100);
    rig.push(A, &enclosed(&navigation_record()));
    assert_eq!((rig.take(A), kinds(&mut rig, B)), (vec![], vec![(3100, 11_100)]));
    // Frames as they were sent, in a record of the controller's.
    let sent = navigation_record();
    assert_eq!(rig.records[&B][0][64..sent.len() - 4], sent[64..sent.len() - 4]);
}

#[test]
fn a_sensor_that_leaves_takes_its_subscriptions_along() {
    let mut rig = pinging();
    subscribe(&mut rig, A, LOW, 3000);
    rig.tell(A, Command::Remove { sensor: LOW });
    rig.take(A);
    rig.run(5.0);
    assert_eq!(rig.take(A), []);
    rig.tell(
        A,
        Command::Unsubscribe {
            sensor: LOW,
            record_type: 3000,
        },
    );
    assert_eq!(rig.alarms(A).len(), 1);
}

#[test]
fn a_client_has_256_subscriptions_at_most() {
    let mut rig = Rig::ready("");
    for record_type in 0..300 {
        rig.tell(
            A,
            Command::Subscribe {
                sensor: LOW,
                record_type,
            },
        );
    }
    assert_eq!(rig.alarms(A).len(), 44);
}
