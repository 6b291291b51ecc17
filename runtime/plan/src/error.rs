/// A plan that cannot be flown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// No elements, or too many.
    #[error("plan is {0} elements, expected 1 to 10000 elements")]
    Length(usize),
    /// An element that is invalid, or that the vehicle cannot fly.
    #[error("plan element {number}: {fault}")]
    Element {
        /// Its number, from 1.
        number: u32,
        /// What is wrong and what was expected.
        fault: String,
    },
}
