//! Writes the survey of the tests into a folder.
#[allow(
    clippy::allow_attributes,
    clippy::unwrap_used,
    dead_code,
    unreachable_pub,
    missing_docs,
    reason = "shared with the tests"
)]
mod compose;

fn main() {
    drop(compose::clean());
}
