//! Everything that this crate knows of the format, as data.

use crate::layout::Layout;
use crate::wire::CodeTable;
use crate::{frame, network, record, time};

/// Every fixed part of frames and records, with its fields.
pub fn layouts() -> impl Iterator<Item = &'static Layout> {
    [time::LAYOUTS, frame::LAYOUTS, network::LAYOUTS]
        .into_iter()
        .chain(record::LAYOUTS)
        .flatten()
}

/// Every enumeration on the wire.
pub fn codes() -> impl Iterator<Item = &'static CodeTable> {
    record::CODES.into_iter().chain([crate::plc::CODES]).flatten()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Sizes and numbers of fields, typed off the specification.
    const PARTS: [(&str, usize, usize); 20] = [
        ("Time7k", 10, 5),
        ("FrameHeader", 64, 18),
        ("NetworkHeader", 36, 12),
        ("ImageryHeader", 20, 5),
        ("ChannelHeader", 64, 13),
        ("SideScanHeader", 80, 30),
        ("SegyHeader", 240, 61),
        ("BluefinHeader", 32, 5),
        ("BluefinFrameHeader", 32, 8),
        ("NavigationFrame", 96, 18),
        ("EnvironmentFrame", 96, 3),
        ("FileHeader", 316, 12),
        ("FileDevice", 6, 2),
        ("CatalogLocation", 12, 2),
        ("CatalogHeader", 14, 4),
        ("CatalogEntry", 48, 8),
        ("TimeMessage", 16, 5),
        ("CommandHeader", 16, 4),
        ("Acknowledge", 12, 3),
        ("MessageHeader", 16, 4),
    ];

    #[test]
    fn every_part_has_its_size_and_its_fields() {
        let parts: Vec<(&str, usize, usize)> = layouts()
            .map(|layout| (layout.name, layout.size, layout.fields.len()))
            .collect();

        assert_eq!(parts, PARTS);
        for layout in layouts() {
            let names: BTreeSet<&str> = layout.fields.iter().map(|field| field.name).collect();
            assert_eq!(names.len(), layout.fields.len(), "{}", layout.name);
            let (last, field) = layout.offsets().last().unwrap();
            assert_eq!(last + field.size, layout.size, "{}", layout.name);
            assert!(
                layout.fields.iter().all(|field| !field.unit.is_empty()),
                "{}",
                layout.name
            );
        }
    }

    #[test]
    fn every_record_names_its_parts_and_a_test_that_exists() {
        let parts: BTreeSet<&str> = layouts().map(|layout| layout.name).collect();
        let tests = include_str!("record/tests.rs");
        for record in crate::record::RECORD_TYPES {
            assert!(
                record.layouts.iter().all(|part| parts.contains(part)),
                "{}",
                record.number
            );
            assert!(
                tests.contains(&format!("#[test]\nfn {}()", record.test)),
                "{}",
                record.number
            );
        }
        let named: BTreeSet<&str> = crate::record::RECORD_TYPES
            .iter()
            .flat_map(|record| record.layouts)
            .copied()
            .collect();
        let frames = BTreeSet::from(["Time7k", "FrameHeader", "NetworkHeader"]);
        assert_eq!(&parts - &frames, named, "a part that belongs to no record");
    }
}
