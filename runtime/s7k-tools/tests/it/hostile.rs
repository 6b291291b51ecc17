//! Bytes that are wrong anywhere: every tool ends with a result or with an error, and never panics.

use backseat_s7k_tools::{
    CsvOf, Mosaic, Selection, Signal, Source, Waterfall, cut, dump, export_csv, export_mosaic, export_segy,
    export_waterfall, export_xtf, info, verify,
};

use crate::compose;
use crate::tools::recording;

/// The first seconds of the survey with bytes overwritten, most of them in headers.
fn spoilt(whole: &[Vec<u8>], seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut draw = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % below as u64).unwrap()
    };
    let mut records = whole.to_vec();
    for _ in 0..30 {
        let record = draw(records.len());
        let bytes = &mut records[record];
        let near = draw(3);
        let at = draw(if near == 0 { bytes.len() } else { bytes.len().min(200) });
        let values = [0, 1, 0x7F, 0x80, 0xFF, u8::try_from(draw(256)).unwrap()];
        bytes[at] = values[draw(values.len())];
    }
    records.concat()
}

#[test]
fn no_tool_panics_over_spoilt_bytes() {
    let whole: Vec<Vec<u8>> = compose::records().into_iter().take(90).collect();
    let (mut read, mut drawn) = (0, 0);
    for seed in 0..150 {
        let (folder, path) = recording(&spoilt(&whole, seed));
        let out = folder.path().join("out");
        let Ok(source) = Source::open(&path) else {
            continue;
        };
        let all = Selection::default();
        let high = Selection {
            devices: vec![11_002],
            ..Selection::default()
        };
        let ground = Waterfall {
            ground: true,
            ..Waterfall::default()
        };
        let mosaic = Mosaic {
            resolution_m: 1.0,
            memory_mib: 16,
            ..Mosaic::default()
        };
        let found = info(&source).unwrap();
        let bytes: u64 = found.groups.iter().map(|group| group.bytes).sum();
        assert_eq!(bytes + found.damage.bytes, source.bytes(), "seed {seed}");
        let verdict = verify(&source, false, &mut Vec::new()).unwrap();
        assert_eq!(verdict.damage, found.damage.places.count, "seed {seed}");
        assert_eq!(
            dump(&source, &all, true, &mut Vec::new()).unwrap().records,
            found.records
        );
        read += usize::from(cut(&source, &all, &out).is_ok());
        let results = [
            export_segy(&source, &all, Signal::Envelope, 0, &out),
            export_csv(&source, &all, CsvOf::Navigation, &out),
            export_xtf(&source, &high, None, &out),
            export_waterfall(&source, &high, &ground, &out),
            export_mosaic(&source, &high, &mosaic, &out),
        ];
        drawn += results.iter().filter(|result| result.is_ok()).count();
    }
    assert!(read > 140 && drawn > 500, "{read} {drawn}");
}
