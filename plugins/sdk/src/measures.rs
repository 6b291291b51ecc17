//! Publishing named values: what a plugin estimates, how sure it is, how far it has come.
//!
//! The log has a channel for each name, and the last value of each name is the run's measure `PLUGIN.NAME`: the report of
//! `backseat sim` has it, and `[[expect.measure]]` of `world.toml` judges a run by it. Publishing changes nothing else.
//!
//! A name is 1 to 48 of a-z, 0-9 and _, and begins with a letter; a unit is at most 16 bytes and may be empty; a value is
//! finite. A plugin may use 64 names, and 64 values are kept a second, with a burst of twice as many. What does not fit is
//! dropped, and a line in the log counts it and says why. Each value costs fuel.
//!
//! ```
//! backseat_sdk::measures::publish("water_depth", 41.5, "m");
//! ```

/// Publishes a value; on the host, to a `testing::Harness`, or to standard error.
pub fn publish(name: &str, value: f64, unit: &str) {
    #[cfg(target_arch = "wasm32")]
    crate::bindings::backseat::plugin::measures::publish(name, value, unit);
    #[cfg(not(target_arch = "wasm32"))]
    crate::host::publish(name, value, unit);
}
