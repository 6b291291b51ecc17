use backseat_units::OutOfRange;

/// A world that cannot be: which key, and what was expected there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A number outside what its key allows.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its section: `seabed.depth_m`.
        key: &'static str,
        /// The number that was given (the offending end of a span).
        value: f64,
        /// What is allowed, in words.
        expected: &'static str,
    },
    /// The origin is not on the globe.
    #[error("origin: {0}")]
    Origin(#[from] OutOfRange),
}

/// Checks one number of a configuration.
pub(crate) fn check(ok: bool, key: &'static str, value: f64, expected: &'static str) -> Result<(), WorldError> {
    if ok {
        Ok(())
    } else {
        Err(WorldError::Value { key, value, expected })
    }
}
