use std::path::Path;
use std::process::{Command, Output};

use backseat_test_support::plugins;

fn hunt(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_backseat-hunt"))
        .arg("--plugins")
        .arg(plugins())
        .args(arguments)
        .output()
        .expect("the hunt can be started")
}

fn fly(folder: &Path, first: u64, runs: u64) -> String {
    let path = folder.join(format!("{first}-{runs}.json")).display().to_string();
    let (first, runs) = (first.to_string(), runs.to_string());
    let flown = hunt(&["fly", "--first", &first, "--runs", &runs, "--coverage", &path]);
    assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
    path
}

#[test]
fn hunts_add_up_to_what_one_would_have_been() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (fly(folder.path(), 1, 2), fly(folder.path(), 3, 3));
    let whole = fly(folder.path(), 1, 5);
    let told = |output: Output| {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let summed = told(hunt(&["sum", &second, &first]));
    assert!(summed.starts_with("5 missions, "), "{summed}");
    assert_eq!(summed, told(hunt(&["sum", &whole])));
    // No mission may count twice.
    let twice = hunt(&["sum", &first, &whole]);
    assert_eq!(twice.status.code(), Some(2));
    let text = String::from_utf8_lossy(&twice.stderr);
    assert!(text.contains("same seeds"), "{text}");
}
