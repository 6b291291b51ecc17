//! Inputs and outputs that cannot be used: each is one line with the path, what is wrong and what to do.

use std::path::Path;
use std::process::Command;

use backseat_s7k_tools::{Selection, Source, cut, info};
use tempfile::TempDir;

use crate::compose;
use crate::tools::recording;

fn refused(path: &Path) -> String {
    let error = Source::open(path).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error.replace(&format!("{}: ", path.display()), "")
}

#[test]
fn what_is_no_recording_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    assert_eq!(
        refused(&path("none.s7k")),
        "cannot read: No such file or directory (os error 2)"
    );
    assert_eq!(refused(folder.path()), "is a folder: give a recording (.s7k) in it");
    std::fs::write(path("empty.s7k"), b"").unwrap();
    assert_eq!(
        refused(&path("empty.s7k")),
        "is empty: give a recording (.s7k) with at least one record"
    );
    std::fs::write(path("text.s7k"), "no records in here. ".repeat(50_000)).unwrap();
    assert_eq!(
        refused(&path("text.s7k")),
        "is not a 7k recording: no record in its 1000000 bytes (no frame starts here: the sync pattern is 0x726f6365 \
         instead of 0x0000ffff): give a .s7k file"
    );
    // A frame of an older protocol: version 3, and the sync pattern.
    std::fs::write(path("old.s7k"), [3, 0, 48, 0, 255, 255, 0, 0].repeat(20)).unwrap();
    let old = refused(&path("old.s7k"));
    assert!(old.contains("protocol version 3 is not supported"), "{old}");
    let pipe = path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert_eq!(
        refused(&pipe),
        "is a pipe or a device, and the input is read more than once: save it to a file first"
    );
}

#[test]
fn a_recording_cut_anywhere_is_read_as_far_as_it_goes() {
    let bytes = compose::clean();
    let mut before = 0;
    for length in (200..bytes.len()).step_by(bytes.len() / 37) {
        let (_folder, path) = recording(&bytes[..length]);
        match Source::open(&path) {
            Ok(source) => {
                let info = info(&source).unwrap();
                let records: u64 = info.groups.iter().map(|group| group.bytes).sum();
                assert_eq!(records + info.damage.bytes, length as u64);
                assert!(info.records >= before, "{length}");
                before = info.records;
            }
            Err(error) => assert!(length < 500, "{length}: {error}"),
        }
    }
    assert!(before > 800, "{before}");
}

#[test]
fn an_output_that_cannot_be_written_is_named_and_leaves_nothing() {
    let (folder, path) = recording(&compose::clean());
    let source = Source::open(&path).unwrap();
    let all = Selection::default();
    let refused = |out: &Path| cut(&source, &all, out).unwrap_err().to_string();
    assert_eq!(
        refused(folder.path()),
        format!("{}: is a folder: name a file in it", folder.path().display())
    );
    let nowhere = folder.path().join("none/cut.s7k");
    assert_eq!(
        refused(&nowhere),
        format!(
            "{}: cannot write: No such file or directory (os error 2): create the folder first, or choose another \
             place with --out",
            nowhere.display()
        )
    );
    let full = refused(Path::new("/dev/full"));
    assert_eq!(
        full,
        "/dev/full: cannot write: No space left on device (os error 28): free some space, or choose another place with \
         --out"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
