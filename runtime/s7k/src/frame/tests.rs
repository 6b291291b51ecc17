use super::*;

/// A frame with a record of six bytes and optional data of three.
fn sample() -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(9999, DeviceId(7)).counted(3), &mut out);
    frame.bytes().extend_from_slice(b"record");
    frame.begin_optional(42);
    frame.bytes().extend_from_slice(b"opt");
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

/// The sample with a value at a place.
fn changed(at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut frame = sample();
    frame[at..at + bytes.len()].copy_from_slice(bytes);
    frame
}

#[test]
fn a_frame_lies_as_volume_one_has_it() {
    let bytes = sample();
    assert_eq!(bytes.len(), 64 + 6 + 3 + 4);
    let u16_at = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let u32_at = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    assert_eq!((u16_at(0), u16_at(2), u32_at(4), u32_at(8)), (4, 60, 0xFFFF, 77));
    assert_eq!((u32_at(12), u32_at(16)), (70, 42));
    assert_eq!((u32_at(32), u32_at(36), u32_at(44), u16_at(48)), (9999, 7, 3, 1));
    assert_eq!((&bytes[64..70], &bytes[70..73]), (&b"record"[..], &b"opt"[..]));
    let sum: u32 = bytes[..73].iter().map(|byte| u32::from(*byte)).sum();
    assert_eq!(u32_at(73), sum);
}

#[test]
fn a_frame_is_read_without_a_copy() {
    let bytes = sample();
    let frame = Frame::read(&bytes, FRAME_LIMIT).unwrap();
    assert_eq!(frame.body().unwrap(), b"record");
    assert_eq!(frame.optional().unwrap(), Some(Optional { id: 42, bytes: b"opt" }));
    assert_eq!(frame.checksum(), Checksum::Valid);
    assert_eq!(frame.bytes().as_ptr(), bytes.as_ptr());
    assert_eq!(frame.header().faults(), []);
}

#[test]
fn an_offset_of_64_is_read_as_60() {
    let bytes = changed(2, &[64, 0]);
    assert_eq!(Frame::read(&bytes, FRAME_LIMIT).unwrap().body().unwrap(), b"record");
}

#[test]
fn a_longer_header_is_skipped() {
    // Offset 62: two bytes more before the record type header.
    let bytes = changed(2, &[62, 0]);
    assert_eq!(Frame::read(&bytes, FRAME_LIMIT).unwrap().body().unwrap(), b"cord");
}

#[test]
fn what_is_wrong_with_a_header_is_named() {
    let error = |bytes: &[u8]| Frame::read(bytes, 1000).unwrap_err();
    let whole = sample();
    for end in 0..8 {
        assert_eq!(error(&whole[..end]), FrameError::Incomplete { found: end, needed: 64 });
    }
    assert_eq!(error(&whole[..63]), FrameError::Incomplete { found: 63, needed: 64 });
    assert_eq!(error(&whole[..76]), FrameError::Incomplete { found: 76, needed: 77 });
    assert_eq!(error(&changed(4, &[0])), FrameError::Sync { found: 0xFF00 });
    assert_eq!(error(&changed(8, &[67, 0])), FrameError::Size { size: 67, limit: 1000 });
    assert_eq!(
        error(&changed(8, &[0xE9, 3])),
        FrameError::Size {
            size: 1001,
            limit: 1000
        }
    );
    assert_eq!(
        error(&changed(2, &[59, 0])),
        FrameError::Offset { offset: 59, size: 77 }
    );
    assert_eq!(
        error(&changed(2, &[70, 0])),
        FrameError::Offset { offset: 70, size: 77 }
    );
    for (version, told) in [(2, "70 bytes"), (3, "52 bytes"), (6, "only 4 and 5 are")] {
        // An older header is shorter than 64 bytes: eight are enough for its version.
        let old = changed(0, &[version]);
        let text = error(&old[..8]).to_string();
        assert!(
            text.contains(&format!("version {version} is not supported")) && text.contains(told),
            "{text}"
        );
    }
}

#[test]
fn optional_data_outside_the_record_are_an_error_of_the_parts_only() {
    for (offset, fine) in [(63_u32, false), (64, true), (73, true), (74, false), (u32::MAX, false)] {
        let bytes = changed(12, &offset.to_le_bytes());
        let frame = Frame::read(&bytes, FRAME_LIMIT).unwrap();
        assert_eq!(frame.body().is_ok(), fine, "{offset}");
        assert_eq!(frame.optional().is_ok(), fine, "{offset}");
    }
    let none = changed(12, &[0; 4]);
    let frame = Frame::read(&none, FRAME_LIMIT).unwrap();
    assert_eq!(
        (frame.body().unwrap(), frame.optional().unwrap()),
        (&b"recordopt"[..], None)
    );
}

#[test]
fn a_checksum_is_claimed_by_its_flag() {
    let state = |bytes: &[u8]| Frame::read(bytes, FRAME_LIMIT).unwrap().checksum();
    let right = Frame::read(&sample(), FRAME_LIMIT).unwrap().stored_checksum();
    assert_eq!(
        state(&changed(64, b"R")),
        Checksum::Wrong {
            stored: right,
            computed: right - 32
        }
    );
    assert_eq!(state(&changed(48, &[0])), Checksum::Unclaimed { right: false });
    let mut filled = changed(48, &[0]);
    filled[73..].copy_from_slice(&(right - 1).to_le_bytes());
    assert_eq!(state(&filled), Checksum::Unclaimed { right: true });
}

#[test]
fn a_frame_over_the_limit_is_not_written() {
    let mut out = b"before".to_vec();
    let mut frame = FrameWriter::begin(FrameHeader::new(1, DeviceId(1)), &mut out);
    frame.bytes().extend_from_slice(&[0; 33]);
    assert_eq!(frame.finish(100), Err(TooLong { size: 101, limit: 100 }));
    assert_eq!(out, b"before");
}
