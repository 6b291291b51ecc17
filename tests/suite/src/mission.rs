use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A mission in a temporary folder, which a test may edit.
#[derive(Debug)]
pub struct Mission {
    folder: TempDir,
    path: PathBuf,
}

impl Mission {
    /// A copy of a mission of the project.
    #[must_use]
    pub fn copy(name: &str) -> Self {
        Self::copy_of(&backseat_test_support::mission(name), name)
    }

    /// The suite's own mission: `faulty` without a fault keeps a heading along a straight plan over a flat seabed, from
    /// two seconds after the start on.
    #[must_use]
    pub fn steady() -> Self {
        Self::own("steady")
    }

    /// The suite's own mission with a hovering vehicle: `faulty` without a fault keeps it at its station beside a ship,
    /// from two seconds after the start on.
    #[must_use]
    pub fn hovering() -> Self {
        Self::own("hovering")
    }

    fn own(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("missions").join(name);
        Self::copy_of(&path, name)
    }

    fn copy_of(from: &Path, name: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let path = folder.path().join(name);
        fs::create_dir(&path).expect("the folder is new");
        for entry in fs::read_dir(from).unwrap_or_else(|error| panic!("{}: {error}", from.display())) {
            let file = entry.expect("a mission's folder can be listed").path();
            let name = file.file_name().expect("what is listed has a name");
            fs::copy(&file, path.join(name)).expect("a mission's files can be copied");
        }
        Self { folder, path }
    }

    /// Replaces a text, which must be there.
    #[must_use]
    pub fn edit(self, file: &str, from: &str, to: &str) -> Self {
        let text = self.read(file);
        assert!(text.contains(from), "{file} has no `{from}` to edit:\n{text}");
        self.write(file, text.replace(from, to))
    }

    /// Splits the steady mission's line into pieces, of which one begins every 10 s. A runtime that connects in between
    /// soon learns the current behavior, without which no insert is sent.
    #[must_use]
    pub fn in_legs(self) -> Self {
        let leg = |number: i32| {
            let (start_m, end_m) = (20 * number - 600, 20 * number - 580);
            format!(
                "[[plan]]\nkind = \"trackline\"\nstart = {{ east_m = {start_m}, north_m = 0 }}\n\
                 end = {{ east_m = {end_m}, north_m = 0 }}\ndepth_m = 8\nspeed_mps = 1.5\ndynamic = true\n\
                 timeout_s = 10\n\n"
            )
        };
        let legs: String = (0..60).map(leg).collect();
        let world = self.read("world.toml");
        let (before, plan) = world.split_once("[[plan]]").expect("a plan");
        let (_, after) = plan.rsplit_once("[expect]").expect("what is expected");
        let text = format!("{before}{legs}[expect]{after}");
        self.write("world.toml", text)
    }

    /// Removes everything from a text on, which must be there.
    #[must_use]
    pub fn cut(self, file: &str, from: &str) -> Self {
        let text = self.read(file);
        let end = text
            .find(from)
            .unwrap_or_else(|| panic!("{file} has no `{from}` to cut at:\n{text}"));
        self.write(file, &text[..end])
    }

    /// Adds lines at the end of a file.
    #[must_use]
    pub fn append(self, file: &str, lines: &str) -> Self {
        let text = self.read(file);
        self.write(file, format!("{text}\n{lines}\n"))
    }

    /// Replaces a file.
    #[must_use]
    pub fn write(self, file: &str, content: impl AsRef<[u8]>) -> Self {
        fs::write(self.path.join(file), content).expect("the folder is ours");
        self
    }

    /// Removes a file.
    #[must_use]
    pub fn without(self, file: &str) -> Self {
        fs::remove_file(self.path.join(file)).expect("the file is there");
        self
    }

    /// The text of one of the mission's files.
    #[must_use]
    pub fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path.join(file)).expect("the file is there")
    }

    /// The mission's folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A path beside the mission for the output of a run; it is removed with the mission.
    #[must_use]
    pub fn beside(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}
