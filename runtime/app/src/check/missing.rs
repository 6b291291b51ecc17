use backseat_core::plugin::Topic;
use backseat_core::{Grant, PluginSetup};
use backseat_mission::Mission;

/// Topics that are about something for which a plugin can also ask, and the grant that it then needs.
const ASKED_FOR: [(Topic, &str, Grant); 4] = [
    (Topic::Acoustic, "acoustic packets", Grant::Acoustic),
    (Topic::Trim, "trim", Grant::Trim),
    (Topic::Buoyancy, "buoyancy", Grant::Buoyancy),
    (Topic::RelativeNavigation, "relative navigation", Grant::Station),
];

/// Plugins that listen to something and may not ask for it. That can be meant, so it is a warning.
pub(super) fn grants(mission: &Mission, setups: &[PluginSetup]) -> Vec<String> {
    let mut lines = Vec::new();
    for (setup, table) in setups.iter().zip(&mission.file.plugins) {
        for (topic, what, grant) in ASKED_FOR {
            if setup.description.topics.contains(&topic) && !table.grants.contains(&grant) {
                lines.push(format!(
                    "plugin {}: listens to {what}, but grants has no \"{}\": the runtime will reject such requests",
                    setup.name,
                    grant.name()
                ));
            }
        }
    }
    lines
}

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
