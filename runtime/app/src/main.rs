//! The `backseat` program.
fn main() {}
