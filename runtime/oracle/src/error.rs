/// Why a fence cannot be judged by.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OracleError {
    /// The text is not JSON.
    #[error("the fence is not json: {0}")]
    Json(String),
    /// The document is not a GeoJSON feature collection.
    #[error("the fence: expected {expected}")]
    Document {
        /// What should be there.
        expected: &'static str,
    },
    /// One feature cannot be used.
    #[error("feature {index} of the fence, {what}: expected {expected}")]
    Feature {
        /// Which feature, from 0.
        index: usize,
        /// Which part of it.
        what: &'static str,
        /// What should be there.
        expected: &'static str,
    },
    /// A limit is not a usable number.
    #[error("limit {what} is {value}: expected {expected}")]
    Limit {
        /// Which one.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
}
