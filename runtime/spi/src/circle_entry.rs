use serde::{Deserialize, Serialize};

/// The field of BPRTC for the entry angle: the header of SPI 7.6 leaves it out, the table below it has it.
///
/// Serialised as the angle, as nothing, or as `absent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Serialised", from = "Serialised")]
pub enum CircleEntry {
    /// Where on the circle to begin, degrees clockwise from its northmost point.
    Angle(f64),
    /// The field is there and empty: the vehicle chooses.
    Anywhere,
    /// The field is not there, as in the header: the interrupt code takes its place.
    Absent,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Serialised {
    Angle(f64),
    Word(Word),
    Nothing,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Word {
    Absent,
}

impl From<CircleEntry> for Serialised {
    fn from(entry: CircleEntry) -> Self {
        match entry {
            CircleEntry::Angle(degrees) => Self::Angle(degrees),
            CircleEntry::Anywhere => Self::Nothing,
            CircleEntry::Absent => Self::Word(Word::Absent),
        }
    }
}

impl From<Serialised> for CircleEntry {
    fn from(entry: Serialised) -> Self {
        match entry {
            Serialised::Angle(degrees) => Self::Angle(degrees),
            Serialised::Nothing => Self::Anywhere,
            Serialised::Word(Word::Absent) => Self::Absent,
        }
    }
}
