//! `new`, `build` and `test`.

use std::fs;
use std::path::Path;
use std::time::Duration;

use backseat_suite::{Backseat, Finished, Process};

use super::{kit, plugin, target};

/// How long the first build of the SDK may take on a busy computer.
const BUILT_WITHIN: Duration = Duration::from_secs(280);

/// The folders in a place, without hidden ones.
fn folders(place: &Path) -> Vec<String> {
    let entries = fs::read_dir(place).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn ended(mut process: Process) -> Finished {
    Finished {
        code: process.wait(BUILT_WITHIN),
        stdout: process.stdout(),
        stderr: process.stderr(),
    }
}

/// With the tutorial's, the only test that compiles the SDK. What it compiles is kept in the target folder for the next
/// time.
#[test]
fn a_new_plugin_passes_its_tests_and_flies_and_one_that_is_wrong_does_not() {
    let place = tempfile::tempdir().unwrap();
    let (target, kit) = (target(), kit());
    let run = |folder: &Path, arguments: &[&str]| {
        let command = plugin(folder, arguments)
            .env("BACKSEAT_KIT", &kit)
            .env("CARGO_TARGET_DIR", &target)
            // Everything is in the registry's cache already, in the versions of the new plugin's Cargo.lock.
            .env("CARGO_NET_OFFLINE", "true");
        ended(command.spawn())
    };
    let made = run(place.path(), &["new", "drift"]).exit(0);
    assert!(made.stdout.contains("cd drift && backseat plugin test"), "{made}");
    let folder = place.path().join("drift");
    let lock = fs::read_to_string(folder.join("Cargo.lock")).unwrap();

    let tested = run(&folder, &["test"]).exit(0);
    assert!(tested.stdout.contains("test result: ok. 3 passed"), "{tested}");
    assert!(tested.stdout.contains("built drift.wasm: "), "{tested}");
    for seed in 1..=5 {
        let flown = format!("mission, seed {seed}: completed after ");
        let line = tested
            .stdout
            .lines()
            .find(|line| line.starts_with(&flown))
            .unwrap_or_else(|| panic!("{tested}"));
        assert!(line.ends_with("all expectations met"), "{line}");
    }
    let last = tested.stdout.lines().last().unwrap();
    assert_eq!(last, "drift: unit tests passed, 5 of 5 flights met what is expected");

    // Cargo may leave out what only other crates need, and changes no version.
    let packages = |lock: &str| -> Vec<String> {
        let packages = lock.split("[[package]]").skip(1);
        packages
            .map(|package| package.lines().skip(1).take(2).collect::<Vec<_>>().join(" "))
            .collect()
    };
    let used = packages(&fs::read_to_string(folder.join("Cargo.lock")).unwrap());
    let given = packages(&lock);
    let new: Vec<&String> = used.iter().filter(|package| !given.contains(package)).collect();
    assert_eq!(new, [""; 0], "of {} packages", used.len());
    assert!(used.len() > 20, "{used:?}");

    let inspected = run(&folder, &["inspect", "--json"]).exit(0).json();
    assert_eq!(inspected["file"], "drift.wasm");
    assert_eq!(inspected["description"]["name"], "drift");
    assert_eq!(inspected["wasi"].as_array().map(Vec::len), Some(0));
    let checked = run(place.path(), &["check", "drift", "--seeds", "1"]).exit(0);
    assert!(
        checked.stdout.contains(inspected["sha256"].as_str().unwrap()),
        "{checked}"
    );

    let source = folder.join("src/lib.rs");
    let text = fs::read_to_string(&source).unwrap();
    // A plugin that panics before it can say anything about itself.
    let describe = "fn describe() -> Description {";
    let panics = format!("{describe}\n        assert!(std::hint::black_box(false), \"no name yet\");");
    fs::write(&source, text.replace(describe, &panics)).unwrap();
    let _built = run(&folder, &["build"]).exit(0);
    let undescribed = run(&folder, &["inspect"]).exit(1);
    assert!(undescribed.stdout.contains("no name yet"), "{undescribed}");

    // A plugin that panics, although its mission expects nothing about that.
    let panics = "self.tag += 1;\n        assert!(self.tag != 50, \"the fiftieth request\");";
    fs::write(&source, text.replace("self.tag += 1;", panics)).unwrap();
    let panicked = run(&folder, &["test", "--seeds", "1"]).exit(1);
    assert!(
        panicked.stdout.contains("; NOT MET: plugin drift failed once, at "),
        "{panicked}"
    );
    assert!(panicked.stdout.contains("the fiftieth request"), "{panicked}");
    assert!(panicked.stdout.contains("0 of 1 flights"), "{panicked}");
    fs::write(&source, text).unwrap();

    // Who changed a source and did not build again flies the old component, and hears it.
    let program = |arguments: &[&str]| {
        ended(
            Backseat::new()
                .args(arguments.iter().copied())
                .in_folder(&folder)
                .spawn(),
        )
    };
    let fly = || program(&["sim", "mission", "--log", "out.mcap"]);
    let old = fly().exit(0);
    let says = "src/lib.rs: `backseat plugin build` makes it anew";
    assert!(
        old.stderr.contains("drift.wasm is older than ") && old.stderr.contains(says),
        "{old}"
    );
    assert!(old.stdout.contains("the fiftieth request"), "{old}");
    let again = program(&["replay", "out.mcap", "--plugin", "drift=drift.wasm"]).exit(0);
    assert!(again.stderr.contains(says), "{again}");
    let none = program(&["replay", "out.mcap", "--plugin", "drafted=drift.wasm"]).exit(2);
    assert!(
        none.stderr.contains("\nerror: --plugin drafted: the run had no plugin"),
        "{none}"
    );
    // After the dive the report says where the plugin panicked, as the simulation did.
    let report = program(&["log", "report", "out.mcap"]).exit(0);
    let trouble = report.stdout.lines().find(|line| line.contains("drift failed (Trap)"));
    let told = "drift failed (Trap): panicked at src/lib.rs:";
    assert!(
        trouble.is_some_and(|line| line.contains(told) && line.contains("the fiftieth request")),
        "{report}"
    );
    let _ = run(&folder, &["build"]).exit(0);
    let new = fly().exit(0);
    assert!(!new.stderr.contains("is older than"), "{new}");

    // What is expected and does not happen.
    let world = folder.join("mission/world.toml");
    let text = fs::read_to_string(&world).unwrap();
    fs::write(&world, text.replace("min_accepted = 10", "min_accepted = 100000")).unwrap();
    let unmet = run(&folder, &["test", "--seeds", "2"]).exit(1);
    assert_eq!(unmet.stdout.matches("; NOT MET: ").count(), 2, "{unmet}");
    assert!(unmet.stdout.contains("0 of 2 flights"), "{unmet}");

    // A mission that flies another component.
    let mission = folder.join("mission/mission.toml");
    let text = fs::read_to_string(&mission).unwrap();
    fs::write(&mission, text.replace("../drift.wasm", "template")).unwrap();
    let other = run(&folder, &["test"]).exit(2);
    assert!(other.stderr.contains("component = \"../drift.wasm\""), "{other}");

    // A component that the mission beside it does not fly.
    fs::write(&mission, text.replace("../drift.wasm", "../draft.wasm")).unwrap();
    let checked = run(&folder, &["check", "--seeds", "1"]).exit(1);
    let remark = "mission.toml: no plugin has component = \"../drift.wasm\"";
    assert!(checked.stdout.contains(remark), "{checked}");

    // A test that does not compile.
    let source = folder.join("src/lib.rs");
    let code = fs::read_to_string(&source).unwrap();
    fs::write(&source, format!("{code}\nlet")).unwrap();
    let uncompiled = run(&folder, &["test"]).exit(2);
    let last = uncompiled.stderr.lines().last().unwrap();
    assert_eq!(
        last,
        "error: .: the plugin or its unit tests do not compile: the compiler's lines above say why"
    );
    fs::write(&source, code).unwrap();

    // A unit test that fails.
    let source = folder.join("src/lib.rs");
    let text = fs::read_to_string(&source).unwrap();
    fs::write(
        &source,
        text.replace("modify.heading == 90.0", "modify.heading == 91.0"),
    )
    .unwrap();
    let failed = run(&folder, &["test"]).exit(1);
    assert!(failed.stdout.contains("the unit tests failed"), "{failed}");
    assert!(!failed.stdout.contains("seed 1"), "{failed}");
    let stale = run(place.path(), &["inspect", "drift"]).exit(0);
    assert!(
        stale.stderr.contains("drift/drift.wasm is older than drift/src/lib.rs"),
        "{stale}"
    );

    // Code that does not compile.
    fs::write(&source, "backseat_sdk::export!(Nothing);\n").unwrap();
    let broken = run(&folder, &["build"]).exit(2);
    let last = broken.stderr.lines().last().unwrap();
    assert_eq!(
        last, "error: .: cargo build failed (exit status: 101): its lines above say why",
        "{broken}"
    );
}

#[test]
fn a_bad_name_and_a_folder_that_exists_are_refused_in_a_line() {
    let place = tempfile::tempdir().unwrap();
    for (name, why) in [
        (
            "Drift",
            "\"Drift\" cannot be the name of a plugin: expected a letter of a-z",
        ),
        ("../up", "cannot be the name"),
        ("serde", "plugins are built with a crate called serde"),
        ("match", "Rust or Cargo uses it itself"),
    ] {
        let line = plugin(place.path(), &["new", name]).run().refusal();
        assert!(line.contains(why), "{line}");
    }
    fs::create_dir(place.path().join("drift")).unwrap();
    let line = plugin(place.path(), &["new", "drift"]).run().refusal();
    assert_eq!(
        line,
        "error: ./drift: exists already: choose another name, or remove it"
    );
    assert_eq!(folders(place.path()), ["drift"]);
    assert_eq!(folders(&place.path().join("drift")), [""; 0]);
}

#[test]
fn the_kit_is_unpacked_into_the_users_data_and_repaired() {
    let place = tempfile::tempdir().unwrap();
    let data = place.path().join("data");
    let new = |name: &str| {
        let made = plugin(place.path(), &["new", name])
            .env("XDG_DATA_HOME", &data)
            .run()
            .exit(0);
        assert_eq!(made.stderr, "", "{made}");
    };
    new("first");
    let kits = data.join("backseat/kit");
    let [version] = &folders(&kits)[..] else {
        panic!("{:?}", folders(&kits));
    };
    assert!(
        version.starts_with(concat!(env!("CARGO_PKG_VERSION"), "-")),
        "{version}"
    );
    let manifest = fs::read_to_string(place.path().join("first/Cargo.toml")).unwrap();
    let sdk = kits.join(version).join("plugins/sdk");
    assert!(
        manifest.contains(&format!("path = \"{}\"", sdk.display())),
        "{manifest}"
    );
    let file = sdk.join("src/lib.rs");
    let whole = fs::read(&file).unwrap();
    fs::write(&file, "damaged").unwrap();
    new("second");
    assert_eq!(fs::read(&file).unwrap(), whole);
    assert_eq!(folders(&kits), std::slice::from_ref(version));

    let nowhere = plugin(place.path(), &["new", "third"]).env("BACKSEAT_KIT", "/dev/null/kit");
    let line = nowhere.run().refusal();
    assert!(
        line.contains("/dev/null/kit") && line.contains("set BACKSEAT_KIT"),
        "{line}"
    );
    assert_eq!(folders(place.path()), ["data", "first", "second"]);
}

#[test]
fn two_may_make_plugins_at_once() {
    let place = tempfile::tempdir().unwrap();
    let kit = place.path().join("kit");
    let names = ["one", "two", "three", "same", "same", "same"];
    let all = names.map(|name| plugin(place.path(), &["new", name]).env("BACKSEAT_KIT", &kit).spawn());
    let codes = all.map(|process| ended(process).code);
    assert_eq!(codes[..3], [Some(0); 3]);
    let mut same = codes[3..].to_vec();
    same.sort();
    assert_eq!(same, [Some(0), Some(2), Some(2)], "one of them makes it");
    assert_eq!(folders(place.path()), ["kit", "one", "same", "three", "two"]);
    assert_eq!(folders(&kit).len(), 1);
}

#[test]
fn a_missing_toolchain_is_one_line_that_says_what_to_run() {
    let place = tempfile::tempdir().unwrap();
    let kit = place.path().join("kit");
    let run = |folder: &Path, arguments: &[&str]| plugin(folder, arguments).env("BACKSEAT_KIT", &kit);
    let _made = run(place.path(), &["new", "drift"]).run().exit(0);
    let folder = place.path().join("drift");
    for command in ["build", "test"] {
        let without = run(&folder, &[command])
            .env("CARGO", "/nowhere/cargo")
            .env("RUSTC", "/nowhere/rustc");
        let line = without.run().refusal();
        assert!(
            line.contains("does not start") && line.contains("https://rustup.rs"),
            "{line}"
        );
    }
    // A compiler without the target.
    let rustc = place.path().join("rustc");
    fs::write(&rustc, "#!/bin/sh\necho /nowhere\n").unwrap();
    fs::set_permissions(&rustc, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let line = run(&folder, &["build"]).env("RUSTC", rustc).run().refusal();
    assert!(
        line.contains("run `rustup target add wasm32-unknown-unknown`"),
        "{line}"
    );

    let line = run(place.path(), &["build"]).run().refusal();
    assert!(
        line.contains("no Cargo.toml or pyproject.toml here") && line.contains("backseat plugin new"),
        "{line}"
    );
    // The tests of `plugins/python` build a plugin in Python; here is none that could.
    let made = run(place.path(), &["new", "snake", "--lang", "python"]).run().exit(0);
    assert!(made.stdout.contains("snake/plugin.py"), "{made}");
    for command in ["build", "test"] {
        let without = run(&place.path().join("snake"), &[command]).env("PYTHON", "/nowhere/python");
        let line = without.run().refusal();
        assert!(
            line.contains("/nowhere/python does not start")
                && line.contains("install Python 3.11 or later, or set PYTHON"),
            "{line}"
        );
    }
    for command in ["inspect", "check"] {
        let line = run(place.path(), &[command, "drift"]).run().refusal();
        assert_eq!(
            line,
            "error: drift/drift.wasm: not built yet: run `backseat plugin build drift`"
        );
    }
}
