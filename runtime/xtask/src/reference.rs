use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use backseat_reference::{REFERENCES, exit_page, page, schema};

use crate::cargo::root;
use crate::sonar_page;

/// Every file that is made from the tables of `runtime/reference` and `runtime/s7k`, with its text.
fn generated() -> Result<Vec<(PathBuf, String)>> {
    let root = root()?;
    let pages = root.join("runtime/docs/reference");
    let schemas = root.join("missions/schemas");
    let mut files = vec![
        (pages.join("exit-codes.md"), exit_page()),
        (pages.join("7k.md"), sonar_page::page()),
    ];
    for reference in REFERENCES.iter() {
        files.push((pages.join(format!("{}.md", reference.name)), page(reference)));
        if reference.has_schema() {
            let path = schemas.join(format!("{}.schema.json", reference.name));
            files.push((path, format!("{:#}\n", schema(reference))));
        }
    }
    Ok(files)
}

/// Writes the pages and schemas anew.
pub(crate) fn reference() -> Result<()> {
    for (path, text) in generated()? {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        fs::write(&path, text).with_context(|| path.display().to_string())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_and_schemas_are_those_of_the_tables() {
        for (path, text) in generated().unwrap() {
            let written = fs::read_to_string(&path).unwrap_or_default();
            assert!(written == text, "{}: run `cargo xtask reference`", path.display());
        }
    }
}
