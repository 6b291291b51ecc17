use std::time::Duration;

use backseat_mvc::{Activity, ClientId, Mvc, WorldFile};
use backseat_units::Timestamp;

use crate::files::LIVELY;

const ALL: &[u8] = b"$BPLOG,ALL,ON\r\n$BPLOG,ACK,ON\r\n";

/// Every write of a run with some conversation, each with its time, and the mock at the end of the run.
fn run(seed: u64, seconds: u64, messages: &[u8]) -> (Vec<u8>, Mvc) {
    let file = WorldFile::from_toml(LIVELY).expect("the test's file is right");
    let mut mvc = Mvc::new(&file, seed).expect("the test's world is possible");
    let (mut record, mut out) = (Vec::new(), Vec::new());
    let client = ClientId(1);
    mvc.connect(Timestamp::ZERO, client);
    mvc.receive(Timestamp::ZERO, client, messages);
    let mut now = Timestamp::ZERO;
    while now < Timestamp::from_secs(seconds) && !mvc.mission_over() {
        now = mvc.poll_timeout().expect("a vehicle always has a next step");
        mvc.handle_timeout(now);
        let second = now.as_nanos() / 1_000_000_000;
        let talks = second < 300;
        if talks && now.as_nanos().is_multiple_of(3_000_000_000) && second % 40 < 20 {
            mvc.receive(
                now + Duration::from_millis(1),
                client,
                b"$BPRMB,070000.000,45,8,0,1.5,1,0\r\n",
            );
        }
        if talks && now.as_nanos().is_multiple_of(25_000_000_000) {
            let interrupt = if second.is_multiple_of(50) { 4 } else { 0 };
            let line = format!(
                "$BPRTK,070000.000,{second},4218.01,N,06606.00,W,4218.03,N,06606.00,W,1,10,1.8,0,{interrupt}\n$BPRMP,070000.000\n"
            );
            mvc.receive(now + Duration::from_millis(2), client, line.as_bytes());
        }
        while mvc.poll_transmit(&mut out).is_some() {
            record.extend_from_slice(&now.as_nanos().to_le_bytes());
            record.extend_from_slice(&out);
        }
        while mvc.poll_event().is_some() {}
    }
    (record, mvc)
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let (one, _) = run(11, 400, ALL);
    assert!(one.len() > 500_000);
    assert!(one == run(11, 400, ALL).0);
    assert!(one != run(12, 400, ALL).0);
}

#[test]
fn many_seeds_fly_their_mission_to_its_end() {
    for seed in 0..40 {
        let (_, mvc) = run(seed, 6000, b"$BPLOG,NVG,ON\r\n$BPLOG,ACK,ON\r\n");
        let truth = mvc.truth();
        assert!(mvc.mission_over(), "seed {seed}: {truth:?}");
        assert!(matches!(truth.activity, Activity::Stopped), "seed {seed}");
        assert!(truth.altitude_m > 0.0 && truth.depth_m < 1.0, "seed {seed}: {truth:?}");
    }
}
