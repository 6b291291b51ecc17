//! What `info` prints for people.

use core::fmt::Write as _;

use super::{Damage, Group, Info};
use crate::catalogue::Catalogue;
use crate::listed::Listed;
use crate::moment::Moment;

/// How many entries of a list people see; JSON has more.
const SHOWN: usize = 5;

pub(super) fn text(file: &str, info: &Info) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _infallible = write_all(&mut out, file, info);
    out
}

fn write_all(out: &mut String, file: &str, info: &Info) -> core::fmt::Result {
    writeln!(
        out,
        "{file}: {}, {}",
        count(info.records, "record"),
        count(info.bytes, "byte")
    )?;
    if let (Some(first), Some(last)) = (info.first, info.last) {
        writeln!(out, "{first} to {last} ({:.1} s)", last.seconds_since(first))?;
    }
    match &info.file_header {
        Some(header) => {
            write!(
                out,
                "file header: recorded by {:?} {}",
                header.recorder, header.recorder_version
            )?;
            for (name, text) in [("name", &header.user_name), ("notes", &header.notes)] {
                if !text.is_empty() {
                    write!(out, ", {name} {text:?}")?;
                }
            }
            writeln!(out)?;
        }
        None => writeln!(out, "file header: none")?,
    }
    let versions: Vec<String> = info
        .protocol_versions
        .iter()
        .map(|(version, records)| format!("{} in version {version}", count(*records, "record")))
        .collect();
    writeln!(out, "protocol: {}", versions.join(", "))?;
    let layouts = info.header_layouts;
    if layouts.spec + layouts.padded > 0 {
        let (spec, padded) = (layouts.spec, layouts.padded);
        writeln!(out, "sonar headers: {spec} of 20 bytes, {padded} of 32 bytes")?;
    }
    writeln!(out)?;
    table(out, &info.groups)?;
    writeln!(out)?;
    for group in &info.groups {
        gaps(out, group)?;
    }
    checks(out, info)?;
    damage(out, &info.damage)?;
    match &info.warning {
        Some(warning) => writeln!(out, "warning: {warning}"),
        None => Ok(()),
    }
}

fn table(out: &mut String, groups: &[Group]) -> core::fmt::Result {
    let time = |moment: Option<Moment>| moment.map_or_else(|| "-".to_owned(), |moment| moment.to_string());
    writeln!(
        out,
        "{:>5}  {:>6}  {:>7}  {:>11}  {:24}  {:24}  {:>9}  what",
        "type", "device", "records", "bytes", "first", "last", "rate (Hz)"
    )?;
    for group in groups {
        let device = if group.enumerator == 0 {
            group.device.to_string()
        } else {
            format!("{}/{}", group.device, group.enumerator)
        };
        let rate = group
            .rate_hz
            .map_or_else(|| "-".to_owned(), |rate| format!("{rate:.3}"));
        let what = group.title.unwrap_or("unknown type");
        write!(
            out,
            "{:>5}  {device:>6}  {:>7}  {:>11}  {:24}  {:24}  {rate:>9}  {what}",
            group.record_type,
            group.records,
            group.bytes,
            time(group.first),
            time(group.last),
        )?;
        match group.device_title {
            Some(title) => writeln!(out, "; {title}")?,
            None => writeln!(out)?,
        }
    }
    Ok(())
}

fn gaps(out: &mut String, group: &Group) -> core::fmt::Result {
    let name = format!("{} of device {}", group.record_type, group.device);
    if group.without_time > 0 {
        writeln!(out, "{name}: {} without a time", count(group.without_time, "record"))?;
    }
    let interval = group.interval_s.unwrap_or_default();
    for gap in shown(&group.time_gaps) {
        let (seconds, from, offset) = (gap.seconds, gap.from, gap.offset);
        writeln!(
            out,
            "{name}: gap of {seconds:.3} s after {from} (usually {interval:.3} s), byte {offset}"
        )?;
    }
    more(out, &name, "gap", &group.time_gaps)?;
    for gap in shown(&group.times_backwards) {
        writeln!(
            out,
            "{name}: time goes back by {:.3} s, byte {}",
            -gap.seconds, gap.offset
        )?;
    }
    more(out, &name, "step back", &group.times_backwards)?;
    for gap in shown(&group.count_gaps) {
        writeln!(
            out,
            "{name}: record count {} follows {}, byte {}",
            gap.to, gap.from, gap.offset
        )?;
    }
    more(out, &name, "step in the record count", &group.count_gaps)?;
    if group.missing > 0 {
        writeln!(
            out,
            "{name}: {} missing by the record counts",
            count(group.missing, "record")
        )?;
    }
    Ok(())
}

fn checks(out: &mut String, info: &Info) -> core::fmt::Result {
    let sums = &info.checksums;
    writeln!(
        out,
        "checksums: {} right, {} wrong; {} not claimed but right, {} not claimed and not right",
        sums.valid, sums.wrong.count, sums.unclaimed_right, sums.unclaimed_wrong
    )?;
    for place in shown(&sums.wrong) {
        writeln!(out, "  byte {}: checksum {}", place.offset, place.fault)?;
    }
    more(out, " ", "wrong checksum", &sums.wrong)?;
    let sums = info.bluefin_checksums;
    let frames = sums.whole_packet + sums.data_only + sums.none + sums.neither;
    if frames > 0 {
        writeln!(
            out,
            "Bluefin frames: {frames}; CRC of the packet {}, of the data {}, none {}, of neither {}",
            sums.whole_packet, sums.data_only, sums.none, sums.neither
        )?;
    }
    for place in shown(&info.undecodable) {
        writeln!(out, "byte {}: {}", place.offset, place.fault)?;
    }
    more(
        out,
        "records that are not what their type says",
        "record",
        &info.undecodable,
    )?;
    match info.catalogue {
        Catalogue::Absent => writeln!(out, "catalogue: none"),
        Catalogue::NotThere { offset } => {
            writeln!(out, "catalogue: none at byte {offset}, where the file header has it")
        }
        Catalogue::Matches { offset, entries } => {
            writeln!(out, "catalogue: at byte {offset}, right ({entries} entries)")
        }
        Catalogue::Differs {
            offset,
            entries,
            differences,
        } => writeln!(
            out,
            "catalogue: at byte {offset}, wrong ({entries} entries, {}; see `verify`)",
            count(differences, "difference")
        ),
    }
}

fn damage(out: &mut String, damage: &Damage) -> core::fmt::Result {
    if damage.places.count == 0 {
        return writeln!(out, "damage: none");
    }
    writeln!(
        out,
        "damage: {} in {}",
        count(damage.bytes, "byte"),
        count(damage.places.count, "place")
    )?;
    for place in shown(&damage.places) {
        writeln!(
            out,
            "  byte {}: {}: {}",
            place.offset,
            count(place.bytes, "byte"),
            place.fault
        )?;
    }
    more(out, " ", "place", &damage.places)
}

fn shown<T>(list: &Listed<T>) -> impl Iterator<Item = &T> {
    list.first.iter().take(SHOWN)
}

fn more<T>(out: &mut String, name: &str, what: &str, list: &Listed<T>) -> core::fmt::Result {
    let hidden = list.left_out() + list.first.len().saturating_sub(SHOWN) as u64;
    if hidden == 0 {
        return Ok(());
    }
    writeln!(out, "{name}: {} more", count(hidden, what))
}

/// `1 record`, `2 records`.
fn count(number: u64, what: &str) -> String {
    if number == 1 {
        format!("1 {what}")
    } else {
        format!("{number} {what}s")
    }
}
