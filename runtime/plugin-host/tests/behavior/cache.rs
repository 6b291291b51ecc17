//! Compiled plugins in a cache: what is loaded from it, and everything that is not.

use std::fs::{self, File, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, UNIX_EPOCH};

use backseat_core::plugin::Returned;
use backseat_plugin_host::{Budget, Cache, Component, Host, Notice, Origin, ROOM_BYTES};
use tempfile::TempDir;

use crate::fixture::{Latitude, brief, components, input};

/// A cache in a folder of its own.
struct Trial {
    folder: TempDir,
    notices: Arc<Mutex<Vec<Notice>>>,
}

impl Trial {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            notices: Arc::default(),
        }
    }

    /// The cache's folder, which does not exist at first.
    fn cache(&self) -> PathBuf {
        self.folder.path().join("cache")
    }

    /// A host as in a new process.
    fn host_in(&self, cache: &Path, room: u64) -> Host {
        let notices = Arc::clone(&self.notices);
        let cache = Cache::with_room(cache, room, move |notice| notices.lock().unwrap().push(notice));
        Host::new().unwrap().with_cache(Some(cache))
    }

    fn host(&self) -> Host {
        self.host_in(&self.cache(), ROOM_BYTES)
    }

    fn load(&self) -> Component {
        self.host().load("plugin", &components().template_bytes).unwrap()
    }

    /// Loads the template as a new process does, and says where it came from and what was said.
    fn origin(&self) -> (Origin, Vec<Notice>) {
        let origin = self.load().origin();
        (origin, self.notices())
    }

    fn notices(&self) -> Vec<Notice> {
        std::mem::take(&mut *self.notices.lock().unwrap())
    }

    /// The file of the template, after it has been compiled.
    fn filled(&self) -> PathBuf {
        assert_eq!(self.origin(), (Origin::Compiled, vec![]));
        let [file] = &self.files()[..] else {
            panic!("{:?}", self.files())
        };
        file.clone()
    }

    fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = fs::read_dir(self.cache())
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        files
    }

    /// Requires that the file of the template is not loaded for this reason, and is good again afterwards.
    #[track_caller]
    fn refuses(&self, file: &Path, reason: &str) {
        let (origin, notices) = self.origin();
        let expected = format!(
            "cache: {}: {reason}: not loaded; plugin `plugin` is compiled anew",
            file.display()
        );
        assert_eq!((origin, notices), (Origin::Compiled, vec![Notice::Odd(expected)]));
        assert_eq!(self.origin(), (Origin::Cache, vec![]), "it was replaced");
    }

    /// Requires that a cache in this folder is not used for this reason, that it is said once, and that plugins load.
    #[track_caller]
    fn does_without(&self, folder: &Path, notice: &Notice) {
        let host = self.host_in(folder, ROOM_BYTES);
        for bytes in [&components().template_bytes, &other()] {
            assert_eq!(host.load("plugin", bytes).unwrap().origin(), Origin::Compiled);
        }
        assert_eq!(self.notices(), std::slice::from_ref(notice));
    }
}

fn other() -> Vec<u8> {
    fs::read(backseat_test_support::plugins().join("echo.wasm")).unwrap()
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
}

fn mode(path: &Path) -> u32 {
    fs::symlink_metadata(path).unwrap().mode() & 0o7777
}

fn is_root() -> bool {
    fs::metadata("/proc/self").unwrap().uid() == 0
}

/// What the template does in twenty steps, with the fuel of each.
fn flown(component: &Component) -> Vec<Returned> {
    let config = r#"{"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}"#;
    let mut plugin = component
        .start(Budget::default(), &brief(config), Arc::new(Latitude))
        .unwrap()
        .plugin;
    (0..20).map(|second| plugin.step(&input(second))).collect()
}

#[test]
fn a_second_process_loads_what_the_first_has_compiled_and_does_the_same() {
    let trial = Trial::new();
    let first = trial.load();
    let second = trial.load();
    assert_eq!((first.origin(), second.origin()), (Origin::Compiled, Origin::Cache));
    assert_eq!(trial.notices(), []);
    let without = Host::new()
        .unwrap()
        .load("plugin", &components().template_bytes)
        .unwrap();
    assert_eq!(flown(&first), flown(&second));
    assert_eq!(flown(&without), flown(&second));
    assert!(flown(&second).iter().all(|returned| returned.result.is_ok()));
}

#[test]
fn what_is_loaded_is_a_sealed_file_in_memory() {
    let trial = Trial::new();
    let _file = trial.filled();
    let loaded = trial.load();
    assert_eq!(loaded.origin(), Origin::Cache);
    let maps = fs::read_to_string("/proc/self/maps").unwrap();
    let code = |line: &str| line.contains("memfd:backseat-plugin") && line.contains(" r-xp ");
    assert!(maps.lines().any(code), "{maps}");
    let _ = flown(&loaded);
}

#[test]
fn folder_and_file_are_the_users_alone() {
    let trial = Trial::new();
    let file = trial.filled();
    assert_eq!((mode(&trial.cache()), mode(&file)), (0o700, 0o600));
}

#[test]
fn only_plugins_are_kept() {
    let trial = Trial::new();
    let bare = wat::parse_str("(component)").unwrap();
    assert!(trial.host().load("plugin", &bare).is_err());
    assert!(
        trial
            .host()
            .load("plugin", &components().template_bytes[..1000])
            .is_err()
    );
    assert!(!trial.cache().exists());
}

#[test]
fn the_bounds_of_a_component_hold_for_one_in_the_cache() {
    let trial = Trial::new();
    trial.filled();
    let bytes = &components().template_bytes;
    let refused = trial
        .host()
        .load_within("plugin", bytes, bytes.len() - 1, Duration::from_secs(60));
    let expected = format!("plugin: {} bytes, expected at most {}", bytes.len(), bytes.len() - 1);
    assert_eq!(refused.err().unwrap().to_string(), expected);
}

#[test]
fn a_flipped_byte_anywhere_is_noticed() {
    let trial = Trial::new();
    let file = trial.filled();
    let whole = fs::read(&file).unwrap();
    let host = trial.host();
    // A place in each field of the header, and three in the artefact. (Unit tests of the format flip each bit.)
    for at in [3, 9, 20, 60, 80, 100, 116, whole.len() / 2, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        fs::write(&file, &damaged).unwrap();
        assert_eq!(
            host.load("plugin", &components().template_bytes).unwrap().origin(),
            Origin::Compiled,
            "{at}"
        );
        assert_eq!(trial.notices().len(), 1, "{at}");
        assert_eq!(fs::read(&file).unwrap(), whole, "it was replaced by the same");
    }
}

#[test]
fn a_damaged_or_truncated_file_is_compiled_anew() {
    let trial = Trial::new();
    let file = trial.filled();
    let whole = fs::read(&file).unwrap();
    let write = |bytes: &[u8]| fs::write(&file, bytes).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    write(&damaged);
    trial.refuses(&file, "damaged: its BLAKE3 is not the one that it records");
    write(&whole[..whole.len() / 2]);
    let (records, has) = (whole.len() - 116, whole.len() / 2 - 116);
    trial.refuses(&file, &format!("records {records} bytes, and has {has}"));
    write(&whole[..50]);
    trial.refuses(&file, "cut short");
    write(b"");
    trial.refuses(&file, "cut short");
    write(&vec![0; whole.len()]);
    trial.refuses(&file, "not a compiled plugin");
    // What the engine would load by itself, without our header.
    write(&whole[116..]);
    trial.refuses(&file, "not a compiled plugin");
}

#[test]
fn the_artefact_of_another_plugin_is_not_loaded_under_this_name() {
    let trial = Trial::new();
    let file = trial.filled();
    trial.host().load("plugin", &other()).unwrap();
    let others = trial.files().into_iter().find(|path| *path != file).unwrap();
    fs::copy(&others, &file).unwrap();
    trial.refuses(&file, "compiled from another plugin");
}

#[test]
fn a_file_of_another_version_or_engine_is_not_loaded() {
    let trial = Trial::new();
    let file = trial.filled();
    let change = |at: usize| {
        let mut bytes = fs::read(&file).unwrap();
        bytes[at] = bytes[at].wrapping_add(1);
        fs::write(&file, bytes).unwrap();
    };
    change(8);
    trial.refuses(&file, "format 3, expected 2");
    change(44);
    trial.refuses(&file, "compiled by another engine, or with other settings");
    // Another engine has another name.
    let name = file.file_name().unwrap().to_str().unwrap().to_owned();
    let elsewhere = file.with_file_name(name.replace(".v2", ".v3"));
    fs::rename(&file, &elsewhere).unwrap();
    assert_eq!(trial.origin(), (Origin::Compiled, vec![]));
}

#[test]
fn a_file_that_others_may_have_written_is_not_loaded() {
    let trial = Trial::new();
    let file = trial.filled();
    for (given, told) in [
        (0o660, "660"),
        (0o644, "644"),
        (0o602, "602"),
        (0o4600, "4600"),
        (0o400, "400"),
    ] {
        set_mode(&file, given);
        trial.refuses(&file, &format!("mode {told}, expected 600"));
        assert_eq!(mode(&file), 0o600);
    }
    if is_root() {
        std::os::unix::fs::chown(&file, Some(12_345), None).unwrap();
        trial.refuses(&file, "it belongs to user 12345, and this program runs as user 0");
    }
}

#[test]
fn a_link_or_a_pipe_in_the_place_of_a_file_is_not_followed() {
    let trial = Trial::new();
    let file = trial.filled();
    let elsewhere = trial.folder.path().join("elsewhere");
    fs::rename(&file, &elsewhere).unwrap();
    let whole = fs::read(&elsewhere).unwrap();
    // Its target would pass every other check.
    symlink(&elsewhere, &file).unwrap();
    trial.refuses(&file, "a link");
    assert!(!file.is_symlink());
    assert_eq!(fs::read(&elsewhere).unwrap(), whole, "nothing is written through it");
    fs::remove_file(&file).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&file).status().unwrap();
    assert!(made.success());
    trial.refuses(&file, "not a regular file");
}

#[test]
fn a_folder_in_the_place_of_a_file_costs_time_only() {
    let trial = Trial::new();
    let file = trial.filled();
    fs::remove_file(&file).unwrap();
    fs::create_dir(&file).unwrap();
    let (origin, notices) = trial.origin();
    assert_eq!(origin, Origin::Compiled);
    let [Notice::Odd(odd), Notice::Unusable(unusable)] = &notices[..] else {
        panic!("{notices:?}")
    };
    assert!(odd.contains("not a regular file"), "{odd}");
    assert!(unusable.starts_with("compiled plugins are not kept: "), "{unusable}");
    assert_eq!(trial.files(), [file], "no draft is left");
}

#[test]
fn a_folder_that_others_may_use_or_that_is_a_link_is_not_used() {
    let trial = Trial::new();
    trial.filled();
    let cache = trial.cache();
    let odd = |path: &Path, reason: &str| {
        let what = format!(
            "no cache of compiled plugins: {}: {reason}; each start compiles them",
            path.display()
        );
        Notice::Odd(what)
    };
    let others = "gives others access, expected 700: look who wrote what is in it, then `chmod 700` it";
    for given in [0o770, 0o705] {
        set_mode(&cache, given);
        trial.does_without(&cache, &odd(&cache, &format!("mode {given:03o} {others}")));
    }
    set_mode(&cache, 0o700);
    let link = trial.folder.path().join("link");
    symlink(&cache, &link).unwrap();
    // A slash at the end would have the kernel follow it.
    for path in [link.clone(), link.join("")] {
        trial.does_without(&path, &odd(&link, "a link, expected a folder: name the folder itself"));
    }
    if is_root() {
        std::os::unix::fs::chown(&cache, Some(12_345), None).unwrap();
        let reason = "it belongs to user 12345, and this program runs as user 0";
        let Notice::Odd(text) = odd(&cache, reason) else {
            unreachable!()
        };
        trial.does_without(&cache, &Notice::Unusable(text));
    }
}

#[test]
fn a_place_that_cannot_be_a_folder_costs_one_hint() {
    let trial = Trial::new();
    let file = trial.folder.path().join("file");
    File::create(&file).unwrap();
    let below = file.join("cache");
    let what = format!(
        "no cache of compiled plugins: {}: Not a directory (os error 20); each start compiles them",
        below.display()
    );
    trial.does_without(&below, &Notice::Unusable(what));
    // Nothing can be created here, whoever asks.
    let kernel = Path::new("/proc/backseat/cache");
    let what = "compiled plugins are not kept: /proc/backseat/cache: No such file or directory (os error 2); the next \
                start compiles them again";
    trial.does_without(kernel, &Notice::Unusable(what.to_owned()));
}

#[test]
fn what_was_used_least_recently_makes_room_and_a_file_of_somebody_else_never_does() {
    let trial = Trial::new();
    let file = trial.filled();
    let bytes = fs::metadata(&file).unwrap().len();
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let with = |name: &str, used_s: u64| {
        let path = trial.cache().join(name);
        fs::write(&path, vec![0; usize::try_from(bytes).unwrap()]).unwrap();
        let used = UNIX_EPOCH + Duration::from_secs(used_s);
        File::options()
            .write(true)
            .open(&path)
            .unwrap()
            .set_modified(used)
            .unwrap();
        path
    };
    let older = with(&name(&file).replace(&name(&file)[9..13], "0000"), 1000);
    let version = with(&name(&file).replace(".v2", ".v7"), 2_000_000_000);
    let dead = with("backseat-draft-1-0", 1000);
    let foreign = with("thesis.tex", 10);
    // Reading it makes it the newest.
    File::options()
        .write(true)
        .open(&file)
        .unwrap()
        .set_modified(UNIX_EPOCH)
        .unwrap();
    assert_eq!(trial.origin(), (Origin::Cache, vec![]));
    // Just enough for both.
    let another = Trial::new();
    another.host().load("plugin", &other()).unwrap();
    let room = bytes + fs::metadata(&another.files()[0]).unwrap().len();
    assert_eq!(
        trial
            .host_in(&trial.cache(), room)
            .load("plugin", &other())
            .unwrap()
            .origin(),
        Origin::Compiled
    );
    assert_eq!(trial.notices(), []);
    for (path, stays) in [
        (&file, true),
        (&older, false),
        (&version, false),
        (&dead, false),
        (&foreign, true),
    ] {
        assert_eq!(path.exists(), stays, "{}", path.display());
    }
    // What has no room at all is not kept, and nothing goes for it.
    let small = Trial::new();
    let component = small.host_in(&small.cache(), 1 << 10).load("plugin", &other()).unwrap();
    assert_eq!(component.origin(), Origin::Compiled);
    let [Notice::Unusable(text)] = &small.notices()[..] else {
        panic!()
    };
    assert!(
        text.contains("it has room for 0 MiB, and a compiled plugin has"),
        "{text}"
    );
    assert_eq!(small.files(), Vec::<PathBuf>::new());
}

#[test]
fn several_at_once_in_one_folder_do_not_disturb_each_other() {
    let trial = Trial::new();
    let bytes = &components().template_bytes;
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| trial.host().load("plugin", bytes).unwrap());
        }
    });
    assert_eq!(trial.notices(), []);
    assert_eq!(trial.files().len(), 1);
    assert_eq!(trial.origin(), (Origin::Cache, vec![]));
}
