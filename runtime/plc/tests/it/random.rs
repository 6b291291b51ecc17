//! Random bytes and random commands: no panic, bounded memory, and a controller that still answers.

use backseat_plc::{ClientId, FaultEntry, FaultPlan, Stored};
use backseat_s7k::SensorIndex;
use backseat_s7k::record::Action;
use core::time::Duration;
use proptest::prelude::*;

use crate::rig::{A, B, Rig, command_record, enclosed, navigation_record};

#[derive(Clone, Debug)]
enum Input {
    Bytes(Vec<u8>),
    /// A command with a text that may be right.
    Command(i32, u32, u32, String),
    Navigation,
    Time(u32),
    Sleep(u32),
    Blocked(bool),
    Reconnect,
}

/// Texts of which some fit the command, and some do not.
fn text() -> impl Strategy<Value = String> {
    let number = prop_oneof![-2..6_i32, Just(3000), Just(3001), Just(5000), any::<i32>()];
    let fixed = [
        "",
        "Auto",
        "line",
        "Range = 50.00",
        "Ping = 1",
        "Ping = 0",
        "PulseFiles",
        "DefaultState",
        "Duration = 20.00",
        "2026/11/23,15:00:00.00000",
        "2, 20, 5, LF",
        "2, 21, 5, HF",
        "1, 0, 5, SBP",
        "3, 0, 0, Bluefin",
        "D:\\x",
        "1, 100",
    ];
    prop_oneof![
        3 => proptest::collection::vec(number, 1..4).prop_map(|numbers| {
            numbers.iter().map(i32::to_string).collect::<Vec<_>>().join(", ")
        }),
        4 => proptest::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        1 => "\\PC{0,40}",
    ]
}

fn input() -> impl Strategy<Value = Input> {
    prop_oneof![
        2 => proptest::collection::vec(any::<u8>(), 0..300).prop_map(Input::Bytes),
        20 => (-1..5_i32, prop_oneof![20 => 0..30_u32, 1 => any::<u32>()], 0..4_u32, text())
            // Shutdown ends the run: it is a rare command here.
            .prop_filter("shutdown", |(_, id, ..)| *id != 13)
            .prop_map(|(sensor, id, action, text)| Input::Command(sensor, id, action, text)),
        2 => Just(Input::Navigation),
        6 => (0..3000_u32).prop_map(Input::Time),
        1 => (0..20_000_u32).prop_map(Input::Sleep),
        1 => any::<bool>().prop_map(Input::Blocked),
        1 => Just(Input::Reconnect),
    ]
}

fn play(seed: u64, intensity: f64, inputs: &[(bool, Input)]) {
    let plan = FaultPlan::draw(seed, Duration::from_secs(60), intensity);
    let faults: String = plan
        .faults
        .iter()
        .filter(|fault| fault.kind != backseat_plc::FaultKind::KeyMissing)
        .map(|fault| {
            format!(
                "[[fault]]\n{}\n",
                toml::to_string(&FaultEntry::of(fault)).expect("a fault")
            )
        })
        .collect();
    let table = format!(
        "send_buffer_bytes = 65536\nrecord_max_bytes = 8192\ndisk = {{ capacity_mb = 20, used_mb = 15 }}\n{faults}"
    );
    let mut rig = Rig::with(&table, seed, &Stored::default());
    rig.pose();
    for client in [A, B] {
        rig.connect(client);
    }
    for (second, input) in inputs {
        let client = if *second { B } else { A };
        match input {
            Input::Bytes(bytes) => rig.push(client, bytes),
            Input::Command(sensor, id, action, text) => {
                let record = command_record(SensorIndex(*sensor), *id, Action::from(*action), text);
                rig.push(client, &enclosed(&record));
            }
            Input::Navigation => rig.push(client, &enclosed(&navigation_record())),
            Input::Time(ms) => {
                rig.pose();
                rig.run(f64::from(*ms) / 1000.0);
            }
            Input::Sleep(ms) => rig.sleep(f64::from(*ms) / 1000.0),
            Input::Blocked(blocked) => rig.plc.set_blocked(rig.now, client, *blocked),
            Input::Reconnect => {
                rig.disconnect(client);
                rig.connect(client);
            }
        }
        rig.drain();
        for client in [A, B] {
            assert!(rig.plc.waiting(client) <= 2 * 65_536);
        }
        let next = rig.plc.poll_timeout();
        assert!(
            next.is_none_or(|at| at > rig.now) || next.is_some_and(|at| at == rig.now),
            "{next:?} {}",
            rig.now
        );
        assert!(rig.plc.sensors().len() <= 4);
    }
    // When the faults are over, a new client is served as always.
    rig.run(120.0);
    let fresh = ClientId(77);
    rig.disconnect(A);
    rig.connect(fresh);
    rig.text(fresh, SensorIndex::PLC, 4, Action::Get, "");
    assert_eq!(rig.take(fresh).len(), 1);
    // Every file that was closed is whole.
    for (name, bytes) in rig.files.iter().filter(|(name, _)| name.ends_with(".s7k")) {
        let mut reader = backseat_s7k::file::FileReader::new(&bytes[..]);
        while let Some(item) = reader.next().expect("memory") {
            assert!(matches!(item, backseat_s7k::file::FileItem::Record { .. }), "{name}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_that_a_client_sends_ends_the_controller(
        seed in 0..1000_u64,
        inputs in proptest::collection::vec((any::<bool>(), input()), 1..120),
    ) {
        play(seed, 0.0, &inputs);
    }

    #[test]
    fn nothing_that_a_client_sends_ends_it_while_faults_act(
        seed in 0..1000_u64,
        inputs in proptest::collection::vec((any::<bool>(), input()), 1..120),
    ) {
        play(seed, 1.0, &inputs);
    }
}
