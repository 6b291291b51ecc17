//! Names that files of before have.

/// What a kind of zone is called now, where it had another name.
pub(super) fn kind(old: &str) -> Option<&'static str> {
    match old {
        "inclusion" => Some("\"keep-in\", as it is called now"),
        "exclusion" => Some("\"keep-out\", as it is called now"),
        _ => None,
    }
}
