//! `backseat sim` with faults, from the world or from `--faults`: the run survives them, reports them, and can be
//! repeated.

use backseat_recorder::{Log, read};
use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// The steady mission with these faults, shortened to four minutes.
fn world(faults: &str) -> Mission {
    Mission::steady()
        .edit("world.toml", "timeout_s = 600", "timeout_s = 230")
        .append("world.toml", faults)
}

fn fly(mission: &Mission) -> (Value, Log) {
    let path = mission.beside("run.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&path)
        .mission(mission)
        .run()
        .exit(0)
        .json();
    (report, read(&path).expect("the log can be read"))
}

/// The times at which the runtime has sent a sentence of this name, seconds.
fn sent(log: &Log, name: &str) -> Vec<f64> {
    let ours = log.link().filter(|(_, from_vehicle, _)| !from_vehicle);
    ours.filter(|(_, _, bytes)| String::from_utf8_lossy(bytes).contains(name))
        .map(|(at, _, _)| at.as_secs_f64())
        .collect()
}

#[test]
fn after_a_cut_the_runtime_connects_again_and_goes_on() {
    let (report, log) = fly(&world("[[faults.fault]]\nkind = \"link_cut\"\nat_s = 60\nfor_s = 10\n"));
    assert_eq!(report["faults"], 1);
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
    let modifies = sent(&log, "$BPRMB,");
    assert!(modifies.iter().any(|at| *at < 60.0));
    assert!(!modifies.iter().any(|at| (60.0..70.0).contains(at)), "{modifies:?}");
    assert!(modifies.iter().any(|at| (70.0..120.0).contains(at)), "{modifies:?}");
}

#[test]
fn a_stall_ends_the_connection_when_a_write_has_waited_for_two_seconds() {
    let stall = |seconds: f64| {
        let (report, log) = fly(&world(&format!(
            "[[faults.fault]]\nkind = \"stall\"\nat_s = 60\nfor_s = {seconds}\ndirection = \"to_vehicle\"\n"
        )));
        assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
        (sent(&log, "$BPVER,"), sent(&log, "$BPRMB,"))
    };
    assert_eq!(stall(0.9).0.len(), 1);
    // There is a modify each second: the first that waits is written by 61 s and given up by 63 s.
    assert_eq!(stall(3.0).0.len(), 2);
    // While the fault lasts every new connection is stalled as well, and given up in turn. Then one stays.
    let (connections, modifies) = stall(20.0);
    assert!(connections.len() > 2, "{connections:?}");
    let last = connections.last().copied().unwrap_or_default();
    assert!(modifies.iter().any(|at| *at > last + 60.0), "{connections:?}");
}

#[test]
fn silent_navigation_ends_the_lease_and_no_modify_is_sent() {
    let (report, log) = fly(&world(
        "[[faults.fault]]\nkind = \"half_open\"\nat_s = 60\nfor_s = 8\ndirection = \"from_vehicle\"\n",
    ));
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
    let modifies = sent(&log, "$BPRMB,");
    assert!(modifies.iter().any(|at| *at < 60.0));
    assert!(!modifies.iter().any(|at| (61.5..68.0).contains(at)), "{modifies:?}");
}

#[test]
fn a_file_of_faults_replaces_the_worlds_and_gives_the_same_bytes_again() {
    let mission = world("[[faults.fault]]\nkind = \"mission_abort\"\nat_s = 30\n");
    let path = mission.beside("faults.toml");
    std::fs::write(
        &path,
        "[[fault]]\nkind = \"corrupt\"\nat_s = 40\nfor_s = 20\nchance = 0.01\n\
         [[fault]]\nkind = \"delay\"\nat_s = 80\nfor_s = 20\ndelay_s = 0.1\njitter_s = 0.3\n",
    )
    .expect("the folder can be written to");
    let run = || {
        Backseat::new()
            .args(["sim", "--json", "--faults"])
            .arg(&path)
            .mission(&mission)
            .run()
            .exit(0)
            .json()
    };
    let report = run();
    assert_eq!(
        (&report["outcome"], &report["faults"]),
        (&"completed".into(), &2.into())
    );
    assert_eq!(report["digest"], run()["digest"]);
    let calm = Backseat::new()
        .args(["sim", "--json"])
        .mission(&world(""))
        .run()
        .exit(0)
        .json();
    assert_ne!(report["digest"], calm["digest"]);
}

#[test]
fn the_report_names_each_fault_and_those_that_never_began() {
    let faults = "[[faults.fault]]\nkind = \"delay\"\nat_s = 80\nfor_s = 20\ndelay_s = 0.1\n\
                  [[faults.fault]]\nkind = \"mission_abort\"\nat_s = 1000000\n\
                  [[faults.fault]]\nkind = \"link_cut\"\nat_s = 40\nfor_s = 5\n";
    let run = Backseat::new().arg("sim").mission(&world(faults)).run();
    let lines: Vec<&str> = run
        .stdout
        .lines()
        .filter(|line| line.starts_with("  fault at "))
        .collect();
    assert!(
        lines.len() == 3
            && lines[0].starts_with("  fault at 40 s for 5 s: ")
            && lines[1].starts_with("  fault at 80 s for 20 s: ")
            && lines[2].starts_with("  fault at 1000000 s: ")
            && lines[2].ends_with("; it never began, because the run ended before"),
        "{lines:?}"
    );
    assert!(!lines[1].contains("never"), "{lines:?}");
}

#[test]
fn a_wrong_file_of_faults_is_refused_with_file_number_and_key() {
    let mission = Mission::steady();
    let path = mission.beside("faults.toml");
    std::fs::write(&path, "[[fault]]\nkind = \"drop\"\nat_s = 1\nfor_s = 1\nchance = 7\n").expect("written");
    let refusal = Backseat::new()
        .args(["sim", "--faults"])
        .arg(&path)
        .mission(&mission)
        .run()
        .refusal();
    assert!(
        refusal.contains("faults.toml: fault 1: chance is 7, expected 0 to 1"),
        "{refusal}"
    );
}

#[test]
fn a_script_takes_control_and_cuts_the_link_in_the_same_way_in_each_run() {
    let rules = "[[rule]]\nwhen = { received = \"BPRMB\" }\nafter_s = 3\ndo = { control = \"take\" }\n\
                 [[rule]]\nwhen = { at_s = 60 }\ndo = { control = \"plan\" }\n\
                 [[rule]]\nwhen = { at_s = 70 }\nafter_s = 10\ndo = { fault = { kind = \"link_cut\", for_s = 10 } }\n";
    let mission = world("").write("script.toml", rules);
    let fly = |script: bool| {
        let path = mission.beside("run.mcap");
        let mut run = Backseat::new().args(["sim", "--json", "--log"]).arg(&path);
        if script {
            run = run.arg("--script").arg(mission.path().join("script.toml"));
        }
        let report = run.mission(&mission).run().exit(0).json();
        (report, read(&path).expect("the log can be read"))
    };
    let (report, log) = fly(true);
    assert_eq!(report["faults"], 1, "{report}");
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
    let modifies = sent(&log, "$BPRMB,");
    // What is under way when control is taken is there within thousandths; then nothing steers until 60 s.
    let first = modifies[0];
    let before = modifies.iter().filter(|at| **at < 60.0).copied().fold(0.0, f64::max);
    assert!((first + 1.0..first + 3.3).contains(&before), "{modifies:?}");
    assert!(modifies.iter().any(|at| (60.0..80.0).contains(at)), "{modifies:?}");
    assert!(!modifies.iter().any(|at| (80.0..90.0).contains(at)), "{modifies:?}");
    assert!(modifies.iter().any(|at| *at > 90.0), "{modifies:?}");
    let (again, _) = fly(true);
    assert_eq!(again["digest"], report["digest"]);
    let (without, _) = fly(false);
    assert_ne!(without["digest"], report["digest"]);
}
