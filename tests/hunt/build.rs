//! Computes the tree hash, which identifies the sources that a build of the simulated crates was made from.

use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// The crates whose sources decide the course of a flight.
const CRATES: [&str; 6] = ["core", "fence", "mvc", "oracle", "sim", "spi"];

fn main() -> io::Result<()> {
    // Read at run time, because a build folder, and this program in it, may have been copied from another clone.
    let here =
        env::var_os("CARGO_MANIFEST_DIR").ok_or_else(|| io::Error::other("cargo did not set CARGO_MANIFEST_DIR"))?;
    let runtime = Path::new(&here).join("../../runtime");
    let mut files = Vec::new();
    let mut each = Vec::new();
    for name in CRATES {
        let sources = runtime.join(name).join("src");
        println!("cargo:rerun-if-changed={}", sources.display());
        let mut own = Vec::new();
        gather(&sources, &format!("{name}/src"), &mut own)?;
        own.sort();
        each.push(format!("{name} {}", hash(&own)?));
        files.append(&mut own);
    }
    files.sort();
    println!("cargo:rustc-env=BACKSEAT_TREE={}", hash(&files)?);
    println!("cargo:rustc-env=BACKSEAT_TREES={}", each.join(","));
    Ok(())
}

/// SHA-256 of files with their names, as hexadecimal digits.
fn hash(files: &[(String, PathBuf)]) -> io::Result<String> {
    let mut digest = Sha256::new();
    for (name, path) in files {
        let content = fs::read(path)?;
        // The lengths separate the end of one file from the beginning of the next.
        digest.update((name.len() as u64).to_le_bytes());
        digest.update(name);
        digest.update((content.len() as u64).to_le_bytes());
        digest.update(content);
    }
    Ok(digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// All files under a folder, with the names that they have in every clone. Not those that have only tests: they change no
/// flight.
fn gather(folder: &Path, name: &str, files: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, name) = (entry.path(), format!("{name}/{}", entry.file_name().to_string_lossy()));
        if ["tests", "tests.rs"].iter().any(|tests| entry.file_name() == *tests) {
            continue;
        }
        if path.is_dir() {
            gather(&path, &name, files)?;
        } else {
            files.push((name, path));
        }
    }
    Ok(())
}
