use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::Command;

use crate::error::ToolError;
use crate::kit::Kit;
use crate::project::{Language, Project};
use crate::python::Python;

/// Runs the author's unit tests with `cargo test` or pytest, whose output goes to this program's streams. Returns whether
/// they passed. `tell` gets a line for the user before something that takes long.
///
/// # Errors
///
/// [`ToolError::NoSdk`] if the SDK is not where the plugin looks for it, [`ToolError::NoRust`] without cargo,
/// [`ToolError::TestsDoNotCompile`], [`ToolError::Killed`] if cargo was ended from outside,
/// [`ToolError::NoPython`] and [`ToolError::Python`] without what Python needs.
pub fn unit_tests(project: &Project, kit: &Kit, tell: &dyn Fn(&str)) -> Result<bool, ToolError> {
    if project.language() == Language::Python {
        return Python::ready(kit, tell)?.unit_tests(project);
    }
    project.require_sdk(kit)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run = |arguments: &[&str]| {
        let status = Command::new(&cargo)
            .args(arguments)
            .current_dir(project.folder())
            .status()
            .map_err(|source| ToolError::NoRust {
                tool: cargo.to_string_lossy().into_owned(),
                source,
            })?;
        // Somebody has ended it, or the computer has no memory left.
        match status.signal() {
            Some(signal) => Err(ToolError::Killed {
                what: format!("cargo {}", arguments.join(" ")),
                signal,
            }),
            None => Ok(status.success()),
        }
    };
    if !run(&["test", "--no-run"])? {
        return Err(ToolError::TestsDoNotCompile {
            folder: project.folder().to_path_buf(),
        });
    }
    run(&["test"])
}

/// Builds the component, and returns its path. The messages of Cargo, or of Python, go to standard error. `tell` gets a
/// line for the user before something that takes long.
///
/// # Errors
///
/// [`ToolError`] in one line, after the messages of the compiler if the code does not compile.
pub fn build(project: &Project, kit: &Kit, tell: &dyn Fn(&str)) -> Result<PathBuf, ToolError> {
    if project.language() == Language::Python {
        return Python::ready(kit, tell)?.build(project);
    }
    project.require_sdk(kit)?;
    let built = backseat_componentize::build(project.folder(), &[], project.folder())?;
    let component = project.component();
    if built.iter().any(|file| file.file_name() == component.file_name()) {
        Ok(component)
    } else {
        Err(ToolError::OtherPackage {
            folder: project.folder().to_path_buf(),
            name: project.name().to_owned(),
        })
    }
}
