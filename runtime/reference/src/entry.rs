use core::fmt;

use serde::Deserialize;

/// What a key holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Boolean,
    /// A text.
    String,
    /// One of a few words; the words that take a value are entries of their own below the key.
    Choice,
    /// A date and a time.
    Time,
    /// A number, or `[least, greatest]`, from which each seed draws one.
    Drawn,
    /// A number, or `"seed"`: the seed draws one.
    NumberOrSeed,
    /// `true`, `false`, or `"seed"`: the seed draws one.
    BooleanOrSeed,
    /// A list of numbers.
    Numbers,
    /// A list of whole numbers.
    Integers,
    /// A list of texts.
    Strings,
    /// A list of words from [`Entry::values`].
    Choices,
    /// A list of any values.
    Values,
    /// A table.
    Table,
    /// A list of tables: `[[name]]`.
    Tables,
    /// A table with whatever keys its reader wants.
    Free,
}

impl Kind {
    /// As a reader of the page would call it.
    #[must_use]
    pub const fn describe(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Integer => "whole number",
            Self::Boolean => "`true` or `false`",
            Self::String => "text",
            Self::Choice => "one of the words below",
            Self::Time => "date and time",
            Self::Drawn => "number, or `[least, greatest]`",
            Self::NumberOrSeed => "number, or `\"seed\"`",
            Self::BooleanOrSeed => "`true`, `false`, or `\"seed\"`",
            Self::Numbers => "list of numbers",
            Self::Integers => "list of whole numbers",
            Self::Strings => "list of texts",
            Self::Choices => "list of the words below",
            Self::Values => "list of values",
            Self::Table => "table",
            Self::Tables => "list of tables",
            Self::Free => "table",
        }
    }
}

/// A word that a key takes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// As it is written.
    pub value: String,
    /// What it does, in one sentence.
    pub meaning: String,
}

/// One key of a file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Tables and key with dots between: `limits.speed_max_mps`, `plugin.name`.
    pub key: String,
    /// What it holds.
    pub kind: Kind,
    /// What it means, in plain sentences.
    pub meaning: String,
    /// The unit, where the value has one.
    pub unit: Option<String>,
    /// The least value that is accepted.
    pub min: Option<f64>,
    /// The greatest value that is accepted.
    pub max: Option<f64>,
    /// Values must be greater than this.
    pub above: Option<f64>,
    /// Values must be less than this.
    pub below: Option<f64>,
    /// A condition that depends on other keys, or that is no range.
    pub condition: Option<String>,
    /// The words that it takes.
    #[serde(default)]
    pub values: Vec<Choice>,
    /// The key must be there, in a table that is there.
    #[serde(default)]
    pub required: bool,
    /// The key must be there where `kind` in the same table is one of these.
    #[serde(default)]
    pub required_of: Vec<String>,
    /// The value where the key is absent.
    pub default: Option<toml::Value>,
    /// What happens where the key is absent and has no default value.
    pub absent: Option<String>,
    /// The key belongs to these values of `kind` in the same table alone.
    #[serde(default)]
    pub only: Vec<String>,
    /// Keys that must be there with it.
    #[serde(default)]
    pub needs: Vec<String>,
    /// Keys that must not be there with it. A required key may be absent where one of these is there.
    #[serde(default)]
    pub instead_of: Vec<String>,
    /// The keys of this table are those of another: `table`, or `file:table` of another file.
    pub same_as: Option<String>,
    /// The keys that this table does not have, of the table whose keys it has otherwise.
    #[serde(default)]
    pub except: Vec<String>,
    /// A value to copy.
    pub example: Option<toml::Value>,
}

impl Entry {
    /// The key without its tables.
    #[must_use]
    pub fn name(&self) -> &str {
        self.key.rsplit_once('.').map_or(self.key.as_str(), |(_, name)| name)
    }

    /// The tables without the key; empty at the top of the file.
    #[must_use]
    pub fn table(&self) -> &str {
        self.key.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Whether the key must be there in a table of this `kind`; none is a table that has no kinds.
    #[must_use]
    pub fn is_required(&self, kind: Option<&str>) -> bool {
        self.required && self.is_of(kind) || kind.is_some_and(|kind| self.required_of.iter().any(|of| of == kind))
    }

    /// Whether the key has a meaning in a table of this `kind`; none is a table that has no kinds.
    #[must_use]
    pub fn is_of(&self, kind: Option<&str>) -> bool {
        self.only.is_empty() || kind.is_some_and(|kind| self.only.iter().any(|only| only == kind))
    }

    /// The values that are accepted, as text: `above 0, at most 4`. Empty where all are.
    #[must_use]
    pub fn range(&self) -> String {
        let mut parts = Vec::new();
        match (self.min, self.max) {
            (Some(min), Some(max)) => parts.push(format!("{} to {}", Plain(min), Plain(max))),
            (Some(min), None) => parts.push(format!("{} or more", Plain(min))),
            (None, Some(max)) => parts.push(format!("at most {}", Plain(max))),
            (None, None) => {}
        }
        if let Some(above) = self.above {
            parts.insert(0, format!("above {}", Plain(above)));
        }
        if let Some(below) = self.below {
            parts.push(format!("below {}", Plain(below)));
        }
        parts.join(", ")
    }

    /// Whether other keys lie below this one.
    #[must_use]
    pub const fn is_table(&self) -> bool {
        matches!(self.kind, Kind::Table | Kind::Tables)
    }
}

/// A number without a needless exponent or fraction.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}
