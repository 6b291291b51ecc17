//! `world.toml`.

use std::path::Path;

use backseat_mvc::WorldFile;
use backseat_plc::PlcConfig;
use backseat_reference::Reference;
use backseat_world::{Grid, Span, World};
use toml::{Table, Value};

use crate::document::place;
use crate::held;

/// What `seabed.grid` names: a slope.
const GRID: &str = "ncols 3\nnrows 3\nxllcenter -70.701\nyllcenter 42.349\ncellsize 0.001\n\
    60 61 62\n58 59 60\n56 57 58\n";

fn reference() -> &'static Reference {
    Reference::of("world.toml").expect("it is registered")
}

/// What the code makes of a file: the file as it was parsed, and for keys whose default is not in its type, what is made of
/// them.
fn read(document: &Table) -> Result<String, String> {
    let mut document = document.clone();
    if document
        .get("hovering")
        .is_some_and(|hovering| hovering.get("hull").is_some())
    {
        // Only a hovering vehicle may be beside a ship, and it is slow.
        place(&mut document, "vehicle").insert("class".to_owned(), Value::String("hovering".to_owned()));
        place(&mut document, "plan").insert("speed_mps".to_owned(), Value::Float(0.5));
    }
    let plan = place(&mut document, "plan");
    if plan.contains_key("start") && plan.get("start") == plan.get("end") {
        // The two have the same keys, and so the same examples.
        place(&mut document, "plan.end").insert("north_m".to_owned(), Value::Float(-400.0));
    }
    let text = toml::to_string(&document).expect("documents are TOML");
    let mut file = WorldFile::from_toml(&text).map_err(|error| {
        // A number that the interface does not define: serde lists the word, and a check refuses it.
        error.to_string().replace(", `other`", "")
    })?;
    let mut plc = backseat_scenario::read_controller(Path::new(""), &text).map_err(|error| error.to_string())?;
    // Keys of a fault without a value have one in the plan.
    let faults = plc.as_ref().map(PlcConfig::plan).transpose();
    let faults = faults.map_err(|error| error.to_string())?;
    plc.iter_mut().for_each(|plc| plc.fault.clear());
    let frame = file.world_config().frame().map_err(|error| error.to_string())?;
    let plan = backseat_plan::resolve(&file.plan, &frame, &file.vehicle.limits()).map_err(|error| error.to_string())?;
    let world = world(&file)?;
    // What stands in `plan` and `world` would differ where a default is written out.
    file.plan.clear();
    (file.seabed.grid_frame, file.seabed.grid_positive) = (None, None);
    for plume in &mut file.field.plumes {
        plume.sigma_depth_m = None;
    }
    for filament in &mut file.field.filaments {
        filament.sigma_depth_m = None;
    }
    Ok(format!("{file:?} {plan:?} {world} {plc:?} {faults:?}"))
}

/// The world of a seed.
fn world(file: &WorldFile) -> Result<String, String> {
    let mut config = file.world_config();
    // The thickness of what has no depth has no effect.
    for plume in &mut config.field.plumes {
        plume.depth_m.get_or_insert(Span::fixed(10.0));
    }
    for filament in &mut config.field.filaments {
        filament.depth_m.get_or_insert(Span::fixed(10.0));
    }
    let named = config.seabed.grid.is_some();
    let grid = named.then(|| Grid::from_bytes(GRID.as_bytes()).expect("it is a grid"));
    match World::with_grid(&config, 1, grid) {
        Ok(world) => Ok(format!("{world:?}")),
        Err(error) => Err(error.to_string()),
    }
}

#[test]
fn every_key_of_world_toml_has_an_entry() {
    held::none(&held::keys(reference(), &read));
}

#[test]
fn examples_defaults_and_required_keys_of_world_toml_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_world_toml_are_the_codes() {
    let elsewhere = [
        // The vehicle of these files stays 2 m above the seabed.
        "plan.altitude_m",
        // It is no hovering vehicle, which alone may stand still.
        "plan.speed_mps",
    ];
    held::none(&held::bounds(reference(), &elsewhere, &read));
}

#[test]
fn keys_of_world_toml_stand_with_those_that_they_need() {
    held::none(&held::company(reference(), &read));
}
