use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::cargo::{add_target, root, run, target};
use crate::demo::release;

/// The folder of the project's plugins as components.
pub(crate) fn folder() -> Result<PathBuf> {
    Ok(target()?.join("plugins"))
}

/// Builds every plugin in the folder `plugins`, with a release build of the program for it.
pub(crate) fn plugins() -> Result<()> {
    build(&release()?.with_file_name("backseat-componentize"))
}

/// Builds every plugin in the folder `plugins` as a component, with this program.
pub(crate) fn build(componentize: &Path) -> Result<()> {
    add_target("wasm32-unknown-unknown")?;
    run(Command::new(componentize).arg(root()?).arg(folder()?))
}
