//! Where an export is written: a file or a folder that has another name (`.part` behind its own) until it is complete.
//! So an export that fails leaves what is there as it was.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// The file that describes a folder of tables, and by which a later export knows the folder as ours.
pub(crate) const INDEX: &str = "tables.json";

const IS_FILE: &str = "is a file: name a folder for the tables";

fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// The place of an output. A link stays one: what it leads to is written.
///
/// `/dev/stdout` is a link too, and never replaced, even if it leads to a file: it is everybody's.
fn place(path: &Path) -> Result<Place, Error> {
    let kind = match fs::symlink_metadata(path) {
        Ok(kind) => kind,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Place::Replaced(path.to_owned())),
        Err(error) => return Err(Error::write(path, error)),
    };
    if !kind.is_symlink() {
        let is_kept = kind.is_file() || kind.is_dir();
        return Ok(if is_kept {
            Place::Replaced(path.to_owned())
        } else {
            Place::Direct
        });
    }
    let absolute = std::path::absolute(path).map_err(|source| Error::write(path, source))?;
    if ["/dev", "/proc"].iter().any(|system| absolute.starts_with(system)) {
        return Ok(Place::Direct);
    }
    let target = fs::canonicalize(path).map_err(|source| Error::write(path, source))?;
    match fs::metadata(&target) {
        Ok(kind) if kind.is_file() || kind.is_dir() => Ok(Place::Replaced(target)),
        Ok(_) => Ok(Place::Direct),
        Err(source) => Err(Error::write(path, source)),
    }
}

enum Place {
    /// A device, a pipe, or what a process has open.
    Direct,
    /// This file or folder is replaced once the new one is complete; it may not exist yet.
    Replaced(PathBuf),
}

/// A file to write. A device or a pipe is written directly.
#[derive(Debug)]
pub(crate) struct OutputFile {
    /// As the user named it.
    path: PathBuf,
    /// What is written, and the name that it gets.
    part: Option<(PathBuf, PathBuf)>,
    writer: BufWriter<File>,
}

impl OutputFile {
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let part = match place(path)? {
            Place::Replaced(target) if target.is_dir() => {
                return Err(Error::output(path, "is a folder: name a file in it"));
            }
            Place::Replaced(target) => Some((part_of(&target), target)),
            Place::Direct => None,
        };
        let file = match &part {
            Some((part, _)) => File::create(part),
            // What is behind `>> FILE` is not emptied.
            None => File::options().append(true).open(path),
        };
        let file = file.map_err(|source| Error::write(path, source))?;
        Ok(Self {
            path: path.to_owned(),
            part,
            writer: BufWriter::with_capacity(1 << 16, file),
        })
    }

    /// An error of writing, with the path.
    pub(crate) fn failed(&self, source: io::Error) -> Error {
        Error::write(&self.path, source)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name.
    pub(crate) fn commit(mut self) -> Result<(), Error> {
        let done = self.writer.flush().and_then(|()| match &self.part {
            Some((part, target)) => fs::rename(part, target),
            None => Ok(()),
        });
        done.map_err(|source| self.failed(source))?;
        self.part = None;
        Ok(())
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Some((part, _)) = &self.part {
            // What cannot be removed stays: the error that led here is the one to report.
            let _left = fs::remove_file(part);
        }
    }
}

/// What is read of a folder's [`INDEX`].
#[derive(Debug, Default, Serialize, Deserialize)]
struct Owned {
    #[serde(default)]
    files: Vec<String>,
}

/// A folder of files to write.
#[derive(Debug)]
pub(crate) struct OutputFolder {
    path: PathBuf,
    part: Option<PathBuf>,
}

impl OutputFolder {
    /// # Errors
    ///
    /// [`Error::Output`] where the path is that of a file, or of a folder with files that no export wrote.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        // A slash behind the name would put `.part` into the folder.
        let path: PathBuf = path.components().collect();
        let path = match place(&path)? {
            Place::Replaced(target) => target,
            Place::Direct => return Err(Error::output(&path, IS_FILE)),
        };
        owned(&path)?;
        let part = part_of(&path);
        // Of an export that was killed.
        remove(&part)?;
        fs::create_dir(&part).map_err(|source| Error::write(&path, source))?;
        let folder = Self { path, part: Some(part) };
        // So that the folder is known as ours from its first file on, whatever happens.
        folder.write_index(&Owned::default())?;
        Ok(folder)
    }

    /// Where to write a file.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.part.as_deref().unwrap_or(&self.path).join(name)
    }

    /// Writes the folder's [`INDEX`], which must have `files`: the names of all other files.
    pub(crate) fn write_index(&self, index: &impl Serialize) -> Result<(), Error> {
        let mut text = serde_json::to_vec_pretty(index).map_err(|error| Error::write(&self.path, error.into()))?;
        text.push(b'\n');
        fs::write(self.file(INDEX), text).map_err(|source| Error::write(&self.path, source))
    }

    /// Gives the folder its name, in place of an earlier export.
    pub(crate) fn commit(mut self) -> Result<(), Error> {
        let failed = |source| Error::write(&self.path, source);
        if let Some(part) = &self.part {
            let mut old = self.path.as_os_str().to_owned();
            old.push(".old");
            let old = PathBuf::from(old);
            remove(&old)?;
            // Once more: somebody may have put a file there meanwhile.
            owned(&self.path)?;
            let replaces = self.path.exists();
            if replaces {
                fs::rename(&self.path, &old).map_err(failed)?;
            }
            if let Err(error) = fs::rename(part, &self.path) {
                if replaces {
                    // The first error is the one to report.
                    let _back = fs::rename(&old, &self.path);
                }
                return Err(failed(error));
            }
            remove(&old)?;
        }
        self.part = None;
        Ok(())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            // What cannot be removed stays: the error that led here is the one to report.
            let _left = fs::remove_dir_all(part);
        }
    }
}

/// The files of an earlier export. None where there is no folder, or an empty one.
fn owned(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            return Err(Error::output(path, IS_FILE));
        }
        Err(error) => return Err(Error::write(path, error)),
    };
    let index: Option<Owned> = fs::read(path.join(INDEX))
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok());
    let mut files = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|source| Error::write(path, source))?;
        let name = entry.file_name();
        let is_ours = index
            .as_ref()
            .is_some_and(|index| name == INDEX || index.files.iter().any(|file| name == file.as_str()));
        // Those of an export that was killed are not in its index yet.
        let is_unfinished = index.as_ref().is_some_and(|index| index.files.is_empty()) && is_table(&entry.path());
        if !is_ours && !is_unfinished {
            return Err(Error::output(
                path,
                format!(
                    "is a folder with files that no export wrote, such as {}: name a new or an empty folder",
                    name.display()
                ),
            ));
        }
        files.push(entry.path());
    }
    Ok(files)
}

fn is_table(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    let extension = if extension == Some("part") {
        path.file_stem()
            .map(Path::new)
            .and_then(Path::extension)
            .and_then(|stem| stem.to_str())
    } else {
        extension
    };
    matches!(extension, Some("csv" | "parquet"))
}

/// Removes a folder that an export wrote, and nothing else.
fn remove(folder: &Path) -> Result<(), Error> {
    for file in owned(folder)? {
        fs::remove_file(&file).map_err(|source| Error::write(&file, source))?;
    }
    match fs::remove_dir(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Error::write(folder, error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn export(path: &Path, name: &str) -> Result<(), Error> {
        let folder = OutputFolder::create(path)?;
        fs::write(folder.file(name), name).unwrap();
        folder.write_index(&Owned {
            files: vec![name.to_owned()],
        })?;
        folder.commit()
    }

    fn names(path: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_is_replaced_by_the_next_export_and_by_nothing_else() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("tables");
        export(&path, "a.csv").unwrap();
        export(&path, "b.csv").unwrap();
        assert_eq!(names(&path), ["b.csv", INDEX]);
        assert_eq!(names(home.path()), ["tables"]);
        fs::write(path.join("notes.txt"), "mine").unwrap();
        let error = export(&path, "c.csv").unwrap_err().to_string();
        assert!(error.contains("such as notes.txt"), "{error}");
        assert_eq!(names(&path), ["b.csv", "notes.txt", INDEX]);
        assert_eq!(names(home.path()), ["tables"]);
    }

    #[test]
    fn an_export_that_fails_leaves_the_earlier_one_and_no_part() {
        let home = tempfile::tempdir().unwrap();
        let (folder, file) = (home.path().join("tables"), home.path().join("track.kml"));
        export(&folder, "a.csv").unwrap();
        fs::write(&file, "old").unwrap();
        drop(OutputFolder::create(&folder).unwrap());
        let mut output = OutputFile::create(&file).unwrap();
        output.write_all(b"new").unwrap();
        drop(output);
        assert_eq!(names(home.path()), ["tables", "track.kml"]);
        assert_eq!(
            (names(&folder), fs::read(&file).unwrap()),
            (vec!["a.csv".to_owned(), INDEX.to_owned()], b"old".to_vec())
        );
    }

    #[test]
    fn what_a_killed_export_left_is_removed_and_what_is_not_ours_is_not() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("tables");
        let part = part_of(&path);
        let killed = OutputFolder::create(&path).unwrap();
        fs::write(killed.file("a.csv"), "half").unwrap();
        std::mem::forget(killed);
        export(&path, "b.csv").unwrap();
        assert_eq!(names(home.path()), ["tables"]);
        fs::create_dir(&part).unwrap();
        fs::write(part.join("thesis.csv"), "mine").unwrap();
        assert!(export(&path, "c.csv").is_err());
        assert_eq!(names(&part), ["thesis.csv"]);
    }

    #[test]
    fn a_link_stays_a_link_and_what_it_leads_to_is_replaced() {
        let home = tempfile::tempdir().unwrap();
        let [file, file_link, folder, folder_link] =
            ["a.kml", "link.kml", "tables", "link"].map(|name| home.path().join(name));
        fs::write(&file, "old").unwrap();
        export(&folder, "a.csv").unwrap();
        std::os::unix::fs::symlink(&file, &file_link).unwrap();
        std::os::unix::fs::symlink(&folder, &folder_link).unwrap();
        let mut output = OutputFile::create(&file_link).unwrap();
        output.write_all(b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"old");
        output.commit().unwrap();
        export(&folder_link, "b.csv").unwrap();
        assert!(file_link.is_symlink() && folder_link.is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(names(&folder), ["b.csv", INDEX]);
        assert_eq!(names(home.path()), ["a.kml", "link", "link.kml", "tables"]);
    }

    /// Under `/proc` and not `/dev`, where a mistake could replace the link for the whole computer.
    #[test]
    fn what_a_process_has_open_is_written_at_its_end_and_keeps_its_name() {
        use std::os::fd::AsRawFd as _;
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("out.csv");
        fs::write(&path, "first,").unwrap();
        let open = File::options().append(true).open(&path).unwrap();
        let mut output = OutputFile::create(Path::new(&format!("/proc/self/fd/{}", open.as_raw_fd()))).unwrap();
        output.write_all(b"second").unwrap();
        output.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first,second");
        assert_eq!(names(home.path()), ["out.csv"]);
    }

    #[test]
    fn a_file_is_not_a_folder_and_the_reverse() {
        let home = tempfile::tempdir().unwrap();
        let file = home.path().join("file");
        fs::write(&file, "x").unwrap();
        assert!(
            OutputFolder::create(&file)
                .unwrap_err()
                .to_string()
                .contains("is a file")
        );
        assert!(
            OutputFile::create(home.path())
                .unwrap_err()
                .to_string()
                .contains("is a folder")
        );
    }
}
