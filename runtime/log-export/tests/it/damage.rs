use std::sync::LazyLock;

use backseat_log_export::{Error, Format};
use proptest::prelude::*;

use crate::{Desk, FORMATS, compose};

static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(compose::whole);

#[test]
fn the_log_of_a_killed_process_is_exported_as_far_as_it_goes() {
    let desk = Desk::with(&compose::killed());
    for (format, out) in FORMATS {
        let done = desk.export(format, out).unwrap();
        let remark = done.remarks.last().unwrap();
        assert!(remark.contains("cut short: the log ends at "), "{format:?}: {remark}");
    }
    let whole = Desk::with(&WHOLE);
    let [cut, whole] = [&desk, &whole].map(|desk| desk.exported(Format::Alog, "log.alog").lines().count());
    assert!(cut > whole / 3 && cut < whole, "{cut} lines of {whole}");
}

#[test]
fn a_damaged_chunk_ends_the_export_there() {
    let mut log = WHOLE.clone();
    let middle = log.len() / 2;
    log[middle] ^= 0xff;
    let desk = Desk::with(&log);
    let done = desk.export(Format::Alog, "log.alog").unwrap();
    let remark = done.remarks.last().unwrap();
    assert!(
        remark.contains(": damaged after ") && !remark.contains('\n'),
        "{remark}"
    );
}

#[test]
fn what_is_no_log_is_refused_and_leaves_nothing() {
    for (content, what) in [
        (&b""[..], "is not an MCAP file"),
        (b"hello, this is a text\n", "is not an MCAP file"),
        (&WHOLE[..8], "is cut off before it says which run it is of"),
    ] {
        let desk = Desk::with(content);
        for (format, out) in FORMATS {
            let error = desk.export(format, out).unwrap_err();
            assert!(matches!(error, Error::NoLog { .. }), "{error}");
            assert!(error.to_string().contains(what), "{error}");
            assert_eq!(desk.names(), ["dive.mcap"]);
        }
    }
}

#[test]
fn the_log_itself_is_not_an_output() {
    let desk = Desk::with(&WHOLE);
    let error = desk.export(Format::Alog, "dive.mcap").unwrap_err().to_string();
    assert!(
        error.ends_with("dive.mcap: is the log itself: name another file"),
        "{error}"
    );
    assert_eq!(std::fs::read(&desk.log).unwrap(), *WHOLE);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes that were changed, and an end anywhere.
    #[test]
    fn any_damage_ends_with_an_export_or_one_line_and_never_with_half_a_file(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        end in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
        format in 0..FORMATS.len(),
    ) {
        let mut log = WHOLE.clone();
        for (place, byte) in changes {
            let place = place.index(log.len());
            log[place] = byte;
        }
        if is_cut {
            log.truncate(end.index(log.len()));
        }
        let desk = Desk::with(&log);
        let (format, out) = FORMATS[format];
        match desk.export(format, out) {
            Ok(_) => prop_assert_eq!(desk.names().len(), 2),
            Err(error) => {
                prop_assert!(!error.to_string().contains('\n'), "{}", error);
                prop_assert_eq!(desk.names(), ["dive.mcap"]);
            }
        }
    }
}
