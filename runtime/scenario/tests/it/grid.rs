//! A seabed's grid in a mission's folder.

use std::path::{Path, PathBuf};

use backseat_mission::{Layers, Mission};
use backseat_scenario::{Scenario, ScenarioError};
use backseat_units::EastNorth;

/// A mission over a grid of 12 by 8 cells: a shelf that falls to the south-east, with a wreck's mound on it.
fn mission() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions/charted")
}

/// A copy of the mission with one file replaced or removed.
fn changed(file: &str, content: Option<&[u8]>) -> tempfile::TempDir {
    let copy = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(mission()).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, copy.path().join(path.file_name().unwrap())).unwrap();
    }
    match content {
        Some(content) => std::fs::write(copy.path().join(file), content).unwrap(),
        None => std::fs::remove_file(copy.path().join(file)).unwrap(),
    }
    copy
}

fn scenario(folder: &Path) -> Result<Scenario, ScenarioError> {
    let mission = Mission::load(folder, &Layers::default()).unwrap();
    Scenario::load(&mission)
}

fn fault(folder: &Path) -> String {
    let message = scenario(folder).err().unwrap().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn the_grid_beside_the_world_is_read_and_the_vehicle_flies_over_it() {
    let scenario = scenario(&mission()).unwrap();
    assert_eq!(
        scenario.grid.as_ref().map(|grid| (grid.columns(), grid.rows())),
        Some((12, 8))
    );
    let mut mvc = scenario.vehicle(1).unwrap();
    // The mound's top, at the centre of its cell.
    assert_eq!(mvc.world().water_depth_m(EastNorth::new(50.0, 50.0)), 14.0);
    let mut nearest_m = f64::INFINITY;
    while !mvc.mission_over()
        && let Some(due) = mvc.poll_timeout().filter(|due| due.as_secs_f64() < 2000.0)
    {
        mvc.handle_timeout(due);
        while mvc.poll_event().is_some() {}
        let truth = mvc.truth();
        nearest_m = nearest_m.min(truth.altitude_m);
        assert_eq!(truth.water_depth_m, mvc.world().water_depth_m(truth.local));
    }
    assert!(mvc.mission_over());
    // The plan keeps an altitude of 6 m over the mound.
    assert!((5.0..12.0).contains(&nearest_m), "{nearest_m}");
}

#[test]
fn a_grid_that_cannot_be_used_is_named_with_its_place() {
    let folder = changed("bed.asc", None);
    let message = fault(folder.path());
    assert!(
        message.contains("bed.asc: ") && message.contains("No such file"),
        "{message}"
    );

    let text = std::fs::read_to_string(mission().join("bed.asc")).unwrap();
    let folder = changed("bed.asc", Some(text.replacen(" 14 ", " deep ", 1).as_bytes()));
    let message = fault(folder.path());
    assert!(
        message.contains("bed.asc: grid, line ") && message.contains("deep"),
        "{message}"
    );

    let folder = changed("bed.asc", Some(b"II*\0"));
    assert!(fault(folder.path()).contains("bed.asc: grid, GeoTIFF: "));

    let folder = changed("bed.asc", None);
    std::fs::create_dir(folder.path().join("bed.asc")).unwrap();
    assert!(fault(folder.path()).contains("bed.asc: "));

    // The world of a seed is drawn over the grid, so a grid that does not fit is reported then.
    let folder = changed("bed.asc", Some(text.replacen(" 14 ", " -9999 ", 1).as_bytes()));
    let error = scenario(folder.path()).unwrap().vehicle(1).unwrap_err().to_string();
    assert!(error.contains("row 4, column 7: no data"), "{error}");
}

#[test]
fn a_plan_into_the_grids_bottom_is_refused_with_the_place() {
    let world = std::fs::read_to_string(mission().join("world.toml")).unwrap();
    let deep = world.replacen("altitude_m = 6", "depth_m = 18", 1);
    assert_ne!(deep, world);
    let folder = changed("world.toml", Some(deep.as_bytes()));
    let error = scenario(folder.path()).unwrap().vehicle(1).unwrap_err().to_string();
    assert!(error.starts_with("plan element 2: the water is 17.9"), "{error}");
    assert!(
        error.ends_with("expected at least 18.00 m: the element's depth"),
        "{error}"
    );
}

/// Draws many worlds: no mission of the project may be refused for any seed.
#[test]
fn the_projects_missions_have_enough_water_with_every_seed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for name in ["missions/isobath", "missions/plume", "tests/suite/missions/steady"] {
        let scenario = scenario(&root.join(name)).unwrap();
        for seed in 0..500 {
            let made = scenario.vehicle(seed);
            assert!(made.is_ok(), "{name}, seed {seed}: {:?}", made.err());
        }
    }
}
