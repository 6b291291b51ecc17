//! Missions on disk: mission.toml, fence.geojson, world.toml.
