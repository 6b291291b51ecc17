//! Works out the tree hash: which sources of what flies a build was made from.

use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// The crates whose sources make a flight what it is.
const CRATES: [&str; 6] = ["core", "fence", "mvc", "oracle", "sim", "spi"];

fn main() -> io::Result<()> {
    // Asked when it runs: a build folder may have been taken over from another clone, and this program with it.
    let here = env::var_os("CARGO_MANIFEST_DIR").ok_or_else(|| io::Error::other("cargo says no folder"))?;
    let runtime = Path::new(&here).join("../../runtime");
    let mut files = Vec::new();
    for name in CRATES {
        let sources = runtime.join(name).join("src");
        println!("cargo:rerun-if-changed={}", sources.display());
        gather(&sources, &format!("{name}/src"), &mut files)?;
    }
    files.sort();
    let mut digest = Sha256::new();
    for (name, path) in files {
        let content = fs::read(path)?;
        // The lengths keep one file's end apart from the next one's begin.
        digest.update((name.len() as u64).to_le_bytes());
        digest.update(name);
        digest.update((content.len() as u64).to_le_bytes());
        digest.update(content);
    }
    let hash: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    println!("cargo:rustc-env=BACKSEAT_TREE={hash}");
    Ok(())
}

/// All files under a folder, with the names that they have in every clone.
fn gather(folder: &Path, name: &str, files: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, name) = (entry.path(), format!("{name}/{}", entry.file_name().to_string_lossy()));
        if path.is_dir() {
            gather(&path, &name, files)?;
        } else {
            files.push((name, path));
        }
    }
    Ok(())
}
