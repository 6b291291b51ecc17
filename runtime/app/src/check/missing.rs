use backseat_core::Grant;
use backseat_mission::Mission;

/// The depths of the water that `[limits]` lacks although a plugin may steer by altitude.
pub(super) fn depths(mission: &Mission) -> Option<String> {
    let steers = |grant: &Grant| [Grant::Modify, Grant::Insert].contains(grant);
    if !mission.file.plugins.iter().any(|table| table.grants.iter().any(steers)) {
        return None;
    }
    let limits = &mission.file.limits;
    let missing: Vec<&str> = [
        ("water_depth_min_m", limits.water_depth_min_m),
        ("water_depth_max_m", limits.water_depth_max_m),
    ]
    .into_iter()
    .filter_map(|(key, depth_m)| depth_m.is_none().then_some(key))
    .collect();
    (!missing.is_empty()).then(|| {
        format!(
            "[limits] has no {}: only bottom lock shows how deep the water is, and a plugin's request by altitude is \
             rejected where that is not enough",
            missing.join(" and no ")
        )
    })
}
