use std::path::{Path, PathBuf};
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
    let (log, long_log) = (folder.join("isobath.mcap"), folder.join("ten-hours.mcap"));
    steps.run("a log, and one of ten hours", || {
        let mission = root()?.join("missions/isobath");
        simulate(&program, &mission, &log)?;
        simulate(&program, &longer(&mission, &folder.join("ten-hours"))?, &long_log)
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
        ("a dive of ten hours in Chromium", "long.mjs"),
        ("pictures", "shots.mjs"),
    ] {
        steps.run(step, || {
            println!("> node {file}");
            run(Command::new("node")
                .arg(browser.join(file))
                .env("CONSOLE_PYTHON", &interpreter)
                .env("CONSOLE_MODULES", &modules)
                .env("CONSOLE_LOG", &log)
                .env("CONSOLE_LONG_LOG", &long_log)
                .env("CONSOLE_PROGRAM", &program)
                .env("CONSOLE_SHOTS", &folder))
        })?;
    }
    println!("pictures: {}", folder.display());
    Ok(())
}

fn simulate(program: &Path, mission: &Path, log: &Path) -> Result<()> {
    run(Command::new(program)
        .arg("sim")
        .arg(mission)
        .arg("--plugins")
        .arg(plugins::folder()?)
        .arg("--log")
        .arg(log))
}

/// A copy of `missions/isobath` whose plan leads ten times along the contour and back.
fn longer(mission: &Path, copy: &Path) -> Result<PathBuf> {
    const TIMES: usize = 10;
    const BACK: &str =
        "[[plan]]\nkind = \"waypoint\"\nat = { east_m = -1200, north_m = 0 }\ndepth_m = 8\nspeed_mps = 1.5\n\n";
    std::fs::create_dir_all(copy)?;
    for name in ["mission.toml", "fence.geojson"] {
        std::fs::copy(mission.join(name), copy.join(name)).with_context(|| name.to_owned())?;
    }
    let world = std::fs::read_to_string(mission.join("world.toml"))?;
    let (before, rest) = world.split_once("[[plan]]").context("world.toml has no plan")?;
    let (plan, _) = rest.split_once("[expect]").context("world.toml expects nothing")?;
    let plan = format!("[[plan]]{plan}{BACK}").repeat(TIMES);
    std::fs::write(copy.join("world.toml"), format!("{before}{plan}"))?;
    Ok(copy.to_owned())
}
