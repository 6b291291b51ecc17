use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::clock::eventually;
use crate::mission::Mission;
use crate::process::Process;
use crate::stall::Stall;

/// The longest time for a command that ends by itself.
const ENDS_WITHIN: Duration = Duration::from_secs(180);

/// A command line of the program.
///
/// It runs in an empty folder, with the project's plugins in `$BACKSEAT_PLUGINS`, with the tests' own cache of compiled
/// plugins, without other `BACKSEAT*` variables, and with the user's state in that folder.
#[derive(Debug, Default)]
pub struct Backseat {
    arguments: Vec<OsString>,
    environment: Vec<(OsString, OsString)>,
    folder: Option<PathBuf>,
    stdout: Option<PathBuf>,
    stderr: Option<Stdio>,
    stdin: Vec<u8>,
    typed: bool,
    file_max_kib: Option<u64>,
    files_max: Option<u32>,
    for_sea: bool,
}

impl Backseat {
    /// `backseat`, without arguments.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The program for sea, without the simulation.
    #[must_use]
    pub fn for_sea(mut self) -> Self {
        self.for_sea = true;
        self
    }

    /// Adds arguments.
    #[must_use]
    pub fn args<T: Into<OsString>>(mut self, arguments: impl IntoIterator<Item = T>) -> Self {
        self.arguments.extend(arguments.into_iter().map(Into::into));
        self
    }

    /// Adds one argument.
    #[must_use]
    pub fn arg(self, argument: impl Into<OsString>) -> Self {
        self.args([argument])
    }

    /// Adds a mission's folder as an argument.
    #[must_use]
    pub fn mission(self, mission: &Mission) -> Self {
        self.arg(mission.path())
    }

    /// Sets an environment variable.
    #[must_use]
    pub fn env(mut self, name: &str, value: impl Into<OsString>) -> Self {
        self.environment.push((name.into(), value.into()));
        self
    }

    /// Runs in this folder.
    #[must_use]
    pub fn in_folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// Sends its standard output into this file.
    #[must_use]
    pub fn stdout_to(mut self, file: impl Into<PathBuf>) -> Self {
        self.stdout = Some(file.into());
        self
    }

    /// Sends its standard error to this file, where [`Process::stderr`] does not read it.
    #[must_use]
    pub fn stderr_to(mut self, stream: impl Into<Stdio>) -> Self {
        self.stderr = Some(stream.into());
        self
    }

    /// Gives it this standard input; without this call, the input is empty.
    #[must_use]
    pub fn stdin(mut self, bytes: impl Into<Vec<u8>>) -> Self {
        self.stdin = bytes.into();
        self
    }

    /// Leaves its standard input open, for [`Process::types`].
    #[must_use]
    pub fn typed(mut self) -> Self {
        self.typed = true;
        self
    }

    /// Limits the size of the files that it writes: later writes fail as on a full disk.
    #[must_use]
    pub fn file_max_kib(mut self, kib: u64) -> Self {
        self.file_max_kib = Some(kib);
        self
    }

    /// Limits how many files and sockets it may have open.
    #[must_use]
    pub fn files_max(mut self, files: u32) -> Self {
        self.files_max = Some(files);
        self
    }

    /// Its files in these folders hang during the stall.
    #[must_use]
    pub fn stalled(self, stall: &Stall, folders: &[&Path]) -> Self {
        let folders: Vec<_> = folders.iter().map(|folder| folder.as_os_str()).collect();
        self.env("LD_PRELOAD", backseat_test_support::stall())
            .env("STALL_WHILE", stall.flag())
            .env("STALL_UNDER", folders.join(OsStr::new(":")))
    }

    /// Runs it until it ends.
    ///
    /// # Panics
    ///
    /// If it has not ended after three minutes.
    #[must_use]
    pub fn run(self) -> Finished {
        let mut process = self.spawn();
        let code = eventually(
            ENDS_WITHIN,
            || process.ended(),
            || "the command has not ended".to_owned(),
        );
        Finished {
            code,
            stdout: process.stdout(),
            stderr: process.stderr(),
        }
    }

    /// Starts it. It ends with the [`Process`] at the latest.
    #[must_use]
    pub fn spawn(self) -> Process {
        let program = if self.for_sea {
            backseat_test_support::sea_program()
        } else {
            backseat_test_support::program()
        };
        // The limit's signal would end the program; if it is ignored, the write fails. The unit is 512 bytes.
        let size = self
            .file_max_kib
            .map(|kib| format!("trap '' XFSZ; ulimit -f {};", 2 * kib));
        let count = self.files_max.map(|files| format!("ulimit -n {files};"));
        let limits: Vec<String> = size.into_iter().chain(count).collect();
        let mut command = if limits.is_empty() {
            Command::new(program)
        } else {
            let mut shell = Command::new("sh");
            shell
                .args(["-c", &format!("{} exec \"$0\" \"$@\"", limits.concat())])
                .arg(program);
            shell
        };
        for (name, _) in std::env::vars_os() {
            if name.to_string_lossy().starts_with("BACKSEAT") {
                command.env_remove(name);
            }
        }
        command.env("BACKSEAT_PLUGINS", backseat_test_support::plugins());
        command.env("BACKSEAT_CACHE", backseat_test_support::cache());
        command.env("BACKSEAT_LOG_ROOM", backseat_test_support::LOG_ROOM);
        command.envs(self.environment);
        command.args(self.arguments);
        let stdin = (!self.typed).then_some(&*self.stdin);
        Process::start(command, self.folder, self.stdout, self.stderr, stdin)
    }
}

/// The result of a command.
#[derive(Debug)]
pub struct Finished {
    /// The exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Finished {
    /// Requires this exit code.
    ///
    /// # Panics
    ///
    /// If the command ended with another.
    #[must_use]
    pub fn exit(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self}");
        self
    }

    /// Standard output as one JSON object.
    ///
    /// # Panics
    ///
    /// If it is anything else.
    #[must_use]
    pub fn json(&self) -> Value {
        let value: Value = serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}\n{self}"));
        assert!(value.is_object(), "{self}");
        assert_eq!(self.stdout.trim_end().lines().count(), 1, "one line\n{self}");
        value
    }

    /// Requires that the command refused its input: exit code 2, nothing on standard output, and one line on standard
    /// error that is not a panic. Returns that line.
    ///
    /// # Panics
    ///
    /// If the command did anything else.
    #[must_use]
    pub fn refusal(self) -> String {
        self.refused_with(2)
    }

    /// The error message of a run that could not begin because of something that may pass, such as a port that is taken. It
    /// must be one line, on standard error.
    ///
    /// # Panics
    ///
    /// If the command did anything else.
    #[must_use]
    pub fn refusal_for_now(self) -> String {
        self.refused_with(75)
    }

    fn refused_with(self, code: i32) -> String {
        assert_eq!(self.code, Some(code), "{self}");
        assert_eq!(self.stdout, "", "{self}");
        let line = self.stderr.trim_end();
        assert!(line.starts_with("error: ") && !line.contains('\n'), "one line\n{self}");
        assert!(!line.contains("panicked"), "{self}");
        line.to_owned()
    }
}

impl std::fmt::Display for Finished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { code, stdout, stderr } = self;
        write!(f, "exit {code:?}\n--- stdout\n{stdout}\n--- stderr\n{stderr}")
    }
}
