use std::process::Command;

use anyhow::{Context, Result};

use crate::cargo::{root, run, target};
use crate::cross::python as environment;
use crate::demo::release;
use crate::plugins;
use crate::steps::Steps;

/// What the mock of the page reads logs with, and what drives the browser.
const PACKAGES: [&str; 1] = ["mcap==1.6.0"];
const DRIVER: &str = "playwright-core@1.65.1";

/// Tests the console's page in Chromium against a mock of the program, and takes pictures of it.
pub(crate) fn console() -> Result<()> {
    let mut steps = Steps::default();
    let result = console_in(&mut steps);
    steps.show();
    result
}

fn console_in(steps: &mut Steps) -> Result<()> {
    let program = steps.run("compile the program", release)?;
    steps.run("compile the plugins", plugins::plugins)?;
    let interpreter = environment("console", &PACKAGES)?.join("python");
    let folder = target()?.join("console");
    std::fs::create_dir_all(&folder)?;
    let log = folder.join("isobath.mcap");
    steps.run("a log", || {
        let mission = root()?.join("missions/isobath");
        let plugins = plugins::folder()?;
        run(Command::new(&program)
            .arg("sim")
            .arg(mission)
            .arg("--plugins")
            .arg(plugins)
            .arg("--log")
            .arg(&log))
    })?;
    let modules = target()?.join("tools/console-browser");
    std::fs::create_dir_all(&modules)?;
    println!("> npm install {DRIVER}");
    run(Command::new("npm")
        .args(["install", "--no-save", "--silent", "--prefix"])
        .arg(&modules)
        .arg(DRIVER))
    .context("Node 20 with npm is needed")?;
    let browser = root()?.join("runtime/console/browser/tests");
    for (step, file) in [
        ("the page's store", "store.mjs"),
        ("contrast", "contrast.mjs"),
        ("the page in Chromium", "console.mjs"),
        ("pictures", "shots.mjs"),
    ] {
        steps.run(step, || {
            println!("> node {file}");
            run(Command::new("node")
                .arg(browser.join(file))
                .env("CONSOLE_PYTHON", &interpreter)
                .env("CONSOLE_MODULES", &modules)
                .env("CONSOLE_LOG", &log)
                .env("CONSOLE_SHOTS", &folder))
        })?;
    }
    println!("pictures: {}", folder.display());
    Ok(())
}
