//! Plugins in Python: the environment that builds them, their tests and their components.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::error::{ToolError, of_file};
use crate::kit::Kit;
use crate::project::Project;

/// Prints the version of componentize-py that the SDK needs, and ends well if this Python has it, pytest and the right
/// version of itself.
const PROBE: &str = "\
import importlib.metadata, importlib.util, sys
if sys.version_info < (3, 11):
    sys.exit('Python 3.11 or later is needed, and this is ' + sys.version.split()[0])
from backseat_sdk.build import COMPONENTIZE
print(COMPONENTIZE)
try:
    found = importlib.metadata.version('componentize-py')
except importlib.metadata.PackageNotFoundError:
    found = None
sys.exit(0 if found == COMPONENTIZE and importlib.util.find_spec('pytest') else 3)
";
/// The exit code of the probe if only packages are missing.
const PACKAGES_MISSING: i32 = 3;
/// With this code pytest says that there is no test.
const NO_TESTS: i32 = 5;

/// A Python with what builds a component, and the SDK of the kit.
pub(crate) struct Python {
    program: OsString,
    sdk: PathBuf,
}

/// What a Python has.
enum Probe {
    /// All.
    Ready,
    /// Not the packages; with the version of componentize-py that is needed.
    Lacks(String),
}

impl Python {
    /// The Python of the user, if it has componentize-py and pytest. Otherwise an environment beside the kit, which is made
    /// when it is needed first; `tell` says so before, because it takes a while.
    pub(crate) fn ready(kit: &Kit, tell: &dyn Fn(&str)) -> Result<Self, ToolError> {
        let own = std::env::var_os("PYTHON").filter(|name| !name.is_empty());
        let own = Self {
            program: own.unwrap_or_else(|| "python3".into()),
            sdk: kit.python_sdk(),
        };
        let Probe::Lacks(version) = own.probe()? else {
            return Ok(own);
        };
        let folder = kit.beside(&format!("python-{version}"));
        let made = Self {
            program: folder.join("bin/python").into(),
            sdk: kit.python_sdk(),
        };
        fs::create_dir_all(&folder).map_err(of_file(&folder))?;
        // Another process may do the same at the same time.
        let path = folder.join(".lock");
        let lock = File::create(&path).map_err(of_file(&path))?;
        lock.lock().map_err(of_file(&path))?;
        if matches!(made.probe(), Ok(Probe::Ready)) {
            return Ok(made);
        }
        tell(&format!(
            "installing componentize-py {version} and pytest from PyPI into {}, once",
            folder.display()
        ));
        let failed = |what: &str, fault: String| ToolError::Python {
            what: format!("{}: {what}", folder.display()),
            fault,
        };
        let place = folder.as_os_str().to_owned();
        run(own.command().args(["-m", "venv"]).arg(place)).map_err(|fault| failed("venv", fault))?;
        let packages = [&format!("componentize-py=={version}"), "pytest"];
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        run(made.command().args(pip).args(packages)).map_err(|fault| failed("pip", fault))?;
        match made.probe()? {
            Probe::Ready => Ok(made),
            Probe::Lacks(_) => Err(failed(
                "pip",
                "it installed something else than was asked for".to_owned(),
            )),
        }
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        // Bytecode beside the SDK's sources would make the kit another one.
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        let mut path = self.sdk.clone().into_os_string();
        if let Some(before) = std::env::var_os("PYTHONPATH").filter(|before| !before.is_empty()) {
            path.push(":");
            path.push(before);
        }
        command.env("PYTHONPATH", path);
        command
    }

    fn probe(&self) -> Result<Probe, ToolError> {
        let output = self.command().args(["-c", PROBE]).stdin(Stdio::null()).output();
        let output = output.map_err(|source| ToolError::NoPython {
            tool: self.program.to_string_lossy().into_owned(),
            source,
        })?;
        let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        match output.status.code() {
            Some(0) => Ok(Probe::Ready),
            Some(PACKAGES_MISSING) => Ok(Probe::Lacks(version)),
            _ => Err(ToolError::Python {
                what: self.program.to_string_lossy().into_owned(),
                fault: last_line(&output.stderr),
            }),
        }
    }

    /// Runs the author's unit tests with pytest, whose output goes to this program's streams. Returns whether none has failed.
    /// What the SDK says about sources that no test and no component can be made of goes to standard error.
    pub(crate) fn unit_tests(&self, project: &Project) -> Result<bool, ToolError> {
        let mut check = self.command();
        check.args(["-m", "backseat_sdk.build", ".", "--check"]);
        let status = check.current_dir(project.folder()).status();
        if !status.map_err(of_file(project.folder()))?.success() {
            return Err(ToolError::PythonBuild {
                folder: project.folder().to_path_buf(),
            });
        }
        let mut command = self.command();
        command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
        let status = command
            .current_dir(project.folder())
            .status()
            .map_err(of_file(project.folder()))?;
        Ok(status.success() || status.code() == Some(NO_TESTS))
    }

    /// Builds the component. What the SDK says about a plugin that cannot be imported goes to standard error.
    pub(crate) fn build(&self, project: &Project) -> Result<PathBuf, ToolError> {
        let component = project.component();
        let mut command = self.command();
        command.args(["-m", "backseat_sdk.build", "."]).arg("-o");
        // The command runs in the project's folder, where the component's name is its path.
        command.arg(component.file_name().unwrap_or(component.as_os_str()));
        command.stdout(Stdio::null()).current_dir(project.folder());
        let status = command.status().map_err(of_file(project.folder()))?;
        if status.success() {
            Ok(component)
        } else {
            Err(ToolError::PythonBuild {
                folder: project.folder().to_path_buf(),
            })
        }
    }
}

/// Runs a command to its end. What it prints is kept; the last line of its errors says why it failed.
fn run(command: &mut Command) -> Result<(), String> {
    match command.stdin(Stdio::null()).output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(last_line(&output.stderr)),
        Err(error) => Err(error.to_string()),
    }
}

fn last_line(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    last.unwrap_or("it failed without a word").trim().to_owned()
}

/// The Python sources of a folder: not those of environments and hidden folders in it.
pub(crate) fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_name().to_string_lossy().starts_with('.') || path.join("pyvenv.cfg").exists() {
            continue;
        }
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "py") {
            files.push(path);
        }
    }
}
