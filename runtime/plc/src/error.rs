/// What is wrong with the table `[plc]`: the key, what was found, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlcError {
    /// A value that its key does not allow.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its table: `plc.disk.capacity_mb`.
        key: String,
        /// What was found.
        value: String,
        /// What is allowed, in words.
        expected: String,
    },
    /// A fault with a missing, superfluous or invalid key.
    #[error("plc fault {number}: {fault}")]
    Fault {
        /// Its number in the file, from 1.
        number: u32,
        /// The key, what is wrong and what was expected.
        fault: String,
    },
    /// A stored run list or setting that cannot be read.
    #[error("{file}, line {line}: {fault}")]
    Stored {
        /// The file: `6046.sav` or `6046.cfg`.
        file: &'static str,
        /// The line, from 1.
        line: usize,
        /// What is wrong and what was expected.
        fault: String,
    },
}

/// An error with key and value unless `ok`.
pub(crate) fn check(ok: bool, key: &str, value: impl core::fmt::Display, expected: &str) -> Result<(), PlcError> {
    if ok {
        return Ok(());
    }
    Err(PlcError::Value {
        key: key.to_owned(),
        value: value.to_string(),
        expected: expected.to_owned(),
    })
}

/// An error unless the value is in the range; NaN is in none.
pub(crate) fn within(value: f64, least: f64, most: f64, key: &str, unit: &str) -> Result<(), PlcError> {
    let expected = format!("{least} to {most}{}{unit}", if unit.is_empty() { "" } else { " " });
    check((least..=most).contains(&value), key, value, &expected)
}
