use std::path::Path;

use anyhow::Result;
use backseat_plugin_tools::{Kit, Project};
use clap::Args;

use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct New {
    /// The plugin's name, such as my-survey: of its folder, its crate, its component and its table in the mission
    name: String,
}

pub(super) fn new(arguments: &New) -> Result<bool> {
    let kit = Kit::ready()?;
    let project = Project::create(Path::new("."), &arguments.name, &kit)?;
    let name = project.name();
    say!(
        "made the plugin {name} in the folder {name}, with the SDK in {}",
        kit.sdk().display()
    );
    say!("  {name}/src/lib.rs  its behavior and its unit tests");
    say!("  {name}/mission     the mission of its test flights");
    say!("try: cd {name} && backseat plugin test");
    Ok(true)
}
