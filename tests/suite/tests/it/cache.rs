//! The cache of compiled plugins, as the user meets it: quicker, and otherwise the same.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use backseat_suite::{Backseat, Behavior, Finished, Mission, Scripted, Signal};
use tempfile::TempDir;

/// Plenty of time.
const SOON: Duration = Duration::from_secs(60);

/// A cache of this test alone, which does not exist at first.
struct Own {
    _folder: TempDir,
    cache: PathBuf,
}

impl Own {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let cache = folder.path().join("users/cache");
        Self { _folder: folder, cache }
    }

    fn command(&self, arguments: &[&str]) -> Backseat {
        Backseat::new().args(arguments).env("BACKSEAT_CACHE", &self.cache)
    }

    fn check(&self, mission: &Mission) -> Finished {
        self.command(&["check"]).mission(mission).run().exit(0)
    }

    fn sim(&self, mission: &Mission) -> Finished {
        self.command(&["sim", "--json"]).mission(mission).run().exit(0)
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.cache).into_iter().flatten();
        entries.flatten().map(|entry| entry.path()).collect()
    }
}

#[track_caller]
fn says(said: &str, part: &str) {
    assert!(said.contains(part), "no {part:?} in:\n{said}");
}

/// What was said on standard error, but for the warnings about the mission's world.
fn told(finished: &Finished) -> Vec<&str> {
    let lines = finished.stderr.lines();
    lines.filter(|line| !line.contains(" WARN world: ")).collect()
}

/// The report without the real time that it took.
fn flown(finished: &Finished) -> serde_json::Value {
    let mut report = finished.json();
    for real_time in ["wall_seconds", "load_seconds"] {
        assert!(report[real_time].is_number(), "{finished}");
        report[real_time] = serde_json::Value::Null;
    }
    report
}

#[test]
fn a_second_start_loads_what_the_first_has_compiled_and_flies_the_same() {
    let (own, mission) = (Own::new(), Mission::steady());
    let without = own
        .command(&["sim", "--json", "--no-cache"])
        .mission(&mission)
        .run()
        .exit(0);
    assert_eq!(own.files(), Vec::<PathBuf>::new(), "--no-cache keeps nothing");
    let first = own.sim(&mission);
    let second = own.sim(&mission);
    for finished in [&without, &first, &second] {
        assert_eq!(told(finished), [""; 0], "{finished}");
        assert_eq!(flown(finished), flown(&without));
    }
    let load_s = |finished: &Finished| finished.json()["load_seconds"].as_f64().unwrap();
    let (compiled_s, cached_s) = (load_s(&first), load_s(&second));
    assert!(
        cached_s < compiled_s / 2.0,
        "{cached_s} s from the cache, {compiled_s} s compiled"
    );
}

#[test]
fn check_says_where_each_plugin_comes_from() {
    let (own, mission) = (Own::new(), Mission::copy("isobath"));
    let place = format!("(cache: {})", own.cache.display());
    for origin in ["compiled now", "from the cache"] {
        let said = own.check(&mission).stdout;
        says(&said, &format!(" KiB, {origin}, a step every "));
        says(&said, &place);
    }
    let said = own
        .command(&["check", "--no-cache"])
        .mission(&mission)
        .run()
        .exit(0)
        .stdout;
    says(&said, " KiB, compiled now, a step every ");
    says(&said, "(no cache)");
    let off = own
        .command(&["check"])
        .env("BACKSEAT_CACHE", "off")
        .mission(&mission)
        .run()
        .exit(0);
    assert_eq!(off.stderr, "", "{off}");
    says(&off.stdout, "(no cache)");
}

#[test]
fn the_dive_loads_what_check_has_compiled() {
    let (own, mission) = (Own::new(), Mission::steady());
    assert_eq!(own.check(&mission).stderr, "");
    let vehicle = Scripted::start(Behavior::default());
    let mut run = own
        .command(&["run", "--connect", &vehicle.address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .spawn();
    run.says("plugins: 1 from the cache, 0 compiled", SOON);
    run.signal(Signal::TERM);
    assert_eq!(run.wait(SOON), Some(0), "{}", run.stderr());
}

#[test]
fn a_file_that_was_damaged_or_that_others_may_write_is_compiled_anew_with_a_line() {
    let (own, mission) = (Own::new(), Mission::steady());
    let good = own.sim(&mission);
    let files = own.files();
    let [file] = &files[..] else { panic!("{files:?}") };
    let mut bytes = fs::read(file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(file, bytes).unwrap();
    let open = |file: &Path| fs::set_permissions(file, fs::Permissions::from_mode(0o660)).unwrap();
    for (change, reason) in [
        (None, "damaged: its BLAKE3 is not the one that it records"),
        (Some(&open), "mode 660, expected 600"),
    ] {
        change.iter().for_each(|change| change(file));
        let finished = own.sim(&mission);
        assert_eq!(flown(&finished), flown(&good));
        let line = format!(
            "cache: {}: {reason}: not loaded; plugin `pilot` is compiled anew\n",
            file.display()
        );
        says(&finished.stderr, &line);
        says(&finished.stderr, "WARN");
        assert_eq!(told(&finished).len(), 1, "{finished}");
        assert_eq!(told(&own.sim(&mission)), [""; 0], "it was replaced");
    }
}

#[test]
fn without_a_place_for_a_cache_a_hint_says_so_once() {
    let (own, mission) = (Own::new(), Mission::steady());
    let nowhere = own.command(&["sim", "--json"]).env("BACKSEAT_CACHE", "");
    let nowhere = nowhere
        .env("XDG_CACHE_HOME", "")
        .env("HOME", "")
        .mission(&mission)
        .run()
        .exit(0);
    says(
        &nowhere.stderr,
        "INFO no cache of compiled plugins: none of BACKSEAT_CACHE, XDG_CACHE_HOME and HOME is set",
    );
    let kernel = own
        .command(&["sim", "--json"])
        .env("BACKSEAT_CACHE", "/proc/nothing/cache");
    let kernel = kernel.mission(&mission).run().exit(0);
    says(
        &kernel.stderr,
        "INFO compiled plugins are not kept: /proc/nothing/cache: ",
    );
    for finished in [nowhere, kernel] {
        assert_eq!(told(&finished).len(), 1, "{finished}");
        assert_eq!(flown(&finished), flown(&own.sim(&mission)));
    }
    let users = own.command(&["sim", "--json"]).env("BACKSEAT_CACHE", "");
    let users = users
        .env("XDG_CACHE_HOME", own.cache.join("xdg"))
        .mission(&mission)
        .run()
        .exit(0);
    assert_eq!(told(&users), [""; 0]);
    assert_eq!(fs::read_dir(own.cache.join("xdg/backseat")).unwrap().count(), 1);
}

#[test]
fn a_full_disk_keeps_nothing_and_a_hint_says_so() {
    let (own, mission) = (Own::new(), Mission::steady());
    let full = own
        .command(&["sim", "--json"])
        .mission(&mission)
        .file_max_kib(64)
        .run()
        .exit(0);
    says(&full.stderr, "INFO compiled plugins are not kept: ");
    says(&full.stderr, "File too large");
    assert_eq!(told(&full).len(), 1, "{full}");
    assert_eq!(own.files(), Vec::<PathBuf>::new(), "no draft is left");
    assert_eq!(flown(&full), flown(&own.sim(&mission)));
}

#[test]
fn processes_that_start_at_once_do_not_disturb_each_other() {
    let (own, mission) = (Own::new(), Mission::copy("isobath"));
    let starts = || own.command(&["check"]).mission(&mission).spawn();
    for mut process in [starts(), starts(), starts()] {
        assert_eq!(process.wait(SOON), Some(0), "{}", process.stderr());
        assert_eq!(process.stderr(), "");
        says(&process.stdout(), "\nready\n");
    }
    assert_eq!(own.files().len(), 1);
    says(&own.check(&mission).stdout, " KiB, from the cache, a step every ");
}
