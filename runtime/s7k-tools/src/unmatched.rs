use std::collections::BTreeMap;

use crate::error::Error;
use crate::moment::Moment;
use crate::selection::Selection;
use crate::source::Source;

/// What there is of a type, where a selection has none of it.
#[derive(Debug, Default)]
pub(crate) struct Unmatched {
    devices: BTreeMap<u32, u64>,
    span: Option<(Moment, Moment)>,
}

impl Unmatched {
    /// Finds it in one pass.
    pub(crate) fn survey(source: &Source, record_type: u32) -> Result<Self, Error> {
        let mut unmatched = Self::default();
        source.each_record(|_, frame| {
            let header = frame.header();
            if header.record_type == record_type {
                *unmatched.devices.entry(header.device.0).or_default() += 1;
                if let Some(time) = Moment::of(&header.time) {
                    let (first, last) = unmatched.span.unwrap_or((time, time));
                    unmatched.span = Some((first.min(time), last.max(time)));
                }
            }
            Ok(())
        })?;
        Ok(unmatched)
    }

    /// The refusal to export nothing.
    pub(crate) fn refuse(&self, source: &Source, selection: &Selection, record_type: u32, what: &str) -> Error {
        let text = if self.devices.is_empty() || *selection == Selection::default() {
            format!("no {what} (record {record_type}) to export: see `backseat s7k info` for what there is")
        } else {
            let devices: Vec<String> = self
                .devices
                .iter()
                .map(|(device, records)| format!("{device} ({records} records)"))
                .collect();
            let times = match self.span {
                Some((first, last)) => format!(", from {first} to {last}"),
                None => ", without times: leave --from and --until out".to_owned(),
            };
            format!(
                "no {what} (record {record_type}) matches: there is device {}{times}",
                devices.join(", ")
            )
        };
        Error::contents(source.path(), text)
    }
}
