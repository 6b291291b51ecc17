use backseat_plan::PlanEntry;
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::file::WrapUp;

/// How many dives a file may have.
const DIVES_MAX: usize = 100;

/// One `[[dive]]`: a dive file on the vehicle. With such tables the vehicle begins without a dive, and an operator loads
/// and starts its dives one after the other: at the times that are given here, or when [`crate::Mvc::load_dive`] and
/// [`crate::Mvc::start_dive`] say so. What `[mission]` says of a mission holds for each of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiveConfig {
    /// Its name, as BFMIS, BFMBS and BFMBE give it.
    pub file: String,
    /// The folder that BFMIS names after `Running`; `None` for that of `[mission]`.
    pub log_dir: Option<String>,
    /// What the vehicle does at the end; `None` for what `[mission]` says.
    pub wrap_up: Option<WrapUp>,
    /// When it is loaded, seconds after the vehicle has come online or the dive before is over, 0 to 1e6; `None` if only
    /// an operator loads it.
    pub load_after_s: Option<f64>,
    /// When it starts, seconds after it is loaded, 0 to 1e6; `None` if only an operator starts it.
    pub start_after_s: Option<f64>,
    /// When the operator ends it as successful if it is still running, seconds after its start, 0 to 1e7.
    pub end_after_s: Option<f64>,
    /// When the operator aborts it if it is still running, seconds after its start, 0 to 1e7.
    pub abort_after_s: Option<f64>,
    /// What is wrong with its files. Such a dive is never ready.
    pub invalid: Option<InvalidFile>,
    /// Its plan; without one, the `[[plan]]` of the file.
    #[serde(default)]
    pub plan: Vec<PlanEntry>,
}

/// Which file of a dive the vehicle cannot use (SPI 6.11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InvalidFile {
    /// The dive file: `Invalid Dive File`.
    Dive,
    /// The file of its wrapup: `Invalid Wrapup File`.
    Wrapup,
}

/// Checks what needs neither the world nor the other sections.
pub(crate) fn validate(dives: &[DiveConfig]) -> Result<(), MvcError> {
    check(
        dives.len() <= DIVES_MAX,
        "dive",
        dives.len() as f64,
        "at most 100 entries",
    )?;
    for (number, dive) in (1..).zip(dives) {
        dive.validate(dives).map_err(|error| error.of_dive(number))?;
    }
    Ok(())
}

impl DiveConfig {
    fn validate(&self, all: &[Self]) -> Result<(), MvcError> {
        for (key, value, most) in [
            ("dive.load_after_s", self.load_after_s, 1e6),
            ("dive.start_after_s", self.start_after_s, 1e6),
            ("dive.end_after_s", self.end_after_s, 1e7),
            ("dive.abort_after_s", self.abort_after_s, 1e7),
        ] {
            let expected = if most > 1e6 { "0 to 1e7 s" } else { "0 to 1e6 s" };
            let value = value.unwrap_or(0.0);
            check((0.0..=most).contains(&value), key, value, expected)?;
        }
        let log_dir = self.log_dir.as_deref().unwrap_or("");
        for (key, text) in [("dive.file", self.file.as_str()), ("dive.log_dir", log_dir)] {
            if backseat_spi::Text::new(text).is_err() || text.len() > 200 {
                return Err(MvcError::Value {
                    key,
                    value: format!("{text:?}"),
                    expected: "at most 200 printable ascii characters without comma, asterisk and dollar",
                });
            }
        }
        let others = all.iter().filter(|other| other.file == self.file).count() - 1;
        for (key, ok, expected) in [
            ("dive.file", !self.file.trim().is_empty(), "a name"),
            ("dive.file", others == 0, "a name that no other dive has"),
            (
                "dive.start_after_s",
                self.invalid.is_none() || self.start_after_s.is_none(),
                "no such key, because an invalid dive never starts",
            ),
            (
                "dive.abort_after_s",
                self.end_after_s.is_none() || self.abort_after_s.is_none(),
                "no such key beside end_after_s",
            ),
        ] {
            if !ok {
                let value = if key == "dive.file" {
                    format!("{:?}", self.file)
                } else {
                    "set".to_owned()
                };
                return Err(MvcError::Value { key, value, expected });
            }
        }
        Ok(())
    }
}
