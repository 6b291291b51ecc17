//! The kit on disk. It comes into being by one rename, so nobody sees a part of it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::content::Content;
use crate::error::ToolError;
use crate::project::{collect, temporary};

/// How often it is tried while other processes do the same.
const ATTEMPTS: usize = 8;

/// Makes sure that the kit is there and whole, and returns its folder.
pub(super) fn ready(place: &Path, content: &Content) -> Result<PathBuf, ToolError> {
    let folder = place.join(content.name());
    let failed = |source| ToolError::Kit {
        path: folder.clone(),
        source,
    };
    for _ in 0..ATTEMPTS {
        if is_whole(&folder, content) {
            return Ok(folder);
        }
        replace(place, &folder, content).map_err(failed)?;
    }
    Err(failed(io::Error::other(
        "it is changed again and again by something else",
    )))
}

/// Whether every file of the kit is there with its content, and no other. (Cargo would run a `build.rs` that is added to
/// a crate.)
fn is_whole(folder: &Path, content: &Content) -> bool {
    let mut found = Vec::new();
    collect(folder, &mut found);
    if found.len() != content.files().count() {
        return false;
    }
    content
        .files()
        .all(|(path, bytes)| fs::read(folder.join(path)).is_ok_and(|found| found == bytes))
}

/// Puts a new folder in the place of one that is missing or damaged. If another process was faster, its folder stays.
fn replace(place: &Path, folder: &Path, content: &Content) -> io::Result<()> {
    fs::create_dir_all(place)?;
    let new = temporary(place)?;
    for (path, bytes) in content.files() {
        let file = new.path().join(path);
        if let Some(parent) = file.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::write(file, bytes)?;
    }
    // It is removed with its temporary folder.
    let old = temporary(place)?;
    match fs::rename(folder, old.path().join("damaged")) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    match fs::rename(new.path(), folder) {
        Err(error) if error.kind() != io::ErrorKind::DirectoryNotEmpty && !folder.is_dir() => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    fn names(place: &Path) -> Vec<String> {
        let entries = fs::read_dir(place).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn it_is_unpacked_once_and_then_left_alone() {
        let place = tempfile::tempdir().unwrap();
        let content = Content::embedded();
        let folder = ready(place.path(), content).unwrap();
        assert_eq!(names(place.path()), [content.name()]);
        let changed = |folder: &Path| fs::metadata(folder.join("wit")).unwrap().modified().unwrap();
        let before = changed(&folder);
        assert_eq!(ready(place.path(), content).unwrap(), folder);
        assert_eq!(changed(&folder), before);
    }

    #[test]
    fn a_damaged_kit_is_made_anew() {
        let place = tempfile::tempdir().unwrap();
        let content = Content::embedded();
        let folder = ready(place.path(), content).unwrap();
        let file = folder.join("plugins/sdk/src/lib.rs");
        let whole = fs::read(&file).unwrap();
        let damages: [&dyn Fn(); 5] = [
            &|| fs::write(folder.join("plugins/sdk/build.rs"), "fn main() {}").unwrap(),
            &|| fs::write(&file, &whole[..100]).unwrap(),
            &|| fs::remove_file(&file).unwrap(),
            &|| {
                fs::remove_file(&file).unwrap();
                fs::create_dir(&file).unwrap();
            },
            &|| {
                fs::remove_dir_all(&folder).unwrap();
                fs::write(&folder, "a file in place of the folder").unwrap();
            },
        ];
        for damage in damages {
            damage();
            assert!(!is_whole(&folder, content));
            assert_eq!(ready(place.path(), content).unwrap(), folder);
            assert!(is_whole(&folder, content));
            assert_eq!(names(place.path()), [content.name()], "nothing is left behind");
        }
    }

    #[test]
    fn many_may_unpack_and_repair_it_at_once() {
        let place = tempfile::tempdir().unwrap();
        let content = Content::embedded();
        for damaged in [false, true] {
            if damaged {
                fs::remove_dir_all(place.path().join(content.name()).join("wit")).unwrap();
            }
            thread::scope(|scope| {
                let all: Vec<_> = (0..8).map(|_| scope.spawn(|| ready(place.path(), content))).collect();
                for one in all {
                    one.join().unwrap().unwrap();
                }
            });
            assert!(is_whole(&place.path().join(content.name()), content));
            assert_eq!(names(place.path()), [content.name()]);
        }
    }

    #[test]
    fn a_place_that_cannot_be_written_is_named() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        let error = ready(&file, Content::embedded()).unwrap_err().to_string();
        assert!(error.contains("file") && error.contains("BACKSEAT_KIT"), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
}
