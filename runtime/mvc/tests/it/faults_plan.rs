use std::time::Duration;

use proptest::prelude::*;

use backseat_mvc::{ClientId, Direction, FaultEdge, FaultKind, FaultPlan, LinkFaults, Mvc, MvcEventKind, WorldFile};
use backseat_units::Timestamp;

use crate::files::{CALM, LIVELY};

/// Every kind of fault, with the keys that it may have.
const EVERY_KIND: &str = r#"
[[fault]]
at_s = 1
kind = "link_cut"
for_s = 2
client = 3
[[fault]]
at_s = 1.001
kind = "refuse"
for_s = 2
role = "sonar"
[[fault]]
at_s = 2
kind = "stall"
for_s = 2
direction = "both"
[[fault]]
at_s = 2
kind = "half_open"
for_s = 2
direction = "to_vehicle"
[[fault]]
at_s = 2
kind = "delay"
for_s = 2
delay_s = 1
jitter_s = 0.5
[[fault]]
at_s = 2
kind = "split"
for_s = 2
bytes = 4
gap_s = 0.01
[[fault]]
at_s = 2
kind = "join"
for_s = 2
hold_s = 0.2
[[fault]]
at_s = 2
kind = "duplicate"
for_s = 2
chance = 0.5
[[fault]]
at_s = 2
kind = "corrupt"
for_s = 2
chance = 0.001
[[fault]]
at_s = 2
kind = "drop"
for_s = 2
chance = 1
[[fault]]
at_s = 2
kind = "acks_lost"
for_s = 2
stage = "outcome"
[[fault]]
at_s = 2
kind = "acks_late"
for_s = 2
command = "RTK"
delay_s = 3
[[fault]]
at_s = 2
kind = "acks_negative"
for_s = 2
command = "BPRMB"
status = 0
done = true
[[fault]]
at_s = 2
kind = "control_taken"
for_s = 2
[[fault]]
at_s = 2
kind = "navigation_frozen"
for_s = 2
[[fault]]
at_s = 2
kind = "navigation_jump"
east_m = 10
north_m = -3.5
[[fault]]
at_s = 2
kind = "navigation_missing"
for_s = 2
[[fault]]
at_s = 2
kind = "sensor_dropout"
for_s = 2
sensor = "gps"
[[fault]]
at_s = 2
kind = "clock_step"
by_s = -3600.25
[[fault]]
at_s = 2
kind = "mission_abort"
[[fault]]
at_s = 2
kind = "shutdown"
[[fault]]
at_s = 2
kind = "deaf"
for_s = 4
role = "sonar"
[[fault]]
at_s = 2
kind = "delay"
for_s = 2
direction = "from_vehicle"
delay_s = 0
growth = 0.05
[[fault]]
at_s = 2
kind = "position_creep"
for_s = 2
speed_mps = 1.5
towards_deg = 270
[[fault]]
at_s = 2
kind = "position_frozen"
for_s = 2
[[fault]]
at_s = 2
kind = "position_backwards"
for_s = 2
[[fault]]
at_s = 2
kind = "velocity_missing"
for_s = 2
[[fault]]
at_s = 2
kind = "heading_flip"
for_s = 2
by_deg = -120
[[fault]]
at_s = 2
kind = "depth_flip"
for_s = 2
by_m = 20
[[fault]]
at_s = 2
kind = "another_dive"
dive_file = "other.dive"
reversed = true
"#;

#[test]
fn every_kind_is_read_and_written_back_in_full() {
    let plan = FaultPlan::from_toml(EVERY_KIND).unwrap();
    assert_eq!(plan.faults.len(), 30);
    let text = plan.to_toml();
    assert_eq!(FaultPlan::from_toml(&text).unwrap(), plan);
    let fields = text.split("[[fault]]").nth(5).unwrap().trim();
    assert_eq!(
        fields,
        "at_s = 2.0\nkind = \"delay\"\nfor_s = 2.0\ndirection = \"both\"\ndelay_s = 1.0\njitter_s = 0.5"
    );
    // In world.toml the plan is a section with the same tables.
    let section = EVERY_KIND.replace("[[fault]]", "[[faults.fault]]");
    let file = WorldFile::from_toml(&format!("{CALM}\n{section}")).unwrap();
    assert_eq!(file.faults.plan().unwrap(), plan);
}

#[test]
fn an_error_in_a_fault_names_its_number_its_key_and_what_was_expected() {
    let good = "[[fault]]\nat_s = 1\nkind = \"control_taken\"\nfor_s = 1\n";
    for (fault, expected) in [
        (
            "at_s = -1; kind = \"stall\"; for_s = 1",
            "fault 2: at_s is -1, expected 0 to 315360000 s",
        ),
        (
            "at_s = nan; kind = \"stall\"; for_s = 1",
            "fault 2: at_s is NaN, expected 0 to 315360000 s",
        ),
        (
            "at_s = 1; kind = \"stall\"; for_s = -2",
            "fault 2: for_s is -2, expected 0 to 315360000 s",
        ),
        (
            "at_s = 1; kind = \"stall\"",
            "fault 2: a fault of kind stall needs `for_s`",
        ),
        (
            "at_s = 1; kind = \"stall\"; for_s = 1; chance = 1",
            "fault 2: a fault of kind stall has no `chance`",
        ),
        (
            "at_s = 1; kind = \"delay\"; for_s = 1; delay_s = 61",
            "fault 2: delay_s is 61, expected 0 to 60 s",
        ),
        (
            "at_s = 1; kind = \"split\"; for_s = 1; bytes = 0",
            "fault 2: bytes is 0, expected 1 to 4096",
        ),
        (
            "at_s = 1; kind = \"join\"; for_s = 1; hold_s = 0",
            "fault 2: hold_s is 0, expected 0.001 to 10 s",
        ),
        (
            "at_s = 1; kind = \"drop\"; for_s = 1; chance = 1.5",
            "fault 2: chance is 1.5, expected 0 to 1",
        ),
        (
            "at_s = 1; kind = \"drop\"; for_s = 1",
            "fault 2: a fault of kind drop needs `chance`",
        ),
        (
            "at_s = 1; kind = \"acks_lost\"; for_s = 1; command = \"MODIFY\"",
            "fault 2: command is \"MODIFY\", expected a command of the interface, RMB or BPRMB",
        ),
        (
            "at_s = 1; kind = \"acks_negative\"; for_s = 1; status = 2",
            "fault 2: status is 2, expected 0 or 1",
        ),
        (
            "at_s = 1; kind = \"shutdown\"; for_s = 5",
            "fault 2: a fault of kind shutdown has no `for_s`",
        ),
        (
            "at_s = 1; kind = \"mission_abort\"; for_s = 5",
            "fault 2: a fault of kind mission_abort has no `for_s`",
        ),
        (
            "at_s = 1; kind = \"link_cut\"; client = 1; role = \"a\"",
            "fault 2: it has `client` and `role`, expected one of them",
        ),
        (
            "at_s = 1; kind = \"link_cut\"; direction = \"both\"",
            "fault 2: a fault of kind link_cut has no `direction`",
        ),
        (
            "at_s = 1; kind = \"navigation_jump\"; east_m = 20000; north_m = 0",
            "fault 2: east_m is 20000, expected -10000 to 10000 m",
        ),
        (
            "at_s = 1; kind = \"deaf\"; for_s = 1; direction = \"from_vehicle\"",
            "fault 2: a fault of kind deaf has no `direction`",
        ),
        (
            "at_s = 1; kind = \"delay\"; for_s = 1; delay_s = 1; growth = 2",
            "fault 2: growth is 2, expected 0 to 1",
        ),
        (
            "at_s = 1; kind = \"position_creep\"; for_s = 1; speed_mps = 2",
            "fault 2: a fault of kind position_creep needs `towards_deg`",
        ),
        (
            "at_s = 1; kind = \"heading_flip\"; for_s = 1; by_deg = 181",
            "fault 2: by_deg is 181, expected -180 to 180 degrees",
        ),
        (
            "at_s = 1; kind = \"depth_flip\"; for_s = 1; by_m = 3; by_deg = 3",
            "fault 2: a fault of kind depth_flip has no `by_deg`",
        ),
        (
            "at_s = 1; kind = \"another_dive\"; dive_file = \"a,b\"",
            "fault 2: dive_file is \"a,b\", expected a name in printable ascii without comma, asterisk and dollar",
        ),
        (
            "at_s = 1; kind = \"another_dive\"; dive_file = \"b\"; for_s = 3",
            "fault 2: a fault of kind another_dive has no `for_s`",
        ),
        (
            "at_s = 1; kind = \"clock_step\"; by_s = 86401",
            "fault 2: by_s is 86401, expected -86400 to 86400 s",
        ),
    ] {
        let text = format!("{good}[[fault]]\n{}", fault.replace("; ", "\n"));
        assert_eq!(FaultPlan::from_toml(&text).unwrap_err().to_string(), expected);
        let section = text.replace("[[fault]]", "[[faults.fault]]");
        let error = WorldFile::from_toml(&format!("{CALM}\n{section}")).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    for (fault, begins) in [
        (
            "at_s = 1; kind = \"gremlin\"; for_s = 1",
            "line 7, column 8: unknown variant `gremlin`",
        ),
        (
            "at_s = 1; kind = \"stall\"; for = 1",
            "line 8, column 1: unknown field `for`",
        ),
        (
            "kind = \"stall\"; for_s = 1",
            "fault 2: a fault of kind stall needs `at_s`",
        ),
    ] {
        let text = format!("{good}[[fault]]\n{}", fault.replace("; ", "\n"));
        let error = FaultPlan::from_toml(&text).unwrap_err().to_string();
        assert!(error.starts_with(begins) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn a_seed_draws_one_plan_with_faults_of_every_kind() {
    let hour = Duration::from_secs(3600);
    assert_eq!(FaultPlan::draw(4, hour, 0.7), FaultPlan::draw(4, hour, 0.7));
    assert_ne!(FaultPlan::draw(4, hour, 0.7), FaultPlan::draw(5, hour, 0.7));
    assert!(FaultPlan::draw(4, hour, 0.0).faults.is_empty());
    let mut names = std::collections::BTreeSet::new();
    let mut fatal = 0;
    for seed in 0..40 {
        let plan = FaultPlan::draw(seed, hour, 1.0);
        assert!((150..330).contains(&plan.faults.len()), "{}", plan.faults.len());
        for fault in &plan.faults {
            let one = FaultPlan {
                faults: vec![fault.clone()],
            };
            let text = one.to_toml();
            let name = text.split("kind = ").nth(1).unwrap().lines().next().unwrap();
            names.insert(name.to_owned());
            assert!(fault.at <= Timestamp::ZERO + hour);
            if matches!(fault.kind, FaultKind::MissionAbort | FaultKind::Shutdown) {
                fatal += 1;
                assert!(fault.at.as_secs_f64() >= 0.8 * 3600.0);
            } else {
                assert!(fault.until() <= Timestamp::ZERO + hour);
            }
        }
        assert_eq!(FaultPlan::from_toml(&plan.to_toml()).unwrap(), plan, "seed {seed}");
    }
    // Every kind but another dive: a drawn plan keeps the dive.
    assert_eq!(names.len(), 28, "{names:?}");
    assert!((1..12).contains(&fatal), "{fatal}");
}

/// The bytes and the events of a run. Its client has faulty links in both directions, and subscribes and asks again on
/// each connection.
struct Run {
    bytes: Vec<u8>,
    events: Vec<MvcEventKind>,
}

fn run(plan: &FaultPlan, seed: u64) -> Run {
    let mut mvc =
        Mvc::new(&WorldFile::from_toml(LIVELY).expect("the test's file is right"), seed).expect("a possible world");
    mvc.set_faults(plan.clone());
    let faults = LinkFaults::new(plan, seed);
    let end = plan.ends().unwrap_or_default() + Duration::from_secs(70);
    let mut run = Run {
        bytes: Vec::new(),
        events: Vec::new(),
    };
    let (mut now, mut client, mut links) = (Timestamp::ZERO, ClientId(0), None);
    let (mut next_try, mut next_word, mut identifier) = (Timestamp::ZERO, Timestamp::ZERO, 0);
    let mut out = Vec::new();
    while now < end {
        if links.is_none() && now >= next_try {
            client = ClientId(client.0 + 1);
            next_try = now + Duration::from_millis(700);
            if !faults.refuses(now, client, None) {
                mvc.connect(now, client);
                let mut up = faults.link(now, client, None, Direction::ToVehicle);
                up.push(now, b"$BPLOG,ALL,ON\r\n$BPLOG,ACK,ON\r\n");
                links = Some((up, faults.link(now, client, None, Direction::FromVehicle)));
            }
        }
        if let Some((up, _)) = &mut links
            && now >= next_word
        {
            next_word = now + Duration::from_millis(900);
            identifier += 1;
            let line = format!(
                "$BPRMB,070000.000,45,8,0,1.5,1,0\r\n$BPRTK,070000.000,{identifier},4218.01,N,06606.00,W,4218.03,N,06606.00,W,1,10,1.8,0,0\r\n$BPRMP,070000.000\r\n"
            );
            up.push(now, line.as_bytes());
        }
        mvc.handle_timeout(now);
        if let Some((up, down)) = &mut links {
            while let Some(chunk) = up.poll(now) {
                mvc.receive(now, client, &chunk);
            }
            while mvc.poll_transmit(&mut out).is_some() {
                if let Some(bytes) = down.pass(now, &out) {
                    run.bytes.extend_from_slice(bytes);
                }
            }
            while let Some(chunk) = down.poll(now) {
                run.bytes.extend_from_slice(&chunk);
                down.recycle(chunk);
            }
            let gone = mvc.poll_disconnect().is_some();
            if gone || up.is_cut(now) || down.is_cut(now) {
                mvc.disconnect(now, client);
                links = None;
                next_try = now + Duration::from_millis(100);
            }
        } else {
            while mvc.poll_disconnect().is_some() {}
        }
        while let Some(event) = mvc.poll_event() {
            run.events.push(event.kind);
        }
        let links_due = links
            .iter()
            .flat_map(|(up, down)| [up.poll_timeout(), down.poll_timeout()]);
        let next = links_due.chain([mvc.poll_timeout()]).flatten().min();
        // A link may name the time of a past fault, so time advances by at least a microsecond.
        now = next.unwrap_or(end).max(now + Duration::from_micros(1));
    }
    run
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Any plan over a short mission: no panic, the same bytes again, and each fault's begin and end in the log.
    #[test]
    fn the_mock_survives_any_drawn_plan_and_logs_each_fault(seed in 0_u64..100_000, intensity in 0.1..1.0_f64) {
        let plan = FaultPlan::draw(seed, Duration::from_secs(90), intensity);
        let one = run(&plan, seed);
        let two = run(&plan, seed);
        prop_assert!(one.bytes == two.bytes);
        prop_assert_eq!(&one.events, &two.events);
        prop_assert!(!one.events.iter().any(|event| matches!(event, MvcEventKind::EventsLost(_))));
        for number in 1..=plan.faults.len() as u32 {
            let edges: Vec<FaultEdge> = one
                .events
                .iter()
                .filter_map(|event| if let MvcEventKind::Fault(fault) = event { Some(fault) } else { None })
                .filter(|fault| fault.number == number)
                .map(|fault| fault.edge)
                .collect();
            prop_assert_eq!(edges, [FaultEdge::Begin, FaultEdge::End], "fault {}", number);
        }
    }
}
