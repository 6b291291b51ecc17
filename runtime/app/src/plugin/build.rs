use anyhow::Result;
use backseat_plugin_tools::{ComponentFile, Kit, Project};

use super::Folder;
use crate::output::{kib, say};
use crate::terminal::tell;

pub(super) fn build(arguments: &Folder) -> Result<bool> {
    let project = Project::open(&arguments.dir)?;
    build_project(&project, &Kit::ready()?)?;
    Ok(true)
}

/// Builds the component, and says what it is.
pub(super) fn build_project(project: &Project, kit: &Kit) -> Result<()> {
    let component = ComponentFile::read(&backseat_plugin_tools::build(project, kit, &tell)?)?;
    say!(
        "built {}: {} KiB, SHA-256 {}",
        component.path.display(),
        kib(component.bytes.len()),
        component.sha256
    );
    Ok(())
}
