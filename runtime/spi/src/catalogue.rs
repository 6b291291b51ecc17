use crate::{from_vehicle, to_vehicle};

/// Who sends a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The vehicle, to the payload: BF….
    FromVehicle,
    /// The payload, to the vehicle: BP….
    ToVehicle,
}

/// One message of the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The sentence's name, `BFNVG`.
    pub name: &'static str,
    /// Its section in SPI 1.12a.
    pub section: &'static str,
    /// Its title there, shortened.
    pub title: &'static str,
    /// Who sends it.
    pub direction: Direction,
    /// The values that it carries, in order.
    pub fields: &'static [EntryField],
    /// A sentence as it stands on the wire, with its checksum and without the line end.
    pub example: &'static str,
}

/// One value of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryField {
    /// Its name in this crate's type.
    pub name: &'static str,
    /// Its unit or meaning.
    pub unit: &'static str,
    /// The wire fields that it takes, in the notation of SPI 4.2, Table 1.
    pub formats: &'static [&'static str],
}

const COUNT: usize = from_vehicle::ENTRIES.len() + to_vehicle::ENTRIES.len();

static CATALOGUE: [Entry; COUNT] = {
    let mut all = [from_vehicle::ENTRIES[0]; COUNT];
    let mut at = 0;
    while at < COUNT {
        all[at] = if at < from_vehicle::ENTRIES.len() {
            from_vehicle::ENTRIES[at]
        } else {
            to_vehicle::ENTRIES[at - from_vehicle::ENTRIES.len()]
        };
        at += 1;
    }
    all
};

/// Every message that this crate knows: first those from the vehicle, then those to it.
#[must_use]
pub fn catalogue() -> &'static [Entry] {
    &CATALOGUE
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::{ChecksumState, Sentence};

    #[test]
    fn names_are_unique_and_tell_the_direction() {
        let names: BTreeSet<_> = catalogue().iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), catalogue().len());
        for entry in catalogue() {
            let prefix = match entry.direction {
                Direction::FromVehicle => "BF",
                Direction::ToVehicle => "BP",
            };
            assert!(
                entry.name.starts_with(prefix) && entry.name.len() == 5,
                "{}",
                entry.name
            );
        }
    }

    #[test]
    fn examples_have_the_fields_that_the_entry_names_and_the_right_checksum() {
        for entry in catalogue() {
            let sentence = Sentence::parse(entry.example).unwrap();
            assert_eq!(sentence.checksum(), ChecksumState::Valid, "{}", entry.example);
            assert_eq!(sentence.name(), entry.name);
            let width: usize = entry.fields.iter().map(|field| field.formats.len()).sum();
            assert_eq!(sentence.fields().count(), width, "{}", entry.name);
        }
    }
}
