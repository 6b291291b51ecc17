use serde::{Deserialize, Serialize};

/// The field of BPRTC for the entry angle. The header of SPI 7.6 leaves it out, and the table below the header has it.
///
/// Serialised as the angle, as null, or as `absent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Serialised", from = "Serialised")]
pub enum CircleEntry {
    /// The point of the circle where the vehicle begins, degrees clockwise from the northmost point.
    Angle(f64),
    /// The field is there and is empty: the vehicle chooses.
    Anywhere,
    /// The field is missing, as in the header: the interrupt code takes its place.
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
