//! Earlier names that old files may still have.

/// The present name of a kind of zone, for an earlier name.
pub(super) fn kind(old: &str) -> Option<&'static str> {
    match old {
        "inclusion" => Some("\"keep-in\", as it is called now"),
        "exclusion" => Some("\"keep-out\", as it is called now"),
        _ => None,
    }
}
