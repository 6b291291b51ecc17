//! What a plugin's author depends on.
