use backseat_plan::PlanError;
use backseat_world::WorldError;

/// A `world.toml` that the mock cannot run: where, what, and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MvcError {
    /// Not TOML, an unknown key, or a value of the wrong kind.
    #[error("line {line}, column {column}: {message}: `{text}`")]
    Toml {
        /// Line in the file, from 1.
        line: usize,
        /// Character in that line, from 1.
        column: usize,
        /// What was found and what was expected, one line.
        message: String,
        /// The line itself, which names the key.
        text: String,
    },
    /// A value outside what its key allows.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its section: `mission.starts_after_s`.
        key: &'static str,
        /// What was found.
        value: String,
        /// What is allowed, in words.
        expected: &'static str,
    },
    /// An element of the plan that cannot be flown.
    #[error("plan element {number}: {fault}")]
    Plan {
        /// Its number, from 1.
        number: u32,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// A fault of a plan that cannot be.
    #[error("fault {number}: {fault}")]
    Fault {
        /// Its number in the plan, from 1.
        number: u32,
        /// The key, what is wrong and what was expected.
        fault: String,
    },
    /// The world cannot be made.
    #[error(transparent)]
    World(#[from] WorldError),
}

impl From<PlanError> for MvcError {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Length(elements) => Self::Value {
                key: "plan",
                value: format!("{elements} elements"),
                expected: "1 to 10000 elements",
            },
            PlanError::Element { number, fault } => Self::Plan { number, fault },
        }
    }
}

/// Checks one number of a configuration.
pub(crate) fn check(ok: bool, key: &'static str, value: f64, expected: &'static str) -> Result<(), MvcError> {
    if ok {
        Ok(())
    } else {
        Err(MvcError::Value {
            key,
            value: short(value),
            expected,
        })
    }
}

/// A number as people write it: 1e300 is not shown with 301 digits.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-6..1e9).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
