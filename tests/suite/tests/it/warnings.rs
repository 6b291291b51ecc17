//! Warnings of `backseat check`: what prevents no dive, and is probably not meant.

use backseat_suite::{Backseat, Mission};

use crate::predive::{has, ready};

#[test]
fn a_world_beyond_the_limits_is_a_warning() {
    let mission = Mission::steady();
    let limits = ["limits.current_max_mps=0.01", "limits.navigation_error_m=0.1"];
    let rough = mission.append("world.toml", "[sensors]\nposition_noise_m = 0.5").edit(
        "world.toml",
        "[seabed]",
        "[current]\nspeed_mps = 0.2\n\n[seabed]",
    );
    for limit in limits {
        let key = limit.split('=').next().unwrap_or_default();
        has(&ready(&rough, &["--set", limit]), &["warning: world:", key]);
    }
    let flown = Backseat::new().args(["sim", "--set", limits[0]]).mission(&rough).run();
    has(&flown.stderr, &["WARN", "world: current up to 0.20 m/s"]);
}

#[test]
fn water_of_unknown_depth_is_a_warning_if_a_plugin_steers() {
    let steady = Mission::steady();
    assert!(!ready(&steady, &[]).contains("warning: [limits]"));
    let deep = steady.edit("mission.toml", "water_depth_max_m = 55.0\n", "");
    has(
        &ready(&deep, &[]),
        &["warning: [limits] has no water_depth_max_m: only bottom lock"],
    );
    let unknown = deep.edit("mission.toml", "water_depth_min_m = 45.0\n", "");
    has(
        &ready(&unknown, &[]),
        &["warning: [limits] has no water_depth_min_m and no water_depth_max_m"],
    );
    // Station keeping has boxes of its own.
    assert!(!ready(&Mission::copy("hull-inspection"), &[]).contains("warning: [limits]"));
}

#[test]
fn a_grant_that_a_plugin_needs_is_named() {
    let granted = Mission::copy("trim-and-buoyancy");
    ready(&granted, &[]);
    let trim = granted.edit("mission.toml", "\"buoyancy\", ", "");
    let refused = Backseat::new().arg("check").mission(&trim).run().exit(1);
    has(
        &refused.stdout,
        &["): needs the grant buoyancy: add it to `grants` of this plugin in mission.toml"],
    );
}

#[test]
fn a_world_in_which_plugins_can_do_nothing_is_a_warning() {
    let never = Mission::steady().edit("world.toml", "dynamic = true\n", "");
    has(
        &ready(&never, &[]),
        &["warning: world: no [[plan]] has dynamic = true", "never gives control"],
    );
    let always = never.edit("world.toml", "[mission]", "[mission]\ncontrol = \"mission\"");
    assert!(!ready(&always, &[]).contains("never gives control"));

    let text = std::fs::read_to_string(Mission::steady().path().join("fence.geojson")).expect("it has a fence");
    let mut fence: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    swap(&mut fence);
    let swapped = Mission::steady();
    std::fs::write(swapped.path().join("fence.geojson"), fence.to_string()).expect("it can be written");
    let line = Backseat::new().arg("check").mission(&swapped).run().exit(1);
    has(
        &line.stdout,
        &["warning: world: [origin]", "latitude and longitude are swapped"],
    );
}

/// Swaps the two numbers of each position.
fn swap(value: &mut serde_json::Value) {
    if let Some(items) = value.as_array_mut() {
        if items.len() == 2 && items.iter().all(serde_json::Value::is_number) {
            items.swap(0, 1);
        } else {
            items.iter_mut().for_each(swap);
        }
    } else if let Some(object) = value.as_object_mut() {
        object.values_mut().for_each(swap);
    }
}
