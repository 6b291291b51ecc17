//! State that outlives the process: the reserved SPI identifiers and inserts of the vehicle's mission, and the
//! operator's hold.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use backseat_core::{Identifiers, Operator, Reservation};
use backseat_mission::Mission;

use crate::owner::{explained, not_made};

/// The name of the file that is locked.
const LOCK: &str = "lock";
/// The name of a file that is made and removed, to see whether that works.
const PROBE: &str = "probe";
/// The name of the record.
const IDENTIFIERS: &str = "identifiers";
/// The name of the file that holds the vehicle's name.
const VEHICLE: &str = "vehicle";

pub(crate) struct State {
    folder: PathBuf,
    /// Locked while this process lives, however it ends: two processes that read one record would use the same numbers.
    _lock: fs::File,
    is_new: bool,
}

impl State {
    /// The folder for the state of a mission's vehicle: the given one, or one of the vehicle's name in the user's state
    /// folder. It does not depend on the mission's name, because the vehicle must never see an identifier twice,
    /// whatever the mission's folder is called.
    pub(crate) fn folder_of(folder: Option<&Path>, mission: &Mission) -> Result<PathBuf> {
        match (folder, &mission.file.vehicle.name) {
            (Some(folder), _) => Ok(folder.to_path_buf()),
            (None, Some(vehicle)) => {
                let users = user_state_folder()?.join("backseat");
                let folder = users.join("vehicles").join(vehicle);
                let before = users.join(&mission.name);
                if !folder.join(IDENTIFIERS).exists() && before.join(IDENTIFIERS).exists() {
                    bail!(
                        "{}: an earlier version kept this mission's state in this folder, under the mission's name. \
                         If it belongs to the vehicle `{vehicle}`, move it: mkdir -p {}, mv {} {}, echo {vehicle} > {}",
                        before.display(),
                        users.join("vehicles").display(),
                        before.display(),
                        folder.display(),
                        folder.join(VEHICLE).display()
                    );
                }
                Ok(folder)
            }
            (None, None) => bail!(
                "mission.toml: vehicle.name is missing: it names the folder for the vehicle's identifiers and the \
                 operator's hold; set it, or give a folder with --state DIR"
            ),
        }
    }

    /// Opens the state of the vehicle `vehicle` in a folder. Refused are a folder that belongs to another vehicle, one
    /// that belongs to a vehicle while the mission names none, and one with a record that belongs to no vehicle.
    pub(crate) fn open(folder: &Path, vehicle: Option<&str>) -> Result<Self> {
        let folder = folder.to_path_buf();
        fs::create_dir_all(&folder).map_err(|error| not_made(&folder, error))?;
        let path = folder.join(LOCK);
        let is_new = !path.exists();
        let lock = fs::File::create(&path).map_err(|error| explained(&path, error))?;
        match lock.try_lock() {
            Ok(()) => {
                // What is there may be open to us although nothing can be added: no hold would be kept.
                let probe = folder.join(PROBE);
                let added = fs::File::create(&probe).and_then(|_| fs::remove_file(&probe));
                added.map_err(|error| {
                    explained(&probe, error).context(format!("{}: it could keep no hold", folder.display()))
                })?;
                let state = Self {
                    folder,
                    _lock: lock,
                    is_new,
                };
                state.claim(vehicle)?;
                Ok(state)
            }
            Err(fs::TryLockError::WouldBlock) => bail!(
                "{}: another runtime uses this folder, so it may be steering the vehicle: stop that runtime first",
                folder.display()
            ),
            Err(fs::TryLockError::Error(error)) => Err(error).with_context(|| format!("{}", path.display())),
        }
    }

    /// Whether no run has used the folder before: then a hold or identifiers that an earlier run kept elsewhere are not known.
    pub(crate) const fn is_new(&self) -> bool {
        self.is_new
    }

    /// The files that a run of a folder writes.
    pub(crate) fn files(folder: &Path) -> [PathBuf; 4] {
        [LOCK, VEHICLE, IDENTIFIERS, "hold"].map(|name| folder.join(name))
    }

    /// Whether a runtime uses a folder.
    pub(crate) fn is_in_use(folder: &Path) -> Result<bool> {
        let path = folder.join(LOCK);
        let lock = match fs::File::open(&path) {
            Ok(lock) => lock,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(false),
            Err(error) => return Err(explained(&path, error)),
        };
        Ok(matches!(lock.try_lock_shared(), Err(fs::TryLockError::WouldBlock)))
    }

    /// Makes sure that the folder belongs to this vehicle.
    fn claim(&self, vehicle: Option<&str>) -> Result<()> {
        let path = self.folder.join(VEHICLE);
        let says = match fs::read_to_string(&path) {
            Ok(says) => Some(says.trim().to_owned()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
            Err(error) => return Err(explained(&path, error)),
        };
        match (vehicle, says) {
            (None, None) => Ok(()),
            (Some(vehicle), Some(says)) if vehicle == says => Ok(()),
            (Some(vehicle), Some(says)) => bail!(
                "{}: this folder belongs to the vehicle `{says}`, but the mission is for `{vehicle}` \
                 (vehicle.name): choose a folder of this vehicle with --state DIR",
                self.folder.display()
            ),
            (None, Some(says)) => bail!(
                "{}: this folder belongs to the vehicle `{says}`, but the mission names no vehicle: set vehicle.name \
                 in mission.toml",
                self.folder.display()
            ),
            (Some(vehicle), None) if self.identifiers_path().exists() => bail!(
                "{}: an earlier version has left a record of identifiers here that does not name its vehicle. If it \
                 belongs to `{vehicle}`: echo {vehicle} > {}",
                self.folder.display(),
                path.display()
            ),
            (Some(vehicle), None) => self.write(VEHICLE, format!("{vehicle}\n").as_bytes()),
        }
    }

    /// The identifiers that may be used: all from the recorded number on, or from `first` on if there is no record yet.
    /// `None` without either: then no insert is sent, because a number might be used twice. Nothing is written, so that a
    /// start that fails after this has begun no record: [`State::begin_record`] does that.
    pub(crate) fn identifiers(&self, first: Option<u32>) -> Result<Option<Identifiers>> {
        let path = self.identifiers_path();
        match (fs::read_to_string(&path), first) {
            (Ok(text), None) => {
                let Some(identifiers) = identifiers(&text) else {
                    bail!(
                        "{}: expected a number above 0, alone or followed by three (the mission's first identifier, \
                         inserts, GPS hits), found {:?}: write into it a number above all that were used in this mission \
                         of the vehicle",
                        path.display(),
                        text.trim()
                    );
                };
                Ok(Some(identifiers))
            }
            (Ok(text), Some(first)) => {
                let reached = identifiers(&text).map_or_else(
                    || format!("cannot be read ({:?})", text.trim()),
                    |record| {
                        format!(
                            "says that the next identifier is {} (the first was {}; {} inserts and {} GPS hits may \
                             have been sent)",
                            record.next, record.first, record.inserts, record.gps_hits
                        )
                    },
                );
                bail!(
                    "{}: a record exists already and {reached}; omit --first-identifier {first}, or delete the file \
                     if this is another mission of the vehicle",
                    path.display()
                );
            }
            (Err(error), Some(first)) if error.kind() == std::io::ErrorKind::NotFound => Ok(Some(Identifiers {
                next: first,
                reserved: first,
                first,
                ..Identifiers::default()
            })),
            (Err(error), None) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            (Err(error), _) => Err(explained(&path, error)),
        }
    }

    /// Begins a record of these identifiers. Returns when it is on disk.
    pub(crate) fn begin_record(&self, identifiers: &Identifiers) -> Result<()> {
        self.write_identifiers(identifiers)
    }

    /// Records that all of a reservation may have been used. Returns when the record is on disk.
    pub(crate) fn reserve(&self, reservation: &Reservation) -> Result<()> {
        let text = fs::read_to_string(self.identifiers_path())?;
        self.write_identifiers(&Identifiers {
            next: reservation.below,
            reserved: reservation.below,
            first: identifiers(&text).map_or(1, |recorded| recorded.first),
            inserts: reservation.inserts,
            gps_hits: reservation.gps_hits,
        })
    }

    fn write_identifiers(&self, identifiers: &Identifiers) -> Result<()> {
        let Identifiers {
            next,
            first,
            inserts,
            gps_hits,
            ..
        } = identifiers;
        self.write(IDENTIFIERS, format!("{next} {first} {inserts} {gps_hits}\n").as_bytes())
    }

    pub(crate) fn identifiers_path(&self) -> PathBuf {
        self.folder.join(IDENTIFIERS)
    }

    /// Whether the operator's hold is set.
    pub(crate) fn held(&self) -> bool {
        // A hold is assumed where this cannot be determined.
        self.hold_file().unwrap_or(true)
    }

    /// Whether the hold's file exists.
    ///
    /// # Errors
    /// If that cannot be determined, in words.
    fn hold_file(&self) -> Result<bool, String> {
        let exists = |path: &Path| {
            path.try_exists()
                .map_err(|error| format!("{}: {error}", path.display()))
        };
        let there = exists(&self.hold_path())?;
        // If our lock file is missing, this is not the folder that was opened: it was unmounted or removed as a whole.
        if there || exists(&self.folder.join(LOCK))? {
            Ok(there)
        } else {
            Err(format!("{}: the folder is gone, or another one", self.folder.display()))
        }
    }

    pub(crate) fn hold_path(&self) -> PathBuf {
        self.folder.join("hold")
    }

    pub(crate) fn set_held(&self, held: bool) -> Result<()> {
        if held {
            return self.write("hold", b"held by the operator\n").or_else(|full| {
                // Only the existence of the file counts, and an empty file has room on a full disk.
                let empty = fs::File::create(self.hold_path()).and_then(|file| file.sync_all());
                let kept = empty.and_then(|()| fs::File::open(&self.folder)?.sync_all());
                kept.map_err(|_| full)
            });
        }
        match fs::remove_file(self.hold_path()) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error.into()),
            _ => Ok(()),
        }
    }

    /// Writes the file whole or not at all, and syncs it to disk.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(name);
        let draft = self.folder.join(format!("{name}.new"));
        let written = || -> std::io::Result<()> {
            let mut file = fs::File::create(&draft)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            fs::rename(&draft, &path)?;
            fs::File::open(&self.folder)?.sync_all()
        };
        written().map_err(|error| explained(&path, error))
    }
}

/// Watches the hold's file, which the operator may create or delete with any tool. A change that the runtime made
/// itself is not an act of the operator.
#[derive(Debug)]
pub(crate) struct HoldWatch {
    there: bool,
    /// How many looks in a row could not tell whether the file exists.
    blind: u32,
    /// For that there is a hold, which nobody has released since.
    held_blind: bool,
}

/// What a look at the hold's file has found.
#[derive(Debug, PartialEq)]
pub(crate) enum Seen {
    /// The operator has created or deleted it.
    Act(Operator),
    /// Nobody can tell whether it exists, and why. The operator may be trying to hold, so this is a hold.
    Blind(String),
}

/// So many looks in a row that cannot tell are a hold. One of them may be of a moment.
const BLIND_MAX: u32 = 2;

impl HoldWatch {
    /// Starts from whether the run began with a hold, so that a later creation or deletion of the file is a change.
    pub(crate) const fn new(held: bool) -> Self {
        Self {
            there: held,
            blind: 0,
            held_blind: false,
        }
    }

    /// The operator's act since the last call, if there was one.
    pub(crate) fn look(&mut self, state: &State) -> Option<Seen> {
        let there = match state.hold_file() {
            Ok(there) => there,
            Err(why) => {
                self.blind = self.blind.saturating_add(1);
                if self.blind != BLIND_MAX || self.there {
                    return None;
                }
                self.held_blind = true;
                return Some(Seen::Blind(why));
            }
        };
        self.blind = 0;
        if std::mem::take(&mut self.held_blind) && !there {
            // The hold stands until somebody releases it, and the file says so from now on.
            self.there = state.set_held(true).is_ok();
            return None;
        }
        let changed = there != self.there;
        self.there = there;
        changed.then_some(Seen::Act(if there { Operator::Hold } else { Operator::Release }))
    }

    /// Notes that the runtime has written the file, for a hold, or removed it, or has failed to.
    pub(crate) fn follow(&mut self, state: &State, held: bool) {
        self.held_blind &= held;
        self.there = state.hold_file().unwrap_or(self.there);
    }
}

/// Parses the record: the next identifier, the mission's first one, its inserts and its GPS hits; or a first identifier
/// alone, which the operator has written.
fn identifiers(text: &str) -> Option<Identifiers> {
    let numbers: Vec<u32> = text
        .split_whitespace()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let (next, first, inserts, gps_hits) = match numbers[..] {
        [next] => (next, next, 0, 0),
        [next, first, inserts, gps_hits] => (next, first, inserts, gps_hits),
        _ => return None,
    };
    (next > 0).then_some(Identifiers {
        next,
        reserved: next,
        first,
        inserts,
        gps_hits,
    })
}

/// The folder in which the user's programs keep their state.
pub(crate) fn user_state_folder() -> Result<PathBuf> {
    if let Some(folder) = std::env::var_os("XDG_STATE_HOME").filter(|folder| !folder.is_empty()) {
        return Ok(PathBuf::from(folder));
    }
    match std::env::var_os("HOME").filter(|folder| !folder.is_empty()) {
        Some(home) => Ok(PathBuf::from(home).join(".local").join("state")),
        None => bail!("neither XDG_STATE_HOME nor HOME is set: give a folder with --state DIR"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sr_015_the_operator_holds_and_releases_by_the_file_and_no_act_is_taken_twice() {
        let folder = tempfile::tempdir().unwrap();
        let state = State::open(folder.path(), None).unwrap();
        let mut watch = HoldWatch::new(state.held());
        assert_eq!(watch.look(&state), None);
        let file = folder.path().join("hold");
        fs::write(&file, "").unwrap();
        assert_eq!(watch.look(&state), Some(Seen::Act(Operator::Hold)));
        // The response to it writes the file again, which is no further act.
        state.set_held(true).unwrap();
        watch.follow(&state, true);
        assert_eq!(watch.look(&state), None);
        fs::remove_file(&file).unwrap();
        assert_eq!(watch.look(&state), Some(Seen::Act(Operator::Release)));
        state.set_held(false).unwrap();
        watch.follow(&state, false);
        assert_eq!(watch.look(&state), None);
        // After a hold by other means the runtime has written the file, and the operator deletes it.
        state.set_held(true).unwrap();
        watch.follow(&state, true);
        assert_eq!(watch.look(&state), None);
        fs::remove_file(&file).unwrap();
        assert_eq!(watch.look(&state), Some(Seen::Act(Operator::Release)));
    }

    #[test]
    fn sr_015_a_hold_is_kept_as_an_empty_file_where_nothing_can_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let state = State::open(folder.path(), None).unwrap();
        // A folder in the place of the draft makes the write fail, as a full disk does.
        fs::create_dir(folder.path().join("hold.new")).unwrap();
        state.set_held(true).unwrap();
        assert!(state.held());
        state.set_held(false).unwrap();
        assert!(!state.held());
    }

    #[test]
    fn sr_015_a_folder_that_can_keep_no_hold_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(State::open(folder.path(), None).unwrap().is_new());
        assert!(!State::open(folder.path(), None).unwrap().is_new());
        // A folder in the place of the file makes adding it fail, for root too.
        fs::create_dir(folder.path().join(PROBE)).unwrap();
        let error = State::open(folder.path(), None).err().unwrap();
        assert!(format!("{error:#}").contains("probe"), "{error:#}");
    }

    #[test]
    fn sr_015_a_folder_that_is_unmounted_releases_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let opened = folder.path().join("state");
        let state = State::open(&opened, None).unwrap();
        state.set_held(true).unwrap();
        let mut watch = HoldWatch::new(state.held());
        fs::rename(&opened, folder.path().join("elsewhere")).unwrap();
        fs::create_dir(&opened).unwrap();
        assert_eq!(watch.look(&state), None);
    }

    #[test]
    fn sr_015_a_folder_that_cannot_be_seen_is_a_hold() {
        let folder = tempfile::tempdir().unwrap();
        let opened = folder.path().join("state");
        let state = State::open(&opened, None).unwrap();
        let mut watch = HoldWatch::new(state.held());
        let elsewhere = folder.path().join("elsewhere");
        fs::rename(&opened, &elsewhere).unwrap();
        // A moment is none.
        assert_eq!(watch.look(&state), None);
        fs::rename(&elsewhere, &opened).unwrap();
        assert_eq!(watch.look(&state), None);
        fs::rename(&opened, &elsewhere).unwrap();
        assert_eq!(watch.look(&state), None);
        let Some(Seen::Blind(why)) = watch.look(&state) else {
            panic!()
        };
        assert!(why.ends_with("state: the folder is gone, or another one"), "{why}");
        // As the loop has the hold kept, which fails.
        assert!(state.set_held(true).is_err());
        watch.follow(&state, true);
        assert_eq!(watch.look(&state), None);
        // The folder is back. The hold stands until the operator deletes its file.
        fs::rename(&elsewhere, &opened).unwrap();
        assert_eq!(watch.look(&state), None);
        assert!(state.held());
        assert_eq!(watch.look(&state), None);
        fs::remove_file(state.hold_path()).unwrap();
        assert_eq!(watch.look(&state), Some(Seen::Act(Operator::Release)));
        // Who releases by other means before it is back has released.
        fs::rename(&opened, &elsewhere).unwrap();
        assert_eq!(watch.look(&state), None);
        assert!(matches!(watch.look(&state), Some(Seen::Blind(_))));
        watch.follow(&state, true);
        watch.follow(&state, false);
        fs::rename(&elsewhere, &opened).unwrap();
        assert_eq!(watch.look(&state), None);
        assert!(!state.held());
    }

    #[test]
    fn sr_015_a_hold_that_could_not_be_kept_is_not_released_for_want_of_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let state = State::open(folder.path(), None).unwrap();
        let mut watch = HoldWatch::new(state.held());
        fs::remove_dir_all(folder.path()).unwrap();
        assert!(state.set_held(true).is_err());
        watch.follow(&state, true);
        assert_eq!(watch.look(&state), None);
    }
}
