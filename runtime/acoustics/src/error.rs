/// A setting or a pose that a sonar refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{key} is {value}, expected {expected}")]
pub struct AcousticsError {
    /// The field.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// What was expected.
    pub expected: &'static str,
}

/// Checks one number. NaN fails.
pub(crate) fn within(
    value: f64,
    least: f64,
    most: f64,
    key: &'static str,
    expected: &'static str,
) -> Result<(), AcousticsError> {
    if value >= least && value <= most {
        Ok(())
    } else {
        Err(AcousticsError { key, value, expected })
    }
}
