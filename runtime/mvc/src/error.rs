use backseat_plan::PlanError;
use backseat_world::WorldError;

/// What is wrong with a `world.toml` or a file of faults: the place, what was found, and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MvcError {
    /// The text is not TOML, or it has an unknown key or a value of the wrong type.
    #[error("line {line}, column {column}: {message}: `{text}`")]
    Toml {
        /// Line in the file, from 1.
        line: usize,
        /// Character in that line, from 1.
        column: usize,
        /// What was found and what was expected, on one line.
        message: String,
        /// The line itself, which names the key.
        text: String,
    },
    /// A value that its key does not allow.
    #[error("{key} is {value}, expected {expected}")]
    Value {
        /// The key with its section: `mission.starts_after_s`.
        key: &'static str,
        /// What was found.
        value: String,
        /// What is allowed, in words.
        expected: &'static str,
    },
    /// The vehicle cannot fly an element of the plan.
    #[error("plan element {number}: {fault}")]
    Plan {
        /// Its number, from 1.
        number: u32,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// A dive with a plan or a key that is not possible.
    #[error("dive {number}: {fault}")]
    Dive {
        /// Its number in the file, from 1.
        number: u32,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// A fault with a missing, superfluous or invalid key.
    #[error("fault {number}: {fault}")]
    Fault {
        /// Its number in the file, from 1.
        number: u32,
        /// The key, what is wrong and what was expected.
        fault: String,
    },
    /// A rule of a script with a missing, superfluous or invalid key.
    #[error("line {line}: rule {number}: {fault}")]
    Rule {
        /// Line in the file where the rule begins, from 1.
        line: usize,
        /// Its number in the file, from 1.
        number: u32,
        /// The key, what is wrong and what was expected.
        fault: String,
    },
    /// The world cannot be made from the file.
    #[error(transparent)]
    World(#[from] WorldError),
}

/// Why an operator's command about a dive is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DiveError {
    /// The vehicle has no dive with this name.
    #[error("no dive {file}, expected one of {dives}")]
    NoSuchDive {
        /// The name.
        file: Box<str>,
        /// Those that there are.
        dives: String,
    },
    /// The vehicle does not take missions yet.
    #[error("the vehicle is offline")]
    Offline,
    /// A mission is running or wraps up.
    #[error("a mission is running: end or abort it first")]
    Running,
    /// No dive can be started; the mission's status.
    #[error("no dive is ready: the mission is {0}")]
    NotReady(&'static str),
    /// No dive can be ended or aborted; the mission's status.
    #[error("no dive is running: the mission is {0}")]
    NotRunning(&'static str),
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

impl MvcError {
    /// The same error, of the dive with this number.
    pub(crate) fn of_dive(self, number: u32) -> Self {
        let fault = self.to_string();
        Self::Dive { number, fault }
    }
}

/// Why the vehicle does not do what a rule or the operator orders.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// The dive cannot be loaded, started, ended or aborted.
    #[error(transparent)]
    Dive(#[from] DiveError),
    /// So many faults are the most that a run may have.
    #[error("this run has had {0} faults, and takes no more")]
    Faults(usize),
}

/// Returns an error with the key and the value unless `ok`.
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

/// A number as people write it: 1e300 is not printed with 301 digits.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-6..1e9).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}
