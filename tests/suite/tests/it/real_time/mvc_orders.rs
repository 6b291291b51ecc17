//! The mock vehicle with a script, and with an operator who types.

use std::time::Duration;

use backseat_suite::{Backseat, Mission, Signal, Vehicle, Way, settle};

use super::mvc::Client;

const SOON: Duration = Duration::from_secs(20);
const RMB: &str = "$BPRMB,080000.000,90,8,0,1.5,1,0";

/// A vehicle with this script.
fn with(mission: Mission, script: &str, flags: &[&str]) -> (Vehicle, Mission) {
    let mission = mission.write("script.toml", script);
    let path = mission.path().join("script.toml");
    let mut all = vec!["--script", path.to_str().expect("a path of ASCII")];
    all.extend(flags);
    (Vehicle::start_with(&mission, "127.0.0.1:0", &all), mission)
}

fn at(vehicle: &Vehicle, text: &str) -> f64 {
    vehicle.sees(text, SOON, |line| line.text.contains(text)).at_s
}

#[test]
fn control_is_taken_3_s_after_the_first_modify_of_a_client() {
    let rules = "[[rule]]\nwhen = { received = \"BPRMB\" }\nafter_s = 3\ndo = { control = \"take\" }";
    let (vehicle, _mission) = with(Mission::steady(), rules, &["--profile", "field"]);
    let mut client = Client::connect(&vehicle.address);
    client.hears("$BFCTL");
    client.say(RMB);
    client.say(RMB);
    let taken = at(&vehicle, "rule 1: control taken from the payload");
    let asked = vehicle.receives("BPRMB", 1, SOON).at_s;
    // The log has thousandths.
    assert!((taken - asked - 3.0).abs() < 0.0021, "{asked} {taken}");
    let withdrawn = vehicle.sees("BFCTL 0", SOON, |line| {
        line.way == Way::Sent && line.name() == "BFCTL" && line.field(2) == "0"
    });
    assert!((taken..taken + 0.101).contains(&withdrawn.at_s), "{withdrawn:?}");
    client.hears(withdrawn.text.as_str());
}

#[test]
fn a_stall_of_a_rule_holds_the_link_that_is_there() {
    let rules = "[[rule]]\nwhen = { received = \"BPMSG\" }\nafter_s = 0.5\n\
                 do = { fault = { kind = \"stall\", for_s = 2, direction = \"to_vehicle\" } }";
    let (vehicle, _mission) = with(Mission::steady(), rules, &[]);
    let mut client = Client::connect(&vehicle.address);
    client.say("$BPMSG,080000.000,first");
    let from = at(&vehicle, "fault 1 begins: stall");
    client.say("$BPMSG,080000.000,second");
    let until = vehicle.receives("BPMSG", 2, SOON).at_s;
    assert!((until - from - 2.0).abs() < 0.05, "{from} {until}");
}

#[test]
fn an_operator_types_while_it_runs_and_a_bad_line_changes_nothing() {
    let mission = Mission::steady();
    let mut vehicle = Vehicle::start_typed(&mission, &["--profile", "field"]);
    let mut client = Client::connect(&vehicle.address);
    client.hears("$BFCTL");
    client.say("$BPLOG,NVG,ON");
    for (line, says) in [
        ("fautl stall for_s=1", "unknown command `fautl`: did you mean `fault`?"),
        ("fault stal for_s=1", "unknown variant `stal`: did you mean `stall`?"),
        ("fault stall", "a fault of kind stall needs `for_s`"),
        ("control tkae", "expected `take`, `give` or `plan`, and not `tkae`"),
        ("top pigeon coo", "`rf-modem` or `acoustic-modem`"),
        (
            "load other.dive",
            "operator: not done: no dive other.dive, expected one of steady.dive",
        ),
    ] {
        vehicle.process.types(line);
        vehicle.process.says(says, SOON);
    }
    vehicle.process.types("status");
    vehicle
        .process
        .says("Running, trackline 1 of the plan | control: payload | 1 client", SOON);
    vehicle.process.types("help");
    vehicle.process.says("control take|give|plan", SOON);
    assert!(!vehicle.log_text().contains("operator: control"), "{}", vehicle.story());
    vehicle.process.types("top acoustic-modem come home");
    client.hears(",3,come home*");
    vehicle.process.types("control take");
    vehicle.sees("control taken", SOON, |line| line.text == "control taken back");
    vehicle.process.types("fault link_cut");
    vehicle.sees("the cut", SOON, |line| line.text == "client 1 is cut off by a fault");
    // The end of the input is not the end of the program, and what has no line end counts.
    vehicle.process.ends_input();
    settle(Duration::from_millis(500));
    let mut again = Client::connect(&vehicle.address);
    again.hears("$BFVER");
    vehicle.process.signal(Signal::TERM);
    assert_eq!(vehicle.process.wait(SOON), Some(0));
}

#[test]
fn an_operator_aborts_loads_and_starts_dives() {
    let mission = Mission::steady();
    let mut vehicle = Vehicle::start_typed(&mission, &[]);
    at(&vehicle, "mission Running");
    for (line, says) in [
        ("abort", "mission Aborted: aborted by the operator"),
        ("load steady.dive", "mission Ready"),
    ] {
        vehicle.process.types(line);
        at(&vehicle, says);
    }
    vehicle.process.types("start");
    vehicle.sees("the second dive", SOON, |line| {
        line.text == "mission Running"
            && vehicle
                .lines()
                .iter()
                .filter(|line| line.text == "mission Running")
                .count()
                == 2
    });
    vehicle.process.types("shutdown");
    at(&vehicle, "payload power goes off in 60 s");
}

#[test]
fn many_lines_that_nobody_waits_for_do_not_stall_the_vehicle() {
    let mission = Mission::steady();
    let log = mission.beside("vehicle.log");
    let mut lines = "nonsense\nstatus\nhelp\n".repeat(5000);
    lines.push_str(&"x".repeat(100_000));
    lines.push_str("\ntop wifi the end");
    let ended = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0", "--duration", "5", "--log"])
        .arg(&log)
        .mission(&mission)
        .stdin(lines)
        .run()
        .exit(0);
    let text = std::fs::read_to_string(log).expect("the log was written");
    assert!(text.contains("message from the topside by 802.11: the end"), "{text}");
    assert!(text.contains("2.000 -- mission Running"), "{text}");
    assert!(ended.stderr.contains("5.0 s of the vehicle's time in 5."), "{ended}");
}
