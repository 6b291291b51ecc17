use std::time::Duration;

use proptest::prelude::*;

use backseat_mvc::{ClientId, Direction, Fault, FaultPlan, FaultyLink, LinkFaults};
use backseat_units::Timestamp;

const ME: ClientId = ClientId(1);

fn at(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Duration::from_secs_f64(seconds)
}

fn plan(text: &str) -> FaultPlan {
    let plan = text.replace("fault ", "[[fault]]\nkind = ").replace("; ", "\n");
    FaultPlan::from_toml(&plan).expect("the test's plan is right")
}

fn faults(text: &str) -> LinkFaults {
    LinkFaults::new(&plan(text), 3)
}

fn from_vehicle(text: &str) -> FaultyLink {
    faults(text).link(Timestamp::ZERO, ME, None, Direction::FromVehicle)
}

/// Writes a numbered line each 0.1 s, from 0.1 s on. Returns what arrives, and when.
fn lines(link: &mut FaultyLink, seconds: u32) -> Vec<(Timestamp, String)> {
    lines_and(link, seconds, &[])
}

/// Like [`lines`], with these faults injected at their times.
fn lines_and(link: &mut FaultyLink, seconds: u32, faults: &[Fault]) -> Vec<(Timestamp, String)> {
    let mut faults: Vec<&Fault> = faults.iter().rev().collect();
    let mut writes: Vec<(Timestamp, String)> = (1..=10 * seconds)
        .map(|n| (Timestamp::from_millis(100 * u64::from(n)), format!("$LINE,{n}\r\n")))
        .collect();
    writes.reverse();
    let mut arrived = Vec::new();
    loop {
        let write = writes.last().map(|(at, _)| *at);
        let fault = faults.last().map(|fault| fault.at);
        let Some(now) = link.poll_timeout().into_iter().chain(write).chain(fault).min() else {
            break;
        };
        if fault == Some(now)
            && let Some(fault) = faults.pop()
        {
            link.inject(fault);
        }
        if write == Some(now)
            && let Some((_, line)) = writes.pop()
            && let Some(bytes) = link.pass(now, line.as_bytes())
        {
            arrived.push((now, String::from_utf8_lossy(bytes).into_owned()));
        }
        if link.is_cut(now) {
            break;
        }
        while let Some(chunk) = link.poll(now) {
            arrived.push((now, String::from_utf8_lossy(&chunk).into_owned()));
            link.recycle(chunk);
        }
    }
    arrived
}

fn texts(arrived: &[(Timestamp, String)]) -> String {
    arrived.iter().map(|(_, text)| text.as_str()).collect()
}

fn written(numbers: impl Iterator<Item = u32>) -> String {
    numbers.map(|n| format!("$LINE,{n}\r\n")).collect()
}

#[test]
fn without_a_fault_bytes_pass_at_once() {
    let bytes = b"$BFNVG\r\n";
    let mut link = from_vehicle("");
    assert_eq!(link.pass(at(1.0), bytes), Some(bytes.as_slice()));
    assert_eq!(link.poll_timeout(), None);
    // Also before and after a fault.
    let mut link = from_vehicle("fault \"stall\"; at_s = 5; for_s = 1");
    assert!(link.pass(at(4.999), bytes).is_some());
    assert!(link.pass(at(5.0), bytes).is_none());
    assert_eq!(link.poll(at(5.999)), None);
    assert_eq!(link.poll_timeout(), Some(at(6.0)));
    assert_eq!(link.poll(at(6.0)).unwrap().bytes, bytes);
    // A write that the link takes in when the fault is over still comes through, and the link takes in no later one.
    let _ = link.pass(at(6.0), bytes);
    while link.poll(at(6.0)).is_some() {}
    assert!(link.pass(at(6.1), bytes).is_some());
}

#[test]
fn a_cut_happens_at_its_instant_and_in_both_directions() {
    let faults = faults("fault \"link_cut\"; at_s = 5; for_s = 2");
    for direction in [Direction::ToVehicle, Direction::FromVehicle] {
        let mut link = faults.link(Timestamp::ZERO, ME, None, direction);
        assert_eq!(link.poll_timeout(), Some(at(5.0)));
        link.push(at(4.999), b"under way");
        assert!(!link.is_cut(at(4.999)) && link.is_cut(at(5.0)));
        assert_eq!(link.poll(at(5.0)), None);
        // A connection that is made afterwards is not cut.
        let mut link = faults.link(at(7.0), ME, None, direction);
        assert!(!link.is_cut(at(100.0)) && link.pass(at(8.0), b"x").is_some());
    }
    let refuses: Vec<bool> = [4.999, 5.0, 6.999, 7.0]
        .map(|seconds| faults.refuses(at(seconds), ME, None))
        .to_vec();
    assert_eq!(refuses, [false, true, true, false]);
}

#[test]
fn a_refusal_affects_only_new_connections() {
    let faults = faults("fault \"refuse\"; at_s = 5; for_s = 2; role = \"sonar\"");
    assert!(faults.refuses(at(6.0), ME, Some("sonar")));
    assert!(!faults.refuses(at(6.0), ME, Some("camera")) && !faults.refuses(at(6.0), ME, None));
    let link = faults.link(Timestamp::ZERO, ME, Some("sonar"), Direction::ToVehicle);
    assert!(!link.is_cut(at(6.0)));
}

#[test]
fn a_fault_affects_only_the_connections_that_it_names() {
    let faults = faults("fault \"half_open\"; at_s = 1; for_s = 9; client = 2; direction = \"to_vehicle\"");
    let lost = |client, direction| {
        let mut link = faults.link(Timestamp::ZERO, ClientId(client), None, direction);
        link.pass(at(5.0), b"x").is_none() && link.poll(at(20.0)).is_none()
    };
    assert!(lost(2, Direction::ToVehicle));
    assert!(!lost(2, Direction::FromVehicle) && !lost(1, Direction::ToVehicle));
}

#[test]
fn a_stall_holds_everything_back_and_then_releases_it_at_once() {
    let mut link = from_vehicle("fault \"stall\"; at_s = 2; for_s = 1.55");
    let arrived = lines(&mut link, 5);
    assert_eq!(texts(&arrived), written(1..=50));
    let held: Vec<_> = arrived.iter().filter(|(_, text)| text.contains("$LINE,2")).collect();
    let burst = arrived.iter().find(|(when, _)| *when == at(3.55)).unwrap();
    assert_eq!(burst.1, written(20..=35));
    assert!(
        held.iter().all(|(when, _)| *when == at(0.2) || *when == at(3.55)),
        "{held:?}"
    );
}

#[test]
fn a_half_open_link_loses_only_what_is_written_during_the_fault() {
    let mut link = from_vehicle("fault \"half_open\"; at_s = 2; for_s = 1");
    let arrived = lines(&mut link, 5);
    assert_eq!(texts(&arrived), written((1..=19).chain(30..=50)));
}

#[test]
fn a_delay_keeps_order_and_stays_within_its_jitter() {
    let mut link = from_vehicle("fault \"delay\"; at_s = 2; for_s = 2; delay_s = 0.5; jitter_s = 0.7");
    let arrived = lines(&mut link, 6);
    assert_eq!(texts(&arrived), written(1..=60));
    let mut jitters = Vec::new();
    for (when, text) in &arrived {
        let number: f64 = text["$LINE,".len()..].lines().next().unwrap().parse().unwrap();
        let late = when.as_secs_f64() - number / 10.0;
        if (20.0..40.0).contains(&number) {
            assert!((0.5..1.2).contains(&late), "{number} {late}");
            jitters.push(late);
        } else {
            // After the fault only those lines are late that must not overtake an earlier one.
            assert!(late < 1.2, "{number} {late}");
        }
    }
    let spread = jitters.iter().copied().fold(0.0, f64::max) - jitters.iter().copied().fold(9.0, f64::min);
    assert!(spread > 0.2, "{jitters:?}");
    assert_eq!(arrived.last().unwrap().0, at(6.0));
}

#[test]
fn split_bytes_come_in_pieces_with_a_gap() {
    let mut link = from_vehicle("fault \"split\"; at_s = 2; for_s = 1; bytes = 4; gap_s = 0.01");
    let arrived = lines(&mut link, 5);
    assert_eq!(texts(&arrived), written(1..=50));
    let pieces: Vec<_> = arrived
        .iter()
        .filter(|(when, _)| *when >= at(2.0) && *when < at(3.0))
        .collect();
    assert!(pieces.len() >= 10 * 3 && pieces.iter().all(|(_, text)| text.len() <= 4));
    let ones = pieces
        .windows(2)
        .filter(|two| two[1].0.since(two[0].0) == Duration::from_millis(10));
    assert!(ones.count() > 15);
}

#[test]
fn joined_writes_come_as_one() {
    let mut link = from_vehicle("fault \"join\"; at_s = 2; for_s = 1; hold_s = 0.25");
    let arrived = lines(&mut link, 5);
    assert_eq!(texts(&arrived), written(1..=50));
    let first = arrived.iter().find(|(when, _)| *when >= at(2.0)).unwrap();
    assert_eq!(*first, (at(2.25), written(20..=22)));
}

#[test]
fn duplicate_and_drop_affect_only_whole_sentences() {
    let mut link = from_vehicle("fault \"duplicate\"; at_s = 2; for_s = 1; chance = 1");
    let twice = (20..30).flat_map(|n| [n, n]);
    assert_eq!(
        texts(&lines(&mut link, 5)),
        written((1..20).chain(twice).chain(30..=50))
    );
    let mut link = from_vehicle("fault \"drop\"; at_s = 2; for_s = 1; chance = 1");
    assert_eq!(texts(&lines(&mut link, 5)), written((1..20).chain(30..=50)));
    let mut link = from_vehicle("fault \"drop\"; at_s = 0; for_s = 100; chance = 0.3");
    let arrived = lines(&mut link, 100);
    let lost = 1000 - arrived.len();
    assert!((240..360).contains(&lost), "{lost}");
    assert!(
        arrived
            .iter()
            .all(|(_, line)| line.starts_with('$') && line.ends_with("\r\n"))
    );
}

#[test]
fn half_a_sentence_is_kept_no_longer_than_its_fault_lasts() {
    let mut link = from_vehicle("fault \"drop\"; at_s = 1; for_s = 1; chance = 1");
    link.push(at(1.5), b"$ONE\r\n$TW");
    assert_eq!(link.poll(at(1.5)), None);
    assert_eq!(link.poll_timeout(), Some(at(2.0)));
    assert_eq!(link.poll(at(1.999)), None);
    assert_eq!(link.poll(at(2.0)).unwrap().bytes, b"$TW");
    // The rest of the sentence follows, even if nobody has polled in between.
    link = from_vehicle("fault \"drop\"; at_s = 1; for_s = 1; chance = 1");
    link.push(at(1.5), b"$TW");
    link.push(at(2.5), b"O\r\n");
    assert_eq!(link.poll(at(2.5)).unwrap().bytes, b"$TW");
    assert_eq!(link.poll(at(2.5)).unwrap().bytes, b"O\r\n");
}

#[test]
fn corruption_flips_single_bits_at_its_rate() {
    let mut link = from_vehicle("fault \"corrupt\"; at_s = 0; for_s = 10; chance = 0.02");
    let clean = vec![0_u8; 50_000];
    link.push(at(1.0), &clean);
    let dirty = link.poll(at(1.0)).unwrap();
    assert_eq!(dirty.len(), clean.len());
    let flipped: Vec<u8> = dirty.iter().copied().filter(|byte| *byte != 0).collect();
    assert!((850..1150).contains(&flipped.len()), "{}", flipped.len());
    assert!(flipped.iter().all(|byte| byte.count_ones() == 1));
    assert!((0..8).all(|bit| flipped.contains(&(1 << bit))));
}

#[test]
fn a_link_that_holds_too_much_is_cut() {
    let mut link = from_vehicle("fault \"stall\"; at_s = 0; for_s = 1000");
    let write = vec![b'x'; 4096];
    for _ in 0..256 {
        link.push(at(1.0), &write);
        assert!(!link.is_cut(at(1.0)));
    }
    link.push(at(1.0), b"x");
    assert!(link.is_cut(at(1.0)));
    let mut link = from_vehicle("fault \"split\"; at_s = 0; for_s = 1000; bytes = 1; gap_s = 1");
    for _ in 0..17 {
        link.push(at(1.0), &write);
    }
    assert!(link.is_cut(at(1.0)));
}

#[test]
fn an_injected_fault_acts_like_a_planned_one() {
    // The delay keeps some bytes under way, so that a stall finds some.
    let before = "fault \"delay\"; at_s = 0; for_s = 9; delay_s = 0.7; jitter_s = 0.4\n";
    for later in [
        "fault \"link_cut\"; at_s = 5.05; for_s = 2",
        "fault \"stall\"; at_s = 5.05; for_s = 2",
        "fault \"half_open\"; at_s = 5.05; for_s = 2",
        "fault \"delay\"; at_s = 5.05; for_s = 2; delay_s = 1",
        "fault \"split\"; at_s = 5.05; for_s = 2; bytes = 3; gap_s = 0.001",
        "fault \"join\"; at_s = 5.05; for_s = 2; hold_s = 0.5",
        "fault \"duplicate\"; at_s = 5.05; for_s = 2; chance = 0.5",
        "fault \"corrupt\"; at_s = 5.05; for_s = 2; chance = 0.05",
        "fault \"drop\"; at_s = 5.05; for_s = 2; chance = 0.5",
        "fault \"stall\"; at_s = 5.05; for_s = 1\nfault \"stall\"; at_s = 5.55; for_s = 1",
    ] {
        let mut planned = from_vehicle(&format!("{before}{later}"));
        let mut injected = from_vehicle(before);
        let with = lines(&mut planned, 12);
        assert_eq!(with, lines_and(&mut injected, 12, &plan(later).faults), "{later}");
        assert_ne!(with, lines(&mut from_vehicle(before), 12), "{later}");
    }
}

#[test]
fn an_injected_fault_affects_only_the_connections_that_it_names() {
    let mut faults = faults("");
    let live = |faults: &LinkFaults, client, role, direction| faults.link(at(1.0), ClientId(client), role, direction);
    let to = Direction::ToVehicle;
    let mut links = [
        live(&faults, 1, Some("sonar"), to),
        live(&faults, 1, Some("sonar"), Direction::FromVehicle),
        live(&faults, 1, Some("camera"), to),
        live(&faults, 1, None, to),
    ];
    let named = plan("fault \"stall\"; at_s = 5; for_s = 2; role = \"sonar\"; direction = \"to_vehicle\"");
    let of_client = plan("fault \"link_cut\"; at_s = 8; client = 2");
    for link in &mut links {
        link.inject(&named.faults[0]);
        link.inject(&of_client.faults[0]);
    }
    let held = links.each_mut().map(|link| link.pass(at(6.0), b"x").is_none());
    assert_eq!(held, [true, false, false, false]);
    assert!(!links[3].is_cut(at(9.0)));
    // Later connections have the faults that still last, and a cut that still lasts refuses them.
    faults.inject(&named.faults[0]);
    faults.inject(&plan("fault \"link_cut\"; at_s = 8; for_s = 3").faults[0]);
    assert!(
        faults
            .link(at(6.0), ME, Some("sonar"), to)
            .pass(at(6.5), b"x")
            .is_none()
    );
    assert!(faults.refuses(at(9.0), ME, None) && !faults.refuses(at(11.0), ME, None));
    assert!(!faults.link(at(11.0), ME, None, to).is_cut(at(20.0)));
}

/// TCP's user time-out (RFC 5482) counts data that is not acknowledged, and lost data never is.
#[test]
fn the_sender_gives_up_the_link_in_time_if_a_write_waits_or_is_lost() {
    let within = Duration::from_secs(2);
    let mut stalled = from_vehicle("fault \"stall\"; at_s = 1; for_s = 60");
    assert_eq!(stalled.gives_up(within), None);
    stalled.push(at(3.0), b"x");
    stalled.push(at(4.0), b"x");
    assert_eq!(stalled.gives_up(within), Some(at(5.0)));

    let mut lost = from_vehicle("fault \"half_open\"; at_s = 1; for_s = 60");
    lost.push(at(0.5), b"x");
    assert!(lost.poll(at(0.5)).is_some());
    assert_eq!(lost.gives_up(within), None);
    lost.push(at(3.0), b"x");
    lost.push(at(4.0), b"x");
    assert_eq!(lost.gives_up(within), Some(at(5.0)));

    // TCP sends lost data again, and it arrives when the loss is over: only a long loss is noticed.
    let mut short = from_vehicle(
        "fault \"half_open\"; at_s = 1; for_s = 1.5\nfault \"half_open\"; at_s = 6; for_s = 1\nfault \"half_open\"; at_s = 7; for_s = 3",
    );
    short.push(at(1.0), b"x");
    assert_eq!(short.gives_up(within), None);
    short.push(at(6.5), b"x");
    assert_eq!(short.gives_up(within), Some(at(8.5)));
}

/// The computer of a deaf vehicle receives what the vehicle does not read, so TCP acknowledges it.
#[test]
fn a_deaf_vehicle_later_reads_everything_in_order_and_nobody_gives_up_the_link() {
    let text = "fault \"deaf\"; at_s = 2; for_s = 4";
    let mut link = faults(text).link(Timestamp::ZERO, ME, None, Direction::ToVehicle);
    let arrived = lines(&mut link, 8);
    assert_eq!(texts(&arrived), written(1..=80));
    let reads = |tenths: u64| {
        arrived
            .iter()
            .filter(|(when, _)| *when == Timestamp::from_millis(100 * tenths))
            .count()
    };
    assert!((20..60).all(|tenths| reads(tenths) == 0));
    assert_eq!((reads(19), reads(60), reads(61)), (1, 41, 1));

    let within = Duration::from_secs(2);
    let mut deaf = faults(text).link(Timestamp::ZERO, ME, None, Direction::ToVehicle);
    deaf.push(at(3.0), b"x");
    assert_eq!((deaf.gives_up(within), deaf.poll_timeout()), (None, Some(at(6.0))));
    // Data that does not even arrive counts for the time-out as always, and holds back what comes after it.
    let text = "fault \"deaf\"; at_s = 2; for_s = 4\nfault \"stall\"; at_s = 4; for_s = 9";
    let mut both = faults(text).link(Timestamp::ZERO, ME, None, Direction::ToVehicle);
    both.push(at(3.0), b"a");
    both.push(at(5.0), b"b");
    assert_eq!(both.gives_up(within), Some(at(7.0)));
    assert_eq!(both.poll(at(5.9)), None);
    assert_eq!(both.poll(at(6.0)).unwrap().bytes, b"a");
    assert_eq!((both.poll(at(6.0)), both.poll_timeout()), (None, Some(at(13.0))));
    // The vehicle's own messages go on.
    let mut from = from_vehicle(text.lines().next().unwrap());
    assert!(from.pass(at(3.0), b"x").is_some());
}

#[test]
fn an_injected_deafness_keeps_what_was_under_way() {
    let mut link = faults("fault \"delay\"; at_s = 0; for_s = 100; delay_s = 1").link(
        Timestamp::ZERO,
        ME,
        None,
        Direction::ToVehicle,
    );
    link.push(at(1.5), b"a");
    for fault in plan("fault \"deaf\"; at_s = 2; for_s = 3").faults {
        link.inject(&fault);
    }
    link.push(at(2.5), b"b");
    assert_eq!((link.poll(at(4.9)), link.poll_timeout()), (None, Some(at(5.0))));
    assert_eq!(link.poll(at(5.0)).unwrap().bytes, b"a");
    assert_eq!(link.poll(at(5.0)).unwrap().bytes, b"b");
}

#[test]
fn a_delay_acts_from_the_first_byte_and_on_new_connections_only_in_its_direction() {
    let faults = faults("fault \"delay\"; at_s = 0; for_s = 100; delay_s = 0.7; direction = \"to_vehicle\"");
    for since in [0.0, 30.0] {
        let mut to = faults.link(at(since), ME, None, Direction::ToVehicle);
        let mut from = faults.link(at(since), ME, None, Direction::FromVehicle);
        assert!(to.pass(at(since), b"x").is_none() && from.pass(at(since), b"x").is_some());
        assert_eq!(to.poll_timeout(), Some(at(since + 0.7)));
    }
}

#[test]
fn a_delay_grows_from_its_begin_on_every_connection() {
    let text = "fault \"delay\"; at_s = 10; for_s = 5000; delay_s = 0.5; growth = 0.02; direction = \"from_vehicle\"";
    let arrives = |since: f64, written: f64| {
        let mut link = faults(text).link(at(since), ME, None, Direction::FromVehicle);
        assert!(link.pass(at(written), b"x").is_none());
        link.poll_timeout().unwrap()
    };
    assert_eq!(arrives(0.0, 10.0), at(10.5));
    assert_eq!(arrives(0.0, 110.0), at(112.5));
    assert_eq!(arrives(100.0, 110.0), at(112.5));
    // The delay grows to no more than a minute.
    assert_eq!(arrives(4500.0, 4510.0), at(4570.5));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// For every plan: nothing arrives before it is written, the order stays, the same seed gives the same bytes, and
    /// what is written after the last fault arrives whole and at once.
    #[test]
    fn every_drawn_plan_keeps_the_link_in_order(seed in 0_u64..10_000, intensity in 0.0..1.0_f64) {
        let plan = FaultPlan::draw(seed, Duration::from_secs(60), intensity);
        let faults = LinkFaults::new(&plan, seed);
        for direction in [Direction::ToVehicle, Direction::FromVehicle] {
            let run = || {
                // Another test covers cuts: here the connection is made again.
                let (mut since, mut all) = (Timestamp::ZERO, Vec::new());
                for _ in 0..100 {
                    let mut link = faults.link(since, ME, None, direction);
                    all.extend(lines(&mut link, 80));
                    let Some(cut) = link.poll_timeout() else { break };
                    since = cut;
                }
                all
            };
            let arrived = run();
            prop_assert_eq!(&arrived, &run());
            let last = written(701..=800);
            prop_assert!(texts(&arrived).ends_with(&last));
        }
    }
}
