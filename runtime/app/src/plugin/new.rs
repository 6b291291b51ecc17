use std::path::Path;

use anyhow::Result;
use backseat_plugin_tools::{Kit, Language, Project};
use clap::{Args, ValueEnum};

use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct New {
    /// The plugin's name, such as my-survey: of its folder, its crate, its component and its table in the mission
    name: String,
    /// The language of the plugin
    #[arg(long, default_value = "rust", value_enum)]
    lang: Lang,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Lang {
    /// Needs Rust 1.95 or later with the target wasm32-unknown-unknown
    Rust,
    /// Needs Python 3.11 or later. The standard library is there in the sandbox, numpy is not
    Python,
}

pub(super) fn new(arguments: &New) -> Result<bool> {
    let kit = Kit::ready()?;
    let language = match arguments.lang {
        Lang::Rust => Language::Rust,
        Lang::Python => Language::Python,
    };
    let project = Project::create(Path::new("."), &arguments.name, language, &kit)?;
    let name = project.name();
    let sdk = match language {
        Language::Rust => kit.sdk(),
        Language::Python => kit.python_sdk(),
    };
    say!(
        "made the plugin {name} in the folder {name}, with the SDK in {}",
        sdk.display()
    );
    match language {
        Language::Rust => say!("  {name}/src/lib.rs  its behavior and its unit tests"),
        Language::Python => {
            say!("  {name}/plugin.py       its behavior");
            say!("  {name}/test_plugin.py  its unit tests");
        }
    }
    say!("  {name}/mission     the mission of its test flights");
    say!("try: cd {name} && backseat plugin test");
    say!(
        "     (the first time takes some minutes: {})",
        match language {
            Language::Rust => "it compiles the SDK and its libraries",
            Language::Python => "it fetches the tools and compiles Python",
        }
    );
    Ok(true)
}
