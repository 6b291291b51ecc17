/// Why the oracle cannot use a fence or a limit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OracleError {
    /// The text is not JSON.
    #[error("the fence is not JSON: {0}")]
    Json(String),
    /// The document is not a GeoJSON feature collection.
    #[error("fence: expected {expected}")]
    Document {
        /// What should be there.
        expected: &'static str,
    },
    /// One feature cannot be used.
    #[error("feature {index} of the fence, {what}: expected {expected}")]
    Feature {
        /// Which feature, from 0.
        index: usize,
        /// Which part of the feature.
        what: &'static str,
        /// What should be there.
        expected: &'static str,
    },
    /// A limit is not a usable number.
    #[error("limit {what} is {value}: expected {expected}")]
    Limit {
        /// Which limit.
        what: &'static str,
        /// The limit's value.
        value: f64,
        /// The values that it may have.
        expected: &'static str,
    },
}
