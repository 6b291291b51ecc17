//! Man pages and completions of shells, for packages.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::cli::Cli;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct Generate {
    /// The folder: man and completions go there
    #[arg(value_name = "DIR")]
    dir: PathBuf,
}

pub(crate) fn generate(arguments: &Generate) -> Result<bool> {
    let made = |name: &str| {
        let folder = arguments.dir.join(name);
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        Ok::<_, anyhow::Error>(folder)
    };
    let command = Cli::command();
    let name = command.get_name().to_owned();
    let man = made("man")?;
    clap_mangen::generate_to(command.clone(), &man).with_context(|| man.display().to_string())?;
    let completions = made("completions")?;
    for shell in [Shell::Bash, Shell::Fish, Shell::Zsh] {
        clap_complete::generate_to(shell, &mut command.clone(), &name, &completions)
            .with_context(|| completions.display().to_string())?;
    }
    say!("{} and {}", man.display(), completions.display());
    Ok(true)
}
