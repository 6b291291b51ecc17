use crate::plugin::Refusal;

/// A rejection that is not the fence's.
pub(crate) fn refused(rule: &'static str, text: &str) -> Refusal {
    Refusal {
        rule,
        metres: 0.0,
        text: text.to_owned(),
    }
}
