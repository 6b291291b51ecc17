mod name;
mod template;

use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use tempfile::TempDir;
use toml::{Table, Value};

use crate::error::{ToolError, of_file};
use crate::kit::Kit;
use crate::python;

/// The language of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// A crate, with `Cargo.toml`.
    Rust,
    /// A module `plugin`, with `pyproject.toml`.
    Python,
}

impl Language {
    /// The file that makes a folder a plugin of this language.
    const fn manifest(self) -> &'static str {
        match self {
            Self::Rust => "Cargo.toml",
            Self::Python => "pyproject.toml",
        }
    }

    /// The table of that file with the plugin's name.
    const fn table(self) -> &'static str {
        match self {
            Self::Rust => "package",
            Self::Python => "project",
        }
    }
}

/// A plugin's folder: a crate or a Python module, with the mission that it flies in.
///
/// Its component is beside its manifest, as `NAME.wasm`: the file that its author hands on, where a person looks
/// for it, and out of the reach of `cargo clean`. The project's `mission/mission.toml` names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Project {
    folder: PathBuf,
    name: String,
    language: Language,
}

impl Project {
    /// Makes a new plugin in `parent/NAME`, at once or not at all.
    ///
    /// # Errors
    ///
    /// [`ToolError::Name`] if a plugin cannot be called so, [`ToolError::Exists`] if there is something already,
    /// [`ToolError::File`] if the folder cannot be written.
    pub fn create(parent: &Path, name: &str, language: Language, kit: &Kit) -> Result<Self, ToolError> {
        name::check(name)?;
        let folder = parent.join(name);
        let exists = || ToolError::Exists { path: folder.clone() };
        if fs::symlink_metadata(&folder).is_ok() {
            return Err(exists());
        }
        let new = temporary(parent).map_err(of_file(parent))?;
        for (path, text) in template::files(name, language, kit) {
            let file = new.path().join(&path);
            if let Some(within) = file.parent() {
                fs::create_dir_all(within).map_err(of_file(within))?;
            }
            fs::write(&file, text).map_err(of_file(&file))?;
        }
        fs::rename(new.path(), &folder).map_err(|error| {
            if error.kind() == io::ErrorKind::DirectoryNotEmpty || error.kind() == io::ErrorKind::NotADirectory {
                exists()
            } else {
                of_file(&folder)(error)
            }
        })?;
        Ok(Self {
            folder,
            name: name.to_owned(),
            language,
        })
    }

    /// Finds the parts of a plugin's folder.
    ///
    /// # Errors
    ///
    /// [`ToolError::NoProject`] without a `Cargo.toml` or `pyproject.toml`, [`ToolError::Manifest`] if that names no
    /// package.
    pub fn open(folder: &Path) -> Result<Self, ToolError> {
        let mut languages = [Language::Rust, Language::Python].into_iter();
        let there = languages.find(|language| folder.join(language.manifest()).is_file());
        let language = there.ok_or_else(|| ToolError::NoProject {
            path: folder.to_path_buf(),
        })?;
        let (path, manifest) = manifest(folder, language)?;
        let name = manifest
            .get(language.table())
            .and_then(|package| package.get("name")?.as_str());
        let name = name.ok_or_else(|| ToolError::Manifest {
            path,
            fault: format!(
                "no [{}] with a name: expected the folder of one plugin",
                language.table()
            ),
        })?;
        Ok(Self {
            folder: folder.to_path_buf(),
            name: name.to_owned(),
            language,
        })
    }

    /// Its language.
    #[must_use]
    pub const fn language(&self) -> Language {
        self.language
    }

    /// Its folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The name of its package.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its component, built or not.
    #[must_use]
    pub fn component(&self) -> PathBuf {
        self.part(&format!("{}.wasm", self.name))
    }

    /// Its component, which must be built.
    ///
    /// # Errors
    ///
    /// [`ToolError::NotBuilt`] if it is not.
    pub fn built(&self) -> Result<PathBuf, ToolError> {
        let component = self.component();
        if component.is_file() {
            Ok(component)
        } else {
            Err(ToolError::NotBuilt {
                component,
                folder: self.folder.clone(),
            })
        }
    }

    /// The mission that it flies in.
    #[must_use]
    pub fn mission(&self) -> PathBuf {
        self.part("mission")
    }

    /// The path of a part, without `./` in front of it.
    fn part(&self, name: &str) -> PathBuf {
        if self.folder == Path::new(".") {
            PathBuf::from(name)
        } else {
            self.folder.join(name)
        }
    }

    /// Checks that its component is among those that its mission flies.
    ///
    /// # Errors
    ///
    /// [`ToolError::NotFlown`] if it is not.
    pub fn require_flown(&self, components: &[PathBuf]) -> Result<(), ToolError> {
        let own = self.component().canonicalize().ok();
        if components.iter().any(|component| component.canonicalize().ok() == own) {
            return Ok(());
        }
        Err(ToolError::NotFlown {
            mission: self.mission(),
            expected: format!("../{}.wasm", self.name),
        })
    }

    /// A source that is newer than the component: then the component is not what the sources say.
    #[must_use]
    pub fn newer_source(&self) -> Option<PathBuf> {
        let built = modified(&self.component())?;
        let mut sources = vec![self.part(self.language.manifest())];
        match self.language {
            Language::Rust => {
                sources.push(self.part("Cargo.lock"));
                collect(&self.part("src"), &mut sources);
            }
            Language::Python => python::sources(&self.folder, &mut sources),
        }
        sources
            .into_iter()
            .find(|source| modified(source).is_some_and(|at| at > built))
    }

    /// Checks that the SDK is where the plugin looks for it.
    ///
    /// # Errors
    ///
    /// [`ToolError::NoSdk`] if it is not, with the place of this program's SDK.
    pub(crate) fn require_sdk(&self, kit: &Kit) -> Result<(), ToolError> {
        let (path, manifest) = manifest(&self.folder, Language::Rust)?;
        let dependencies = manifest.get("dependencies");
        let named = dependencies
            .and_then(|all| all.get("backseat-sdk")?.get("path"))
            .and_then(Value::as_str);
        match named.map(|sdk| self.folder.join(sdk)) {
            Some(sdk) if !sdk.join("Cargo.toml").is_file() => Err(ToolError::NoSdk {
                manifest: path,
                sdk,
                here: kit.sdk(),
            }),
            Some(_) | None => Ok(()),
        }
    }
}

/// The path and the content of a folder's manifest.
fn manifest(folder: &Path, language: Language) -> Result<(PathBuf, Table), ToolError> {
    let path = folder.join(language.manifest());
    let text = fs::read_to_string(&path).map_err(of_file(&path))?;
    match text.parse() {
        Ok(manifest) => Ok((path, manifest)),
        Err(error) => Err(ToolError::Manifest {
            path,
            fault: error.message().replace('\n', " "),
        }),
    }
}

fn modified(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).ok()?.modified().ok()
}

/// Every file in a folder and below it.
pub(crate) fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}

/// A hidden folder in this one, with the permissions that any new folder has. It is removed when it is dropped.
pub(crate) fn temporary(place: &Path) -> io::Result<TempDir> {
    tempfile::Builder::new()
        .prefix(".backseat-")
        .permissions(Permissions::from_mode(0o777))
        .tempdir_in(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_has_its_parts_and_nothing_is_left_behind() {
        let place = tempfile::tempdir().unwrap();
        let kit = Kit::ready_in(&place.path().join("kit")).unwrap();
        let project = Project::create(place.path(), "drift", Language::Rust, &kit).unwrap();
        assert_eq!(Project::open(&place.path().join("drift")).unwrap(), project);
        for part in [
            "src/lib.rs",
            "Cargo.lock",
            "README.md",
            ".gitignore",
            "mission/world.toml",
        ] {
            assert!(project.folder().join(part).is_file(), "{part}");
        }
        let hidden = fs::read_dir(place.path()).unwrap();
        assert_eq!(hidden.count(), 2, "the kit and the plugin");
        project.require_sdk(&kit).unwrap();
        let error = Project::create(place.path(), "drift", Language::Rust, &kit)
            .unwrap_err()
            .to_string();
        assert!(
            error.ends_with("drift: exists already: choose another name, or remove it"),
            "{error}"
        );
        fs::write(place.path().join("file"), "").unwrap();
        assert!(matches!(
            Project::create(place.path(), "file", Language::Rust, &kit),
            Err(ToolError::Exists { .. })
        ));
    }

    #[test]
    fn a_missing_sdk_is_reported_with_the_one_that_is_there() {
        let place = tempfile::tempdir().unwrap();
        let first = Kit::ready_in(&place.path().join("first")).unwrap();
        let second = Kit::ready_in(&place.path().join("second")).unwrap();
        let project = Project::create(place.path(), "drift", Language::Rust, &first).unwrap();
        fs::remove_dir_all(place.path().join("first")).unwrap();
        let error = project.require_sdk(&second).unwrap_err().to_string();
        let expected = format!("set the path of backseat-sdk to {}", second.sdk().display());
        assert!(error.ends_with(&expected), "{error}");
    }

    #[test]
    fn a_project_in_python_has_its_parts() {
        let place = tempfile::tempdir().unwrap();
        let kit = Kit::ready_in(&place.path().join("kit")).unwrap();
        let project = Project::create(place.path(), "drift", Language::Python, &kit).unwrap();
        assert_eq!(Project::open(&place.path().join("drift")).unwrap(), project);
        for part in [
            "plugin.py",
            "test_plugin.py",
            "README.md",
            ".gitignore",
            "mission/world.toml",
        ] {
            assert!(project.folder().join(part).is_file(), "{part}");
        }
        assert!(kit.python_sdk().join("backseat_sdk/build.py").is_file());
        let mission = fs::read_to_string(project.mission().join("mission.toml")).unwrap();
        assert!(mission.contains("component = \"../drift.wasm\""), "{mission}");
        // A source in an environment, or in a hidden folder, is not the plugin's.
        fs::write(project.component(), "").unwrap();
        for (folder, marked) in [("env", true), (".hidden", false)] {
            let folder = project.folder().join(folder);
            fs::create_dir(&folder).unwrap();
            if marked {
                fs::write(folder.join("pyvenv.cfg"), "").unwrap();
            }
            fs::write(folder.join("late.py"), "").unwrap();
        }
        assert_eq!(project.newer_source(), None);
        fs::write(project.folder().join("late.py"), "").unwrap();
        let source = fs::File::options()
            .write(true)
            .open(project.folder().join("late.py"))
            .unwrap();
        source
            .set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(4_000_000_000))
            .unwrap();
        assert_eq!(project.newer_source(), Some(project.folder().join("late.py")));
        fs::write(project.folder().join("pyproject.toml"), "[tool.x]").unwrap();
        let error = Project::open(project.folder()).unwrap_err().to_string();
        assert!(error.contains("no [project] with a name"), "{error}");
    }

    #[test]
    fn a_folder_without_a_package_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let open = || Project::open(place.path()).unwrap_err().to_string();
        assert!(open().contains("no Cargo.toml or pyproject.toml here"), "{}", open());
        for (manifest, fault) in [("[workspace]", "no [package] with a name"), ("[package", "")] {
            fs::write(place.path().join("Cargo.toml"), manifest).unwrap();
            assert!(open().contains(fault) && open().lines().count() == 1, "{}", open());
        }
    }

    #[test]
    fn a_component_that_is_older_than_its_sources_is_noticed() {
        let place = tempfile::tempdir().unwrap();
        let kit = Kit::ready_in(&place.path().join("kit")).unwrap();
        let project = Project::create(place.path(), "drift", Language::Rust, &kit).unwrap();
        assert!(matches!(project.built(), Err(ToolError::NotBuilt { .. })));
        assert_eq!(project.newer_source(), None);
        fs::write(project.component(), "").unwrap();
        let source = project.folder().join("src/lib.rs");
        let date = |path: &Path, seconds: u64| {
            let file = fs::File::options().write(true).open(path).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds))
                .unwrap();
        };
        for file in ["Cargo.toml", "Cargo.lock"] {
            date(&project.folder().join(file), 1);
        }
        date(&project.component(), 2);
        date(&source, 1);
        assert_eq!(project.newer_source(), None);
        date(&source, 3);
        assert_eq!(project.newer_source(), Some(source));
    }
}
