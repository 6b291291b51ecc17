use backseat_spi::{Direction, Framer, FromVehicle, Policy, catalogue};

/// Every message from the vehicle, with all kinds of noise between and in any pieces, comes out once and in order.
#[test]
fn only_cut_sentences_are_lost() {
    let rows: Vec<_> = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::FromVehicle)
        .collect();
    let noise: [&[u8]; 6] = [
        b"",
        b"\r\n\n",
        b"login: ",
        b"\xff\x00",
        b"$BFNVG,081025.987,42",
        b"$BFCTL,081025.987,0*78\r\n",
    ];
    let mut stream = Vec::new();
    for round in 0..20 {
        for (at, entry) in rows.iter().enumerate() {
            stream.extend_from_slice(noise[(at + round) % noise.len()]);
            stream.extend_from_slice(entry.example.as_bytes());
            stream.extend_from_slice(if at % 3 == 0 { b"\n".as_slice() } else { b"\r\n" });
        }
    }
    for piece in [1, 2, 3, 7, 61, 1000, 4096, stream.len()] {
        let mut framer = Framer::new(Policy::FromVehicle);
        let mut names = Vec::new();
        for bytes in stream.chunks(piece) {
            framer.push(bytes);
            while let Some(sentence) = framer.next_sentence() {
                names.push(FromVehicle::decode(&sentence).unwrap().name().to_owned());
            }
        }
        let expected: Vec<_> = (0..20).flat_map(|_| rows.iter().map(|entry| entry.name)).collect();
        assert_eq!(names, expected, "in pieces of {piece}");
        let counts = framer.counts();
        assert_eq!(counts.sentences as usize, expected.len());
        assert!(
            counts.noise_bytes > 0 && counts.cut_short > 0 && counts.checksum_invalid > 0,
            "{counts:?}"
        );
        assert_eq!(
            (counts.overflowed, counts.too_long, counts.malformed),
            (0, 0, 0),
            "{counts:?}"
        );
    }
}
