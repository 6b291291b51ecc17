use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::clock::eventually;

/// The program while it runs. It is killed when this is dropped.
#[derive(Debug)]
pub struct Process {
    child: Child,
    /// Its streams go to files, because a pipe that nobody reads would block it.
    streams: TempDir,
}

impl Process {
    pub(crate) fn start(
        mut command: Command,
        folder: Option<PathBuf>,
        stdout: Option<PathBuf>,
        stderr: Option<Stdio>,
        stdin: Option<&[u8]>,
    ) -> Self {
        let streams = tempfile::tempdir().expect("a temporary folder can be made");
        let file = |name: &str| File::create(streams.path().join(name)).expect("the folder is ours");
        let empty = streams.path().join("folder");
        fs::create_dir(&empty).expect("the folder is ours");
        command.current_dir(folder.as_ref().unwrap_or(&empty));
        command.env("XDG_STATE_HOME", streams.path().join("state"));
        if !command.get_envs().any(|(name, _)| name == "XDG_DATA_HOME") {
            command.env("XDG_DATA_HOME", streams.path().join("data"));
        }
        let own = file("stdout");
        let stdout = stdout.map_or(own, |path| {
            let opened = File::options().write(true).open(&path);
            opened.unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        });
        let stdin = match stdin {
            Some(bytes) => {
                let input = streams.path().join("stdin");
                fs::write(&input, bytes).expect("the folder is ours");
                File::open(&input).expect("it was just written").into()
            }
            None => Stdio::piped(),
        };
        let own = Stdio::from(file("stderr"));
        command.stdin(stdin).stdout(stdout).stderr(stderr.unwrap_or(own));
        let child = command.spawn().expect("the program was just built");
        Self { child, streams }
    }

    /// Writes a line into its standard input, which was left open.
    ///
    /// # Panics
    ///
    /// If it is not open, or the program does not read it any more.
    pub fn types(&mut self, line: &str) {
        let stdin = self.child.stdin.as_mut().expect("its standard input was left open");
        stdin
            .write_all(format!("{line}\n").as_bytes())
            .expect("the program reads its input");
    }

    /// Ends its standard input.
    pub fn ends_input(&mut self) {
        self.child.stdin = None;
    }

    /// The exit code if the program has ended; `Some(None)` if a signal ended it.
    pub fn ended(&mut self) -> Option<Option<i32>> {
        let status = self.child.try_wait().expect("a child of ours can be waited for");
        status.map(|status| status.code())
    }

    /// Waits for its end and returns the exit code.
    ///
    /// # Panics
    ///
    /// If it does not end.
    pub fn wait(&mut self, within: Duration) -> Option<i32> {
        let streams = self.streams.path().to_path_buf();
        eventually(
            within,
            || self.ended(),
            || {
                let said = fs::read_to_string(streams.join("stderr")).unwrap_or_default();
                format!("it does not end\n{said}")
            },
        )
    }

    /// Its standard output so far.
    #[must_use]
    pub fn stdout(&self) -> String {
        self.read("stdout")
    }

    /// Its standard error so far.
    #[must_use]
    pub fn stderr(&self) -> String {
        self.read("stderr")
    }

    /// Waits for a line on standard error that contains this text, and returns it.
    ///
    /// # Panics
    ///
    /// If no such line appears.
    pub fn says(&self, text: &str, within: Duration) -> String {
        eventually(
            within,
            || {
                self.stderr()
                    .lines()
                    .find(|line| line.contains(text))
                    .map(str::to_owned)
            },
            || format!("no line with `{text}`\n{}", self.stderr()),
        )
    }

    /// The memory that it uses, KiB.
    ///
    /// # Panics
    ///
    /// If it has ended, or if there is no /proc.
    #[must_use]
    pub fn memory_kib(&self) -> u64 {
        let path = format!("/proc/{}/status", self.child.id());
        let status = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let number = line.and_then(|line| line.split_whitespace().next());
        number
            .and_then(|number| number.parse().ok())
            .expect("the kernel tells it")
    }

    /// Sends it a signal.
    ///
    /// # Panics
    ///
    /// If it has ended.
    pub fn signal(&self, signal: Signal) {
        let pid = i32::try_from(self.child.id())
            .ok()
            .and_then(Pid::from_raw)
            .expect("a process has a number");
        kill_process(pid, signal).expect("the process is there");
    }

    /// Kills it like `kill -9`, and waits for its end.
    pub fn kill(&mut self) {
        // If this fails, the process has ended already.
        let _ended = self.child.kill();
        self.child.wait().expect("a child of ours can be waited for");
    }

    fn read(&self, name: &str) -> String {
        let bytes = fs::read(self.streams.path().join(name)).expect("the file was made at the start");
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // If it has ended already, nothing is left to do.
        let _ended = self.child.kill();
        let _status = self.child.wait();
    }
}
