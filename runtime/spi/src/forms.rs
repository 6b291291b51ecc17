mod flag;
mod identifier;
mod number;
mod packet;
mod place;
mod quantity;
mod reserved;
mod several;
mod time;
mod words;

pub(crate) use flag::{Flag, OnOff};
pub(crate) use identifier::{IdentifierOrEmpty, IdentifierOrZero};
pub(crate) use number::{Decimal, Nine, Percent};
pub(crate) use packet::{FrameCount, ReceivedFrames};
pub(crate) use quantity::BottomLock;
pub(crate) use reserved::{Then, ThreeEmpty, Zero};
pub(crate) use several::{Each, Optional, OrDefault};
pub(crate) use time::Created;
pub(crate) use words::{LastText, Word};

/// Reads the first fields of a line's body by a form.
#[cfg(test)]
pub(crate) fn read<F: crate::field::Field>(body: &str) -> Result<F::Value, crate::Fault> {
    let line = format!("$X,{body}");
    F::decode(&mut crate::field::Reader::new(&crate::Sentence::parse(&line).unwrap()))
}

/// Writes a value by its form.
#[cfg(test)]
pub(crate) fn written<F: crate::field::Field>(value: &F::Value) -> Result<String, crate::Fault> {
    let mut out = Vec::new();
    F::encode(value, &mut crate::field::Writer::new(&mut out))?;
    Ok(String::from_utf8(out).unwrap())
}
