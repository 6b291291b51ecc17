//! A mission that was signed, and runs only as it was signed.

use std::fs;
use std::path::Path;
use std::time::Duration;

use backseat_suite::{Backseat, Finished, Mission, Process};

const SOON: Duration = Duration::from_secs(45);

/// A mission with a component and a plan of its own, so that each of its files can be changed.
fn mission() -> Mission {
    let mission = Mission::copy("template");
    let component = backseat_test_support::plugins().join("template.wasm");
    fs::copy(component, mission.path().join("pilot.wasm")).expect("there is room");
    let mission = mission.edit(
        "mission.toml",
        "component = \"template\"",
        "component = \"./pilot.wasm\"",
    );
    let plan = mission.read("world.toml");
    let origin = plan
        .split("[origin]")
        .nth(1)
        .and_then(|rest| rest.split("\n[").next())
        .expect("it has an origin");
    let elements: String = plan
        .split("\n[[plan]]")
        .skip(1)
        .map(|rest| {
            let element = rest.split("\n[").next().unwrap_or_default();
            format!("\n[[plan]]{element}\n")
        })
        .collect();
    let plan = format!("[origin]{origin}\n{elements}");
    mission
        .write("plan.toml", plan)
        .append("mission.toml", "[plan]\nfile = \"plan.toml\"\n")
}

fn key(mission: &Mission, name: &str) {
    let output = Backseat::new().arg("key").arg(mission.beside(name)).run().exit(0);
    assert!(output.stdout.contains("give it to nobody"), "{output}");
}

fn sign(mission: &Mission, name: &str) -> Finished {
    Backseat::new()
        .args(["check", "--signer", "Ann", "--sign"])
        .arg(mission.beside(name))
        .arg("--log")
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(mission)
        .run()
}

fn locked(mission: &Mission, key: &str) -> Backseat {
    Backseat::new()
        .args(["run", "--connect", "127.0.0.1:9", "--locked"])
        .arg(mission.beside(key))
        .arg("--log")
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(mission)
}

fn change_a_byte(file: &Path) -> Vec<u8> {
    let before = fs::read(file).expect("it is there");
    let mut after = before.clone();
    // A byte of the last line, which in a text is a blank or a letter of a comment.
    let place = after.len() - 4;
    after[place] ^= 1;
    fs::write(file, after).expect("there is room");
    before
}

#[test]
fn a_locked_mission_runs_only_as_it_was_signed() {
    let mission = mission().append("mission.toml", "# end\n");
    key(&mission, "ann");
    key(&mission, "bob");
    let signed = sign(&mission, "ann.key").exit(0);
    assert!(signed.stdout.contains("mission.lock"), "{signed}");
    let process: Process = locked(&mission, "ann.pub").spawn();
    process.says("locked: signed by Ann, 20", SOON);
    drop(process);

    let refused = |command: Backseat, expected: &str| {
        let error = command.run().refusal();
        assert!(error.contains(expected), "{expected}: {error}");
    };
    for (file, expected) in [
        ("mission.toml", "mission.toml differs"),
        ("fence.geojson", ""),
        ("plan.toml", ""),
        ("pilot.wasm", ""),
        ("mission.lock", ""),
    ] {
        let path = mission.path().join(file);
        let before = change_a_byte(&path);
        // A byte that makes a file unreadable is refused before it is compared.
        refused(locked(&mission, "ann.pub"), expected);
        fs::write(&path, before).expect("there is room");
    }
    // The files are as they were signed, and the command line changes them.
    refused(
        locked(&mission, "ann.pub").args(["--set", "limits.speed_max_mps=1.9"]),
        "--set limits.speed_max_mps=1.9 changes the mission: leave it out: ",
    );
    for (file, from, to, expected) in [
        (
            "mission.toml",
            "speed_max_mps = 2.0",
            "speed_max_mps = 2.1",
            "the limits differ (",
        ),
        (
            "fence.geojson",
            "\"margin_m\": ",
            "\"margin_m\": 1",
            "fence.geojson): restore what Ann signed",
        ),
        (
            "plan.toml",
            "speed_mps = 1.5",
            "speed_mps = 1.4",
            "plan.toml): restore what Ann signed",
        ),
    ] {
        let path = mission.path().join(file);
        let before = fs::read_to_string(&path).expect("it is there");
        let after = before.replacen(from, to, 1);
        assert_ne!(before, after, "{file} has no {from}");
        fs::write(&path, after).expect("there is room");
        refused(locked(&mission, "ann.pub"), expected);
        fs::write(&path, before).expect("there is room");
    }
    let path = mission.path().join("pilot.wasm");
    let before = fs::read(&path).expect("it is there");
    fs::copy(backseat_test_support::plugins().join("echo.wasm"), &path).expect("there is room");
    refused(locked(&mission, "ann.pub"), "pilot.wasm): restore what Ann signed");
    fs::write(&path, before).expect("there is room");
    refused(
        locked(&mission, "ann.pub").args(["--set", "vehicle.name=another"]),
        "a setting of --set",
    );
    refused(locked(&mission, "bob.pub"), "not signed with the key of");
    refused(locked(&mission, "ann.key"), "is no public key");
    let process = locked(&mission, "ann.pub").spawn();
    process.says("locked: signed by Ann", SOON);
}

fn check(mission: &Mission) -> Backseat {
    Backseat::new()
        .args(["check", "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(mission)
}

#[test]
fn a_check_tells_that_a_mission_is_not_as_it_was_signed() {
    let mission = mission();
    assert!(!check(&mission).run().stdout.contains("mission.lock"));
    key(&mission, "ann");
    let _signed = sign(&mission, "ann.key").exit(0);
    let same = check(&mission).run().exit(0);
    assert!(
        same.stdout
            .contains("mission.lock: nothing differs from what it says that Ann signed; check --locked"),
        "{same}"
    );
    let verified = || check(&mission).arg("--locked").arg(mission.beside("ann.pub")).run();
    let trusted = verified().exit(0).stdout;
    assert!(
        trusted.contains("mission.lock: signed by Ann, ") && trusted.trim_end().ends_with("\nready"),
        "{trusted}"
    );
    let lock = mission.read("mission.lock");
    fs::write(mission.path().join("mission.lock"), lock.replace("Ann", "Bnn")).expect("there is room");
    let forged = verified().exit(1).stdout;
    assert!(
        forged.contains("mission.lock: not signed with the key of") && forged.trim_end().ends_with("\nnot ready"),
        "{forged}"
    );
    fs::write(mission.path().join("mission.lock"), lock).expect("there is room");
    let mission = mission.edit("fence.geojson", "\"margin_m\": ", "\"margin_m\": 1");
    let differs = check(&mission)
        .arg("--locked")
        .arg(mission.beside("ann.pub"))
        .run()
        .exit(1);
    assert!(differs.stdout.contains("the fence differs ("), "{differs}");
    let changed = check(&mission).run();
    assert!(
        changed.stdout.contains("warning: mission.lock: the fence differs (")
            && changed
                .stdout
                .contains("fence.geojson), so that `run --locked` refuses")
            && changed.stdout.contains("sign anew"),
        "{changed}"
    );
    assert!(
        changed
            .stdout
            .trim_end()
            .ends_with("\nready, but not for `run --locked`"),
        "{changed}"
    );
    fs::write(mission.path().join("mission.lock"), "x").expect("there is room");
    let damaged = check(&mission).run();
    assert!(damaged.stdout.contains("is no lock, or is damaged"), "{damaged}");
}

#[test]
fn a_key_of_the_other_kind_is_told_as_such() {
    let mission = mission();
    key(&mission, "ann");
    let refused = sign(&mission, "ann.pub").exit(2);
    assert!(
        refused.stderr.contains("ann.pub: is no secret key") && !refused.stderr.contains("chmod"),
        "{refused}"
    );
}

#[test]
fn a_mission_that_is_not_ready_is_not_signed() {
    let mission = mission().edit("mission.toml", "grants = [\"modify\"]", "grants = []");
    key(&mission, "ann");
    let output = sign(&mission, "ann.key").exit(1);
    assert!(output.stdout.contains("not signed"), "{output}");
    assert!(!mission.path().join("mission.lock").exists());
    let error = locked(&mission, "bob.pub").run().refusal();
    assert!(
        error.contains("bob.pub: is not there: copy the .pub of whoever signed the mission there"),
        "{error}"
    );
    let error = locked(&mission, "ann.pub").run().refusal();
    assert!(
        error.contains("mission.lock: is not there: sign the mission with `backseat check MISSION --sign NAME.key`"),
        "{error}"
    );
}
