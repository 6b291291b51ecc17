//! Another version of a plugin in the middle of a dive, and plugins in the shadow of others.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use backseat_recorder::{Log, LogReader, Record, read};
use backseat_suite::{Backseat, Finished, Mission, Process, Signal, Vehicle, eventually};
use serde_json::Value;
use sha2::{Digest as _, Sha256};

use super::session::{SOON, runtime};

/// The steady mission, steered by the template at this heading.
fn mission(heading_deg: f64) -> Mission {
    let mission = Mission::steady()
        .edit("mission.toml", "component = \"faulty\"", "component = \"template\"")
        .edit("mission.toml", "fault = \"none\"\n", "")
        .edit(
            "mission.toml",
            "heading_deg = 90.0",
            &format!("heading_deg = {heading_deg:.1}"),
        );
    mission.append("mission.toml", "speed_mps = 1.5\n")
}

/// The same with another name of the plugin.
fn mission_of(plugin: &str) -> Mission {
    mission(180.0).edit("mission.toml", "name = \"pilot\"", &format!("name = \"{plugin}\""))
}

/// The template once more: the same code, another component.
fn second(mission: &Mission, name: &str) -> PathBuf {
    let mut bytes = fs::read(backseat_test_support::plugins().join("template.wasm")).expect("it is there");
    // A custom section of one byte, which nobody reads.
    bytes.extend([0, 2, 1, name.as_bytes()[0]]);
    let path = mission.beside(name);
    fs::write(&path, bytes).expect("it is there");
    path
}

/// The template once more, and so large that a log has it by its hash alone.
fn large(mission: &Mission) -> PathBuf {
    let path = second(mission, "large.wasm");
    let mut bytes = fs::read(&path).expect("it is there");
    // A custom section of 9 MiB with an empty name; its size is in LEB128.
    bytes.extend([0, 0x81, 0x80, 0xc0, 0x04, 0]);
    bytes.extend(std::iter::repeat_n(0, 9 << 20));
    fs::write(&path, bytes).expect("it is there");
    path
}

fn fickle() -> PathBuf {
    backseat_test_support::plugins().join("fickle.wasm")
}

fn hash(file: &Path) -> String {
    Sha256::digest(fs::read(file).expect("it is there"))
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn swap(mission: &Mission, file: &Path) -> Finished {
    swap_with(mission, file, &["--sha256", &hash(file)[..12]])
}

fn swap_with(mission: &Mission, file: &Path, arguments: &[&str]) -> Finished {
    Backseat::new()
        .arg("swap")
        .mission(mission)
        .arg(format!("pilot={}", file.display()))
        .arg("--state")
        .arg(mission.beside("state"))
        .args(arguments.iter().copied())
        .run()
}

fn ended(mission: &Mission, mut run: Process) -> (Log, PathBuf) {
    run.signal(Signal::INT);
    assert_eq!(run.wait(SOON), Some(0), "{}", run.stderr());
    let logs: Vec<PathBuf> = fs::read_dir(mission.beside("logs"))
        .expect("the run has written a log")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    let [log] = &logs[..] else { panic!("{logs:?}") };
    (read(log).expect("the log can be read"), log.clone())
}

/// The longest time without a BPRMB while the runtime steered, seconds.
fn worst_gap_s(log: &Log) -> f64 {
    let sent = log
        .link()
        .filter(|(_, received, bytes)| !received && bytes.starts_with(b"$BPRMB"));
    let sent: Vec<f64> = sent.map(|(at, _, _)| at.as_secs_f64()).collect();
    assert!(sent.len() > 3, "{sent:?}");
    sent.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
}

/// What the log has of shadows.
fn shadow_steps(log: &Path) -> Vec<Value> {
    let mut reader = LogReader::open(log).expect("it is there");
    let mut steps = Vec::new();
    while let Some(message) = reader.next_message().expect("it is whole") {
        if *message.topic == *"/shadow" {
            steps.push(serde_json::from_slice(&message.data).expect("it is JSON"));
        }
    }
    steps
}

/// What `backseat log` prints.
fn log_told(command: &str, log: &Path) -> String {
    Backseat::new().args(["log", command]).arg(log).run().exit(0).stdout
}

fn replayed(log: &Path) -> Value {
    let report = Backseat::new().args(["replay", "--json"]).arg(log).run().exit(0).json();
    assert_eq!(report["identical"], true, "{report}");
    report
}

#[test]
fn versions_take_over_in_the_middle_of_a_lease_and_the_dive_is_replayed() {
    let mission = mission(180.0);
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let (first, next) = (
        backseat_test_support::plugins().join("template.wasm"),
        second(&mission, "next.wasm"),
    );
    for (file, count) in [(&next, 6), (&first, 9)] {
        let swapped = swap_with(&mission, file, &["--sha256", &hash(file), "--trial", "2"]).exit(0);
        assert!(swapped.stdout.contains(&hash(file)[..12]), "{swapped}");
        run.says("pilot: swapped", SOON);
        run.says(
            &format!("({}) has passed its trial of 2 steps", &hash(file)[..12]),
            SOON,
        );
        let _ = vehicle.receives("BPRMB", count, SOON);
    }
    assert!(vehicle.received("BPEMB").is_empty(), "one lease: {}", vehicle.story());
    let (log, path) = ended(&mission, run);
    let gap_s = worst_gap_s(&log);
    assert!(gap_s < 1.5, "{gap_s:.3} s without BPRMB");
    let report = replayed(&path);
    let counts = |key: &str| report["plugins"][0][key].as_u64();
    assert_eq!(
        ["swaps", "swaps_failed", "restarts"].map(counts),
        [Some(2), Some(0), Some(0)],
        "{report}"
    );
    // A version that does the same, in the place of all of them, hands its state to itself where they did.
    let again = Backseat::new()
        .args(["replay", "--json", "--plugin"])
        .arg(format!("pilot={}", second(&mission, "third.wasm").display()))
        .arg(&path)
        .run()
        .exit(0)
        .json();
    let counts = |key: &str| again["plugins"][0][key].as_u64();
    assert_eq!(
        ["swaps", "restarts", "different"].map(counts),
        [Some(2), Some(0), Some(0)],
        "{again}"
    );
    let passed = format!(
        "pilot: version 0.1.0 ({}) has passed its trial of 2 steps",
        &hash(&next)[..12]
    );
    for (command, line) in [("show", "pilot: swapped"), ("show", &passed), ("report", &passed)] {
        let told = log_told(command, &path);
        assert!(told.contains(line), "{line}: {told}");
        assert!(!told.contains("the version before"), "{told}");
        assert!(!told.contains("was on trial"), "{told}");
    }
}

#[test]
fn a_dive_with_a_swap_to_a_large_component_is_replayed_and_the_component_is_given() {
    let mission = mission(180.0);
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let large = large(&mission);
    let _ = swap(&mission, &large).exit(0);
    run.says("pilot: swapped", SOON);
    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 3, SOON);
    let (_, path) = ended(&mission, run);
    let alone = Backseat::new().arg("replay").arg(&path).run().exit(2);
    let named = format!("give the file with --component FILE (SHA-256 {})", hash(&large));
    assert!(
        alone.stderr.contains(&named) && alone.stderr.contains("plugin pilot, at "),
        "{alone}"
    );
    assert!(alone.stdout.contains("inputs, all identical"), "{alone}");
    assert!(
        alone
            .stdout
            .contains("steps, swaps: 1, all identical; not compared from "),
        "{alone}"
    );
    assert!(alone.stdout.contains("identical as far as it was replayed"), "{alone}");
    let all = Backseat::new()
        .args(["replay", "--json", "--component"])
        .arg(&large)
        .arg(&path)
        .run()
        .exit(0)
        .json();
    assert_eq!(all["identical"], true, "{all}");
    let counts = |key: &str| all["plugins"][0][key].as_u64();
    assert_eq!(["swaps", "unplayed"].map(counts), [Some(1), Some(0)], "{all}");
    let other = Backseat::new()
        .args(["replay", "--component"])
        .arg(fickle())
        .arg("--component")
        .arg(&large)
        .arg(&path)
        .run()
        .exit(0);
    assert!(
        other.stderr.contains("fickle.wasm: it did not fly in this dive"),
        "{other}"
    );
    let template = backseat_test_support::plugins().join("template.wasm");
    let flew = Backseat::new()
        .args(["replay", "--component"])
        .arg(template)
        .arg(&path)
        .run()
        .exit(2);
    assert!(!flew.stderr.contains("did not fly"), "{flew}");
}

#[test]
fn the_report_tells_of_a_version_that_the_next_one_replaced_on_trial() {
    let mission = mission(180.0);
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let (first, next) = (
        backseat_test_support::plugins().join("template.wasm"),
        second(&mission, "next.wasm"),
    );
    for (file, count) in [(&next, 6), (&first, 9)] {
        let swapped = swap_with(&mission, file, &["--sha256", &hash(file), "--trial", "1000"]).exit(0);
        assert!(swapped.stdout.contains(&hash(file)[..12]), "{swapped}");
        run.says("pilot: swapped", SOON);
        let _ = vehicle.receives("BPRMB", count, SOON);
    }
    let (_, path) = ended(&mission, run);
    let told = log_told("report", &path);
    let line = format!(
        "pilot: version 0.1.0 ({}) was on trial, and the next one comes in its place",
        &hash(&next)[..12]
    );
    assert_eq!(told.matches("was on trial").count(), 1, "{told}");
    assert!(told.contains(&line), "{line}: {told}");
}

#[test]
fn a_version_that_traps_on_trial_gives_way_and_the_vehicle_is_steered_on() {
    gives_way(90.0, "version 0.2.0 on trial: ");
}

#[test]
fn a_version_that_is_refused_on_trial_gives_way_and_the_vehicle_is_steered_on() {
    gives_way(180.0, "version 0.2.0 on trial: refused: grant: ");
}

fn gives_way(heading_deg: f64, why: &str) {
    let mission = mission(heading_deg);
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let _ = swap(&mission, &fickle()).exit(0);
    let line = run.says(why, SOON);
    assert!(line.contains("the version before comes back"), "{line}");
    run.says("pilot works again", SOON);
    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 4, SOON);
    let (log, path) = ended(&mission, run);
    let gap_s = worst_gap_s(&log);
    assert!(gap_s < 1.5, "{gap_s:.3} s without BPRMB: {}", vehicle.story());
    let report = replayed(&path);
    let counts = |key: &str| report["plugins"][0][key].as_u64();
    assert_eq!(
        ["swaps", "swaps_failed", "restarts"].map(counts),
        [Some(1), Some(1), Some(0)],
        "{report}"
    );
    let line = format!(
        "pilot: version 0.2.0 ({}) did not pass its trial, and the version before is back",
        &hash(&fickle())[..12]
    );
    let told = log_told("report", &path);
    assert!(told.contains(&line), "{line}: {told}");
}

#[test]
fn a_swap_that_cannot_be_done_says_why_and_changes_nothing() {
    let mission = mission(180.0);
    let good = second(&mission, "next.wasm");
    // Nobody flies it yet.
    let nobody = swap(&mission, &good).refusal();
    assert!(nobody.contains("no runtime uses this folder"), "{nobody}");
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let unnamed = swap_with(&mission, &good, &[]).refusal();
    assert!(
        unnamed.contains(&format!("--sha256 {}", &hash(&good)[..12])),
        "{unnamed}"
    );
    let short = swap_with(&mission, &good, &["--sha256", "abc"]).refusal();
    assert!(short.contains("expected 12 hexadecimal digits or more"), "{short}");
    let large = mission.beside("large.wasm");
    std::fs::File::create(&large).unwrap().set_len(33 << 20).unwrap();
    let too_large = swap_with(&mission, &large, &["--sha256", "0123456789ab"]).refusal();
    assert!(
        too_large.contains("large.wasm: 34603008 bytes, expected at most 33554432"),
        "{too_large}"
    );
    let wrong = swap_with(&mission, &good, &["--sha256", "0123456789ab"]).refusal();
    assert!(wrong.contains(&hash(&good)), "{wrong}");
    let stranger = Backseat::new()
        .arg("swap")
        .mission(&mission)
        .arg(format!("nobody={}", good.display()))
        .run()
        .refusal();
    assert!(stranger.contains("its plugins are: pilot"), "{stranger}");

    let plugins = backseat_test_support::plugins();
    let garbage = mission.beside("garbage.wasm");
    fs::write(&garbage, "no component").unwrap();
    for (file, why) in [
        (garbage, "pilot: not swapped: plugin `pilot`"),
        // Its config has other keys.
        (plugins.join("isobath.wasm"), "cannot be started: config"),
        // It is another plugin, whose state is another.
        (
            plugins.join("faulty.wasm"),
            "not swapped, the version before goes on: restore: ",
        ),
    ] {
        let refused = swap(&mission, &file).exit(1);
        assert!(refused.stdout.contains(why), "{why}: {refused}");
        run.says("not swapped", SOON);
    }
    // The mission of another run, and a disk without room for the component.
    let other = mission_of("other");
    let refused = Backseat::new()
        .arg("swap")
        .mission(&other)
        .arg(format!("other={}", good.display()))
        .args(["--sha256", &hash(&good), "--state"])
        .arg(mission.beside("state"))
        .run()
        .exit(1);
    assert!(
        refused.stdout.contains("other: not swapped: the runtime flies ") && refused.stdout.contains("are: pilot"),
        "{refused}"
    );
    run.says("other: not swapped: the runtime flies ", SOON);
    let full = Backseat::new()
        .arg("swap")
        .mission(&mission)
        .arg(format!("pilot={}", good.display()))
        .args(["--sha256", &hash(&good), "--state"])
        .arg(mission.beside("state"))
        .file_max_kib(16)
        .run();
    assert_eq!(full.code, Some(2), "{full}");
    let left: Vec<_> = fs::read_dir(mission.beside("state/swap"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| !name.ends_with(".lock"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
    // A folder into which others can write.
    let folder = mission.beside("state/swap");
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o777)).unwrap();
    let open = swap(&mission, &good).refusal();
    assert!(open.contains("chmod go-w"), "{open}");
    fs::write(
        folder.join("pilot.order"),
        "number = 1\nsha256 = \"x\"\ntrial_steps = 1\n",
    )
    .unwrap();
    run.says("order to swap ignored: ", SOON);
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o700)).unwrap();
    fs::write(folder.join("pilot.order"), "nonsense").unwrap();
    run.says("order to swap ignored: ", SOON);

    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 2, SOON);
    assert!(vehicle.received("BPEMB").is_empty(), "one lease: {}", vehicle.story());
    let (log, path) = ended(&mission, run);
    let gap_s = worst_gap_s(&log);
    assert!(gap_s < 1.5, "{gap_s:.3} s without BPRMB");
    let _ = replayed(&path);
    for command in ["show", "report"] {
        let told = log_told(command, &path);
        assert!(told.contains("pilot: not swapped: plugin `pilot`"), "{told}");
    }
    let told = log_told("report", &path);
    assert!(
        told.contains("could not take over, and the version before goes on")
            && told.contains(" s: pilot: not swapped, the version before goes on: restore: "),
        "{told}"
    );
}

/// The command of a swap of the pilot, which goes on by itself.
fn begun(mission: &Mission, file: &Path) -> Process {
    Backseat::new()
        .arg("swap")
        .mission(mission)
        .arg(format!("pilot={}", file.display()))
        .arg("--state")
        .arg(mission.beside("state"))
        .args(["--sha256", &hash(file)])
        .spawn()
}

/// Waits until the folder of the orders has this one.
fn ordered(mission: &Mission) {
    let order = mission.beside("state/swap/pilot.order");
    eventually(SOON, || order.exists().then_some(()), || "there is no order".to_owned());
}

#[test]
fn one_order_for_a_plugin_is_under_way_at_a_time_and_what_is_withdrawn_is_not_carried_out() {
    let mission = mission(180.0);
    let next = second(&mission, "next.wasm");
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    run.signal(Signal::STOP);
    let mut first = begun(&mission, &next);
    ordered(&mission);
    let other = swap(&mission, &next).refusal();
    assert!(
        other.contains("another `backseat swap` of pilot is under way: wait for its end"),
        "{other}"
    );
    assert_eq!(first.wait(SOON), Some(2));
    let told = first.stderr();
    assert!(told.contains("the order, which is withdrawn: is it stuck?"), "{told}");
    run.signal(Signal::CONT);
    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 3, SOON);
    // What it left is in nobody's way.
    let _ = swap(&mission, &next).exit(0);
    run.says("pilot: swapped", SOON);
    let left: Vec<_> = fs::read_dir(mission.beside("state/swap"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(left, ["pilot.lock"]);
    let (_, path) = ended(&mission, run);
    let report = replayed(&path);
    assert_eq!(report["plugins"][0]["swaps"], 1, "{report}");
}

#[test]
fn an_order_waits_while_the_runtime_is_at_work_on_another_and_a_command_that_was_killed_is_in_nobodys_way() {
    let mission = mission(180.0);
    let (next, other) = (second(&mission, "next.wasm"), second(&mission, "other.wasm"));
    let vehicle = Vehicle::start(&mission);
    let mut run = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    run.signal(Signal::STOP);
    let mut killed = begun(&mission, &next);
    ordered(&mission);
    killed.kill();
    // As if it made a version ready, for longer than a command waits for a runtime that is stuck.
    fs::write(mission.beside("state/swap/at-work"), "pilot").unwrap();
    let mut waits = begun(&mission, &other);
    waits.says(
        "pilot: the runtime is at work on an earlier order, and this one waits",
        SOON,
    );
    run.signal(Signal::CONT);
    assert_eq!(waits.wait(SOON), Some(0), "{}", waits.stderr());
    assert!(waits.stdout().contains(&hash(&other)[..12]), "{}", waits.stdout());
    // A runtime that ends answers nobody.
    run.signal(Signal::STOP);
    let mut waits = begun(&mission, &next);
    ordered(&mission);
    run.kill();
    assert_eq!(waits.wait(SOON), Some(2));
    let told = waits.stderr();
    assert!(told.contains("the runtime has ended, and has not answered"), "{told}");
    // The next run does not carry it out, and says so.
    let run = runtime(&mission, &vehicle.address, &["--arm"]);
    run.says(
        "pilot: an order to swap that an earlier run has not carried out is dropped",
        SOON,
    );
    let folder = mission.beside("state/swap");
    let left = || fs::read_dir(&folder).unwrap().count();
    eventually(
        SOON,
        || (left() == 1).then_some(()),
        || format!("{} files are left", left()),
    );
}

#[test]
fn a_locked_mission_is_swapped_to_what_was_signed_alone() {
    let mission = mission(180.0);
    let (signed, other) = (second(&mission, "next.wasm"), second(&mission, "other.wasm"));
    let key = |name: &str| mission.beside(name).display().to_string();
    let _ = Backseat::new().arg("key").arg(mission.beside("ann")).run().exit(0);
    let _ = Backseat::new()
        .args(["check", "--signer", "Ann", "--sign", &key("ann.key"), "--may-swap"])
        .arg(format!("pilot={}", signed.display()))
        .args(["--log", &key("logs"), "--state", &key("state")])
        .mission(&mission)
        .run()
        .exit(0);
    let vehicle = Vehicle::start(&mission);
    let run = runtime(&mission, &vehicle.address, &["--arm", "--locked", &key("ann.pub")]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    let refused = swap(&mission, &other).exit(1);
    assert!(refused.stdout.contains("Ann did not sign that "), "{refused}");
    let _ = swap(&mission, &signed).exit(0);
    run.says("pilot: swapped", SOON);
    drop(run);
    // A shadow is code too.
    let shadow = format!("pilot={}", other.display());
    let arguments = ["--locked", &key("ann.pub"), "--shadow", &shadow];
    let mut refused = runtime(&mission, &vehicle.address, &arguments);
    refused.says("Ann did not sign that ", SOON);
    assert_eq!(refused.wait(SOON), Some(2));
}

#[test]
fn a_shadow_is_judged_and_logged_and_nothing_of_it_is_sent() {
    // At 180 degrees the shadow asks for a line around the globe in its fifth step.
    let mission = mission(180.0);
    let vehicle = Vehicle::start(&mission);
    let template = backseat_test_support::plugins().join("template.wasm");
    let shadows = [fickle(), template.clone()].map(|file| format!("pilot={}", file.display()));
    let arguments = [
        "--arm",
        "--first-identifier",
        "1",
        "--shadow",
        &shadows[0],
        "--shadow",
        &shadows[1],
    ];
    let run = runtime(&mission, &vehicle.address, &arguments);
    run.says("shadow of pilot: version 0.2.0", SOON);
    run.says("shadow of pilot: would be rejected: ", SOON);
    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 3, SOON);
    assert!(vehicle.received("BPRTK").is_empty(), "{}", vehicle.story());
    let stderr = {
        let mut run = run;
        run.signal(Signal::INT);
        assert_eq!(run.wait(SOON), Some(0), "{}", run.stderr());
        run.stderr()
    };
    assert!(
        stderr.contains("of which 1 would be refused, 0 failures, 0 steps missed; nothing was sent"),
        "{stderr}"
    );
    let logs: Vec<PathBuf> = fs::read_dir(mission.beside("logs"))
        .unwrap()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    let log = read(&logs[0]).unwrap();
    let asked = log.entries.iter().filter(|entry| {
        let Record::Request(request) = &entry.record else {
            return false;
        };
        request["kind"] == "trackline"
    });
    assert_eq!(asked.count(), 0, "core knows nothing of it");
    let steps = shadow_steps(&logs[0]);
    let of = |sha256: &str| steps.iter().filter(|step| step["sha256"] == sha256).count();
    assert!(of(&hash(&fickle())) > 5, "{steps:?}");
    assert!(of(&hash(&template)) > 5, "{steps:?}");
    let refused: Vec<&Value> = steps
        .iter()
        .filter(|step| step["judged"][0]["allowed"] == false)
        .collect();
    let [refused] = &refused[..] else { panic!("{refused:?}") };
    assert_eq!(refused["requests"][0]["is"], "trackline", "{refused}");
    assert!(
        refused["judged"][0]["refusal"]
            .as_str()
            .unwrap()
            .starts_with("keep-in: "),
        "{refused}"
    );
    let allowed = steps.iter().find(|step| step["judged"][0]["allowed"] == true).unwrap();
    assert!(allowed["judged"][0]["clearance_m"].as_f64().unwrap() > 0.0, "{allowed}");
    let _ = replayed(&logs[0]);
}

#[test]
fn a_shadow_that_fails_troubles_nobody() {
    let mission = mission(90.0);
    let vehicle = Vehicle::start(&mission);
    let shadow = format!("pilot={}", fickle().display());
    let run = runtime(&mission, &vehicle.address, &["--arm", "--shadow", &shadow]);
    run.says("shadow of pilot failed (Trap)", SOON);
    let count = vehicle.received("BPRMB").len();
    let _ = vehicle.receives("BPRMB", count + 4, SOON);
    assert!(vehicle.received("BPEMB").is_empty());
    let (log, _) = ended(&mission, run);
    assert!(worst_gap_s(&log) < 1.5);
    let unknown = Backseat::new()
        .args([
            "run",
            "--connect",
            "127.0.0.1:9",
            "--shadow",
            "nobody=x.wasm",
            "--state",
        ])
        .arg(mission.beside("other"))
        .mission(&mission)
        .run()
        .refusal();
    assert!(unknown.contains("no plugin nobody in the mission"), "{unknown}");
}
