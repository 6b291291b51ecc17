//! Geofences: inclusion and exclusion polygons, depth and altitude bands, swept-shape checks.
