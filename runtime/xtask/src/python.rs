use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::cargo::{root, run};
use crate::cross::python as environment;
use crate::demo::release;
use crate::plugins;
use crate::steps::Steps;
use crate::wheel::wheel;

/// What makes a component of a plugin in Python, and the runner of the tests.
const PACKAGES: [&str; 2] = ["componentize-py==0.25.1", "pytest==9.2.0"];
/// The SDK for Python, from the root of the workspace.
const SDK: &str = "plugins/python";
/// The folders with tests that need neither the program nor a component. In a plugin's folder, `plugin` is its module, so
/// each folder has a process of its own.
const UNIT_TESTS: [&str; 3] = ["tests", "template", "thermocline"];
/// The plugins that missions name, with the names of their components.
const PLUGINS: [(&str, &str); 2] = [("template", "template-python"), ("thermocline", "thermocline")];

/// Tests the SDK for Python and its plugins, builds the components of those that missions name, and builds and tests the
/// package `backseat` for studies.
pub(crate) fn python() -> Result<()> {
    let mut steps = Steps::default();
    let result = python_in(&mut steps);
    steps.show();
    result
}

fn python_in(steps: &mut Steps) -> Result<()> {
    let program = steps.run("compile the program", release)?;
    let interpreter = environment("python-plugins", &PACKAGES)?.join("python");
    steps.run("unit tests", || {
        UNIT_TESTS
            .into_iter()
            .try_for_each(|folder| test(&interpreter, folder, &program))
    })?;
    steps.run("compile the plugins", || {
        PLUGINS
            .into_iter()
            .try_for_each(|(folder, name)| build(&interpreter, folder, name))
    })?;
    steps.run("flights", || test(&interpreter, "flights", &program))?;
    wheel(steps, &program)
}

/// Runs the tests of a folder of the SDK, without leaving files in the tree.
fn test(interpreter: &Path, folder: &str, program: &Path) -> Result<()> {
    let folder = root()?.join(SDK).join(folder);
    println!("> pytest {}", folder.display());
    let mut command = with_sdk(interpreter)?;
    command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir"]);
    run(command.arg(&folder).arg(&folder).env("BACKSEAT_TEST_PROGRAM", program))
}

/// Builds a plugin's component into the folder of all components.
fn build(interpreter: &Path, folder: &str, name: &str) -> Result<()> {
    let component = plugins::folder()?.join(format!("{name}.wasm"));
    let mut command = with_sdk(interpreter)?;
    command
        .args(["-m", "backseat_sdk.build"])
        .arg(root()?.join(SDK).join(folder));
    run(command.arg("-o").arg(component))
}

/// The interpreter, which finds the SDK.
fn with_sdk(interpreter: &Path) -> Result<Command> {
    let mut command = Command::new(interpreter);
    command.arg("-B").env("PYTHONPATH", root()?.join(SDK));
    Ok(command)
}
