mod rules;
mod writer;

use backseat_units::{Timestamp, Utc};
use serde::Serialize;

pub use rules::{RULES, Rule, Treatment};
use writer::Writer;

/// A time that lies further back than this is as good as never: nothing that core remembers for longer than a minute can
/// change in a sequence, the forgiving of a plugin's failures (10 min) included.
pub(crate) const AGE_MAX_S: u64 = 64;

/// 128 bits that two states have in common only where nothing tells them apart but when they came about, and what
/// [`RULES`] leave out.
pub type Fingerprint = u128;

/// The fingerprint of a state at a time. Times of day in it are of a clock that says `utc` then.
pub(crate) fn fingerprint(state: &impl Serialize, now: Timestamp, utc: Utc) -> Fingerprint {
    let mut writer = Writer::new(now, utc);
    write(state, &mut writer);
    writer.finish()
}

/// What a fingerprint is made of: the rules that were met, by their place in [`RULES`], and every word with its field.
pub(crate) fn anatomy(state: &impl Serialize, now: Timestamp, utc: Utc) -> (Vec<bool>, Vec<String>) {
    let mut writer = Writer::new(now, utc);
    writer.parts = Some(Vec::new());
    write(state, &mut writer);
    (writer.met.to_vec(), writer.parts.unwrap_or_default())
}

fn write(state: &impl Serialize, writer: &mut Writer) {
    let Ok(()) = state.serialize(writer);
}
