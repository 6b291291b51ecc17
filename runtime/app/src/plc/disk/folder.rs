use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use backseat_plc::{FilePlace, Stored};

/// A stored file of the controller is never longer.
const STORED_MAX: u64 = 1 << 20;
/// The file that is locked while a process uses the folder.
const LOCK: &str = "6046.lock";

/// The controller's folder, locked.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    /// What the controller calls the folder of its log files.
    logs: String,
    _lock: File,
}

impl Folder {
    /// Opens the folder, and makes it if it is not there. `logs` is what the controller calls its folder of log files.
    ///
    /// # Errors
    ///
    /// In one line, if the folder cannot be written or another process uses it.
    pub(crate) fn open(path: &Path, logs: &str) -> Result<Self> {
        let cannot = || format!("{}: the payload controller cannot keep its files here", path.display());
        if fs::metadata(path).is_ok_and(|kind| !kind.is_dir()) {
            bail!("{}: is not a folder", path.display());
        }
        fs::create_dir_all(path).with_context(cannot)?;
        let locked = path.join(LOCK);
        let lock = File::create(&locked).with_context(cannot)?;
        match lock.try_lock() {
            Ok(()) => Ok(Self {
                path: path.to_path_buf(),
                logs: logs.to_owned(),
                _lock: lock,
            }),
            Err(TryLockError::WouldBlock) => bail!(
                "{}: another payload controller uses this folder: stop it, or choose another folder",
                path.display()
            ),
            Err(TryLockError::Error(error)) => Err(error).with_context(cannot),
        }
    }

    /// What an earlier run stored.
    ///
    /// # Errors
    ///
    /// If a file is there and cannot be read.
    pub(crate) fn stored(&self) -> Result<Stored> {
        Ok(Stored {
            run_list: self.read("6046.sav")?,
            settings: self.read("6046.cfg")?,
        })
    }

    fn read(&self, name: &str) -> Result<Option<String>> {
        let path = self.path.join(name);
        match fs::metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
            Ok(metadata) if metadata.len() > STORED_MAX => {
                bail!(
                    "{}: longer than {STORED_MAX} bytes: not a file of the controller",
                    path.display()
                )
            }
            Ok(_) => {}
        }
        fs::read_to_string(&path)
            .map(Some)
            .with_context(|| path.display().to_string())
    }

    /// The log files of earlier runs.
    ///
    /// # Errors
    ///
    /// If the folder cannot be listed.
    pub(crate) fn logs(&self) -> Result<Vec<FilePlace>> {
        let mut places = Vec::new();
        for entry in fs::read_dir(&self.path).with_context(|| self.path.display().to_string())? {
            let name = entry.with_context(|| self.path.display().to_string())?.file_name();
            if let Some(name) = name.to_str().filter(|name| name.ends_with(".s7k")) {
                places.push(FilePlace {
                    folder: Some(self.logs.clone()),
                    name: name.to_owned(),
                });
            }
        }
        places.sort();
        Ok(places)
    }

    /// The size of the disk and what is free of it, bytes.
    ///
    /// # Errors
    ///
    /// If the file system does not say.
    pub(crate) fn space(&self) -> Result<(u64, u64)> {
        let space = rustix::fs::statvfs(&self.path).with_context(|| self.path.display().to_string())?;
        Ok((
            space.f_blocks.saturating_mul(space.f_frsize),
            space.f_bavail.saturating_mul(space.f_frsize),
        ))
    }

    /// Where a file is: log files in the folder itself, those of another folder that a client named in one below it,
    /// which is named so, but for what a name cannot have.
    pub(super) fn path(&self, place: &FilePlace) -> PathBuf {
        let folder = match &place.folder {
            Some(folder) if *folder != self.logs => self.path.join(plain(folder)),
            Some(_) | None => self.path.clone(),
        };
        folder.join(plain(&place.name))
    }
}

/// A name without separators and special characters, so that it leads nowhere else.
fn plain(text: &str) -> String {
    let keep = |character: char| character.is_ascii_alphanumeric() || " -_.,+=()[]".contains(character);
    let plain: String = text.chars().map(|c| if keep(c) { c } else { '_' }).collect();
    match plain.strip_prefix('.') {
        Some(rest) => format!("_{rest}"),
        None => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(folder: Option<&str>, name: &str) -> FilePlace {
        FilePlace {
            folder: folder.map(str::to_owned),
            name: name.to_owned(),
        }
    }

    #[test]
    fn a_client_cannot_name_a_place_outside_the_folder() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::open(temporary.path(), "D:\\data").unwrap();
        for name in ["..", "../x", "/etc", "C:\\Windows", ".hidden", "a\u{0}b", "~", "...."] {
            for place in [place(Some(name), "a.s7k"), place(Some("D:\\data"), name)] {
                let path = folder.path(&place);
                let below = path.strip_prefix(temporary.path()).unwrap();
                assert!(below.components().count() <= 2, "{below:?}");
                let is_plain = |part: std::path::Component<'_>| matches!(part, std::path::Component::Normal(_));
                assert!(below.components().all(is_plain), "{below:?}");
            }
        }
        assert_eq!(
            folder.path(&place(Some("D:\\data"), "a.s7k")),
            temporary.path().join("a.s7k")
        );
        let other = folder.path(&place(Some("E:/line 3"), "a.s7k"));
        assert_eq!(other, temporary.path().join("E__line 3/a.s7k"));
    }

    #[test]
    fn a_folder_serves_one_process_and_knows_its_files() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::open(temporary.path(), "D:\\data").unwrap();
        assert_eq!(folder.stored().unwrap(), Stored::default());
        let error = Folder::open(temporary.path(), "D:\\data").unwrap_err().to_string();
        assert!(error.contains("another payload controller uses this folder"), "{error}");
        fs::write(temporary.path().join("6046.sav"), "6046 run list 1\n").unwrap();
        fs::write(temporary.path().join("b.s7k"), "").unwrap();
        fs::write(temporary.path().join("a.s7k"), "").unwrap();
        assert_eq!(folder.stored().unwrap().run_list.as_deref(), Some("6046 run list 1\n"));
        let logs = folder.logs().unwrap();
        assert_eq!(
            logs,
            [place(Some("D:\\data"), "a.s7k"), place(Some("D:\\data"), "b.s7k")]
        );
        let (size, free) = folder.space().unwrap();
        assert!(size >= free && size > 0);
    }
}
