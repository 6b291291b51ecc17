//! Lists the files that the program carries, so that a plugin can be made where this repository is not. Cargo runs this
//! again, and compiles the crate again, when one of them changes, comes or goes.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The files and folders of the kit, from the workspace's folder.
const KIT: [&str; 11] = [
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "missions/template",
    "plugins/python/backseat_sdk",
    "plugins/python/template",
    "plugins/sdk/Cargo.toml",
    "plugins/sdk/src",
    "plugins/template",
    "runtime/units/Cargo.toml",
    "runtime/units/src",
    "wit",
];

fn main() -> std::io::Result<()> {
    let here = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let workspace = here.join("../..").canonicalize()?;
    let mut files = Vec::new();
    for part in KIT {
        collect(&workspace.join(part), &mut files)?;
    }
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        let name = file.strip_prefix(&workspace).unwrap_or(&file);
        // A path of this project is plain ASCII with slashes.
        let _written = writeln!(
            list,
            "    ({:?}, include_bytes!({file:?})),",
            name.display().to_string()
        );
    }
    list.push_str("]\n");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("kit.rs"), list)?;
    for (name, constant) in [("Cargo.toml", "workspace.rs"), ("Cargo.lock", "lock.rs")] {
        let file = workspace.join(name);
        println!("cargo::rerun-if-changed={}", file.display());
        fs::write(out.join(constant), format!("include_str!({file:?})\n"))?;
    }
    println!("cargo::rerun-if-changed=build.rs");
    Ok(())
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    // What Python leaves beside its sources is not a part of the kit.
    if path.ends_with("__pycache__") {
        return Ok(());
    }
    println!("cargo::rerun-if-changed={}", path.display());
    if path.is_dir() {
        for entry in fs::read_dir(path)? {
            collect(&entry?.path(), files)?;
        }
    } else {
        files.push(path.to_path_buf());
    }
    Ok(())
}
