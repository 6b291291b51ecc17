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
    /// A sentence as it is written on the wire, with its checksum and without the line end.
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
    /// The range of values, in the unit: `0..360`. `any` is every number that the wire carries, within ±1e9.
    pub range: &'static str,
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
    fn names_are_unique_and_show_the_direction() {
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

    /// The headings of sections 5 to 9, typed from the specification and not copied from the tables.
    const SECTIONS: [(&str, &str); 5] = [
        ("5", "BFMSC BFSHT BFBDL BFSDL BFTOP BFDVT BFVER"),
        (
            "6",
            "BFNVG BFNVR BFTEL BFSVS BFRCM BFRDP BFRVL BFRBS BFMBS BFMBE BFMIS BFERC BFDVL BFDV2 BFIMU BFCTD BFRNV BFPIT \
             BFCNV BFPLN BFACK BFTRM BFBOY BFCTL",
        ),
        (
            "7",
            "BPLOG BPSTS BPTOP BPDVR BPRTK BPRTC BPRGP BPRCN BPRCA BPRCB BPRCE BPRMB BPEMB BPTMR BPCTD BPABT BPKIL BPMSG \
             BPRMP BPSEM BPNPU BPSIL BPTRM BPBOY BPVER",
        ),
        ("8", "BPSUS BPCON BPRES BPSPD BPSAN BPGHP BPGBP BPRNS BPRBO BPPTZ BPLIT"),
        ("9", "BFCMA BFCPS BFCPR BPCPD"),
    ];

    #[test]
    fn every_section_of_the_specification_has_its_row_and_every_row_is_complete() {
        let sections: BTreeSet<(String, &str)> = SECTIONS
            .iter()
            .flat_map(|(chapter, names)| {
                names
                    .split(' ')
                    .enumerate()
                    .map(move |(index, name)| (format!("{chapter}.{}", index + 1), name))
            })
            .collect();
        let rows: BTreeSet<_> = catalogue()
            .iter()
            .map(|entry| (entry.section.to_owned(), entry.name))
            .collect();
        assert_eq!(rows, sections);
        let from_vehicle = |entry: &&Entry| entry.direction == Direction::FromVehicle;
        assert_eq!(catalogue().iter().filter(from_vehicle).count(), 34);
        assert_eq!(catalogue().len(), 34 + 37);
        for entry in catalogue() {
            assert!(!entry.title.is_empty() && !entry.fields.is_empty(), "{}", entry.name);
            for field in entry.fields {
                assert!(
                    !field.name.is_empty()
                        && !field.unit.is_empty()
                        && !field.formats.is_empty()
                        && !field.range.is_empty(),
                    "{} {}",
                    entry.name,
                    field.name
                );
            }
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
