use std::path::PathBuf;

use anyhow::Result;
use backseat_plugin_tools::Inspection;
use clap::Args;

use super::read_component;
use crate::cache::host_with;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// A component, or a plugin's folder with its component
    #[arg(value_name = "FILE.wasm|DIR", default_value = ".")]
    component: PathBuf,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn inspect(arguments: &Inspect) -> Result<bool> {
    let component = read_component(&arguments.component)?;
    let inspection = component.inspect(&host_with(true)?);
    if arguments.json {
        say!("{}", serde_json::to_string(&inspection)?);
    } else {
        print(&inspection)?;
    }
    Ok(inspection.refusal.is_none())
}

fn print(inspection: &Inspection<'_>) -> Result<()> {
    say!("{}", inspection.file.display());
    say!("  SHA-256    {}", inspection.sha256);
    say!("  size       {} bytes", inspection.bytes);
    if let Some(said) = &inspection.description {
        say!("  name       {}", said.name);
        say!("  version    {}", said.version);
        say!("  steps      every {} ms", said.step_period.as_secs_f64() * 1000.0);
        say!("  topics     {}", listed(&inspection.topics()));
        say!("  needs      {}", listed(&inspection.needed()));
    }
    say!("  interface  {}", listed(&inspection.interface));
    say!("  imports    {}", listed(inspection.imports));
    say!("  exports    {}", listed(inspection.exports));
    say!("  WASI       {}", listed(&inspection.wasi));
    if let Some(refusal) = &inspection.refusal {
        say!("no plugin that this program can run: {refusal}");
    }
    Ok(())
}

fn listed<T: AsRef<str>>(all: &[T]) -> String {
    if all.is_empty() {
        return "none".to_owned();
    }
    all.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ")
}
