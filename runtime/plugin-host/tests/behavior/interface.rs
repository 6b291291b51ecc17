//! The files of `wit/`: a version that was released is never edited, and each field of the newest is documented.

use std::fs;
use std::path::PathBuf;

use sha2::{Digest, Sha256};

fn text(version: &str) -> String {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../wit"));
    fs::read_to_string(path.join(version).join("plugin.wit")).unwrap()
}

#[test]
fn a_released_version_is_never_edited() {
    for (version, released) in [
        (
            "v0.1.0",
            "5fba741049522ee1a0b29105499ff6593dfb15382aba10d3fd6c6ceb07c89470",
        ),
        (
            "v0.2.0",
            "9198e48d2559f24d933e81ebb349c0ae640a5a7c6302f4786a1b6a21fefeaff7",
        ),
    ] {
        let hash: String = Sha256::digest(text(version))
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        assert_eq!(
            hash, released,
            "wit/{version} has been released: plugins were built with it. Make a new version beside it"
        );
    }
}

#[test]
fn each_field_case_and_function_of_the_newest_version_is_documented() {
    let text = text("v0.2.0");
    let mut before = "";
    let mut seen = 0;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        let item =
            line.ends_with(',') || line.contains(": func(") || line.starts_with("record ") || line.starts_with("type ");
        if item && !line.starts_with("//") {
            seen += 1;
            assert!(before.starts_with("///"), "line {}: {line}", number + 1);
        }
        before = line;
    }
    assert!(seen > 500, "{seen} items");
}
