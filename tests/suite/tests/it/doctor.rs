//! `doctor`: this computer and its network before a dive.

use std::net::TcpListener;

use backseat_suite::{Backseat, Mission};
use serde_json::Value;

fn doctor(mission: &Mission, arguments: &[&str]) -> Backseat {
    Backseat::new()
        .args(["doctor", "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .args(arguments.iter().copied())
        .mission(mission)
}

#[test]
fn a_computer_that_is_fit_is_described_and_one_without_a_vehicle_is_not_fit() {
    let mission = Mission::steady();
    let vehicle = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = vehicle.local_addr().expect("it has one").to_string();
    let fit = doctor(&mission, &["--connect", &address, "--json"])
        .run()
        .exit(0)
        .json();
    assert_eq!(fit["fit"], true, "{fit}");
    let findings = fit["findings"].as_array().expect("a list");
    let of = |what: &str| -> Value {
        let found = findings.iter().find(|finding| finding["what"] == what);
        found.unwrap_or_else(|| panic!("nothing of {what}: {fit}")).clone()
    };
    assert_eq!(of("vehicle")["word"], "ok");
    assert_eq!(of("clock")["word"], "ok");
    let hash = of("plugin pilot")["text"].as_str().expect("a text").to_owned();
    assert!(
        hash.split("SHA-256 ").nth(1).is_some_and(|hash| hash.len() == 64),
        "{hash}"
    );
    drop(vehicle);
    let gone = doctor(&mission, &["--connect", &address]).run().exit(1);
    assert!(
        gone.stdout.contains("bad  vehicle: ") && gone.stdout.contains("not fit"),
        "{gone}"
    );
    let offline = doctor(&mission, &["--offline"]).run().exit(0);
    assert!(
        !offline.stdout.contains("vehicle:") && offline.stdout.ends_with("fit\n"),
        "{offline}"
    );
}

#[test]
fn a_mission_without_its_component_is_not_fit() {
    let mission = Mission::steady().edit("mission.toml", "component = \"faulty\"", "component = \"nowhere\"");
    let output = doctor(&mission, &["--offline"]).run().exit(1);
    assert!(output.stdout.contains("bad  plugins: "), "{output}");
}
