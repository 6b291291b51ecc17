//! The tutorial, every command of it, in a folder outside of this project.

use std::path::Path;
use std::process::Command;

use super::{kit, target};
use crate::real_time::pages::script;

#[test]
fn the_adaptive_lawnmower_flies_as_its_tutorial_says() {
    let place = tempfile::tempdir().unwrap();
    let program = backseat_test_support::program();
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("bash")
        .args(["-eu", "-o", "pipefail", "-c"])
        .arg(script("runtime/docs/adaptive-lawnmower.md"))
        .current_dir(place.path())
        .env("PATH", format!("{}:{path}", program.parent().unwrap().display()))
        .env("BACKSEAT_KIT", kit())
        .env("BACKSEAT_CACHE", backseat_test_support::cache())
        .env("CARGO_TARGET_DIR", target())
        .env("CARGO_NET_OFFLINE", "true")
        .env_remove("BACKSEAT_PLUGINS")
        .output()
        .expect("bash starts");
    let told = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}\n{errors}");
    assert!(
        told.contains("unit tests passed, 5 of 5 flights met what is expected"),
        "{told}\n{errors}"
    );
    assert!(errors.contains("degrees, so 30 m on"), "{errors}");
    // The report of the flight, and then pairs: the adaptive lawnmower, and even lines over the same sea.
    let shares: Vec<f64> = told
        .lines()
        .filter_map(|line| {
            line.trim()
                .strip_prefix("lawnmower.warm_share ")?
                .strip_suffix(" %")?
                .parse()
                .ok()
        })
        .collect();
    assert_eq!(shares.len(), 11, "{told}");
    for pair in shares[1..].chunks(2) {
        assert!(pair[0] > 1.2 * pair[1], "{shares:?}");
    }
    let picture = std::fs::read_to_string(Path::new(place.path()).join("lawnmower/adaptive.svg")).unwrap();
    assert!(picture.starts_with("<svg"));
}
