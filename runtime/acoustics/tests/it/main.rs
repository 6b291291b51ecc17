//! What simulated sonars see.

mod geometry;
mod hostile;
mod levels;
mod repeatable;
mod scene;
mod subbottom;
mod targets;
mod textures;
