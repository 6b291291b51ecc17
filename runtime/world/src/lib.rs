//! What only simulation knows: seabed, current, scalar fields; seeded.
