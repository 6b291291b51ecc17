//! `backseat log report`: what a run came to, on a page.

use std::path::{Path, PathBuf};

use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// The log of a simulated isobath mission in which much goes wrong, and what `sim` said of it.
fn flown(mission: &Mission, arguments: &[&str]) -> (PathBuf, Value) {
    let log = mission.beside("dive.mcap");
    let said = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&log)
        .args(arguments.iter().copied())
        .mission(mission)
        .run();
    (log, said.json())
}

fn report(log: &Path) -> Value {
    Backseat::new()
        .args(["log", "report", "--json"])
        .arg(log)
        .run()
        .exit(0)
        .json()
}

/// The isobath mission, with a plugin beside it that asks for lines across the fence.
fn mission() -> Mission {
    Mission::copy("isobath").append(
        "mission.toml",
        "[[plugin]]\nname = \"wild\"\ncomponent = \"faulty\"\ngrants = [\"insert\"]\n[plugin.config]\n\
         fault = \"cross_fence\"\nafter_s = 60\n",
    )
}

#[test]
fn a_run_is_summed_up_by_owner_and_rule() {
    let mission = mission();
    let (log, said) = flown(&mission, &["--draw-faults", "4@60..900"]);
    let report = report(&log);
    assert_eq!(report["mission"], "isobath");
    let asked = report["asked"].as_object().unwrap();
    let sum = |what: &str| -> u64 { asked.values().map(|asked| asked[what].as_u64().unwrap()).sum() };
    assert_eq!(sum("all"), said["requests"]["proposed"].as_u64().unwrap(), "{report}");
    assert_eq!(
        sum("refused"),
        said["requests"]["rejected"].as_u64().unwrap(),
        "{report}"
    );
    assert_eq!(
        sum("unsent"),
        said["requests"]["replaced"].as_u64().unwrap(),
        "{report}"
    );
    // Those of our computer count too, and are told.
    assert_eq!(said["faults"], 4);
    let refused = report["refused"].as_array().unwrap();
    let times: u64 = refused.iter().map(|refused| refused["times"].as_u64().unwrap()).sum();
    assert_eq!(times, sum("refused"), "{report}");
    let wild = refused.iter().find(|refused| refused["owner"] == "wild").unwrap();
    assert!(!wild["rule"].as_str().unwrap().is_empty(), "{wild}");
    let control_s: f64 = report["control_s"].as_f64().unwrap();
    let windows = said["control"]["windows"].as_array().unwrap();
    let seconds = |window: &Value| window["until_s"].as_f64().unwrap() - window["from_s"].as_f64().unwrap();
    let theirs_s: f64 = windows.iter().map(seconds).sum();
    assert!(
        (control_s - theirs_s).abs() < 2.0 * windows.len() as f64,
        "{control_s} is not {theirs_s}"
    );
    // Each window but one that lasts until the end has an end with its reason.
    let lost = report["control_lost"].as_array().unwrap();
    let losses: u64 = lost.iter().map(|lost| lost["times"].as_u64().unwrap()).sum();
    let until_end = u64::from(report["without_control_from_s"].is_null());
    assert_eq!(losses + until_end, windows.len() as u64, "{report}");
    assert!(
        lost.iter().all(|lost| !lost["reason"].as_str().unwrap().is_empty()),
        "{report}"
    );
    // Nobody operated it: that a simulation stops its runtime at the end is no act of an operator.
    assert_eq!(report["operator"].as_array().unwrap().len(), 0, "{report}");
}

#[test]
fn the_page_is_one_file_that_loads_nothing_and_runs_nothing() {
    let mission = mission();
    let (log, _) = flown(&mission, &[]);
    let page = mission.beside("dive.html");
    let told = Backseat::new()
        .args(["log", "report"])
        .arg(&log)
        .arg("--html")
        .arg(&page)
        .run()
        .exit(0);
    assert!(told.stdout.contains("asked for\n"), "{told}");
    assert!(told.stdout.contains("  control lost 1 x: "), "{told}");
    assert!(
        told.stdout.contains(" s to the end: the vehicle has control\n"),
        "{told}"
    );
    assert!(told.stdout.contains("refused\n"), "{told}");
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>"), "{html}");
    assert!(html.contains("wild") && html.contains("control lost 1 x: "), "{html}");
    for loads in ["<script", "src=", "href=", "url(", "@import"] {
        assert!(!html.contains(loads), "{loads} is in the page");
    }
}

#[test]
fn a_log_that_is_cut_or_is_none_is_told() {
    let mission = Mission::copy("isobath");
    let (log, _) = flown(&mission, &[]);
    let bytes = std::fs::read(&log).unwrap();
    let cut = mission.beside("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let told = Backseat::new().args(["log", "report"]).arg(&cut).run().exit(0);
    assert!(told.stdout.contains("the log is cut short"), "{told}");
    let none = mission.beside("none.mcap");
    std::fs::write(&none, "no log").unwrap();
    let refused = Backseat::new().args(["log", "report"]).arg(&none).run().refusal();
    assert!(refused.contains("expected the log of a run"), "{refused}");
}
