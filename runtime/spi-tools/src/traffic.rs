use std::io::Write;

use crate::decode::Decoding;
use crate::error::Error;
use crate::reading::Reading;
use crate::sheet::write_reading;
use crate::splitter::Splitter;
use crate::tally::Tally;

/// Something that happened on a link, with its time in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Traffic<'a> {
    /// Bytes of one read.
    FromVehicle {
        /// When.
        at_s: f64,
        /// The bytes, which may begin and end inside a sentence.
        bytes: &'a [u8],
    },
    /// Bytes of one write.
    ToVehicle {
        /// When.
        at_s: f64,
        /// The bytes.
        bytes: &'a [u8],
    },
    /// The link was lost, or bytes are missing: what has begun in either direction does not go on.
    Break {
        /// When.
        at_s: f64,
    },
}

/// Decodes the bytes of both directions of a link: writes one line for each sentence, with the time at which its last
/// byte came, and returns the counts. Each direction is read by itself, so a sentence may come in parts between those of
/// the other direction.
///
/// # Errors
///
/// [`Error::Output`]. A faulty sentence is not an error.
pub fn decode_traffic<'a>(
    traffic: impl Iterator<Item = Traffic<'a>>,
    decoding: Decoding,
    out: &mut impl Write,
) -> Result<Tally, Error> {
    const BLOCK: usize = 1 << 16;
    let mut splitters = [Splitter::default(), Splitter::default()];
    let mut tally = Tally::default();
    let mut lines = Vec::with_capacity(2 * BLOCK);
    let mut last_s = 0.0;
    for event in traffic {
        let [from_vehicle, to_vehicle] = &mut splitters;
        match event {
            Traffic::FromVehicle { at_s, bytes } => {
                from_vehicle.push(bytes);
                take(from_vehicle, at_s, decoding, &mut tally, &mut lines)?;
                last_s = at_s;
            }
            Traffic::ToVehicle { at_s, bytes } => {
                to_vehicle.push(bytes);
                take(to_vehicle, at_s, decoding, &mut tally, &mut lines)?;
                last_s = at_s;
            }
            Traffic::Break { at_s } => {
                end(&mut splitters, at_s, decoding, &mut tally, &mut lines)?;
                last_s = at_s;
            }
        }
        if lines.len() > BLOCK {
            out.write_all(&lines).map_err(Error::Output)?;
            lines.clear();
        }
    }
    end(&mut splitters, last_s, decoding, &mut tally, &mut lines)?;
    out.write_all(&lines)
        .and_then(|()| out.flush())
        .map_err(Error::Output)?;
    let [from_vehicle, to_vehicle] = &splitters;
    tally.set_passed(
        from_vehicle.too_long + to_vehicle.too_long,
        from_vehicle.noise_bytes + to_vehicle.noise_bytes,
    );
    Ok(tally)
}

fn end(
    splitters: &mut [Splitter],
    at_s: f64,
    decoding: Decoding,
    tally: &mut Tally,
    lines: &mut Vec<u8>,
) -> Result<(), Error> {
    for splitter in splitters {
        splitter.end();
        take(splitter, at_s, decoding, tally, lines)?;
    }
    Ok(())
}

fn take(
    splitter: &mut Splitter,
    at_s: f64,
    decoding: Decoding,
    tally: &mut Tally,
    lines: &mut Vec<u8>,
) -> Result<(), Error> {
    while let Some(piece) = splitter.next() {
        let length = piece.bytes.len() as u64;
        match Reading::of(piece, decoding.ignore_checksum) {
            Some(reading) => {
                tally.count(&reading);
                write_reading(lines, decoding.form, &reading, Some(at_s)).map_err(Error::Output)?;
            }
            None => splitter.count_noise(length),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sheet::Form;

    fn decoded(traffic: &[Traffic<'_>]) -> (Vec<String>, Tally) {
        let decoding = Decoding {
            form: Form::Text { colour: false },
            ignore_checksum: false,
        };
        let mut out = Vec::new();
        let tally = decode_traffic(traffic.iter().copied(), decoding, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        (text.lines().map(str::to_owned).collect(), tally)
    }

    const fn from(at_s: f64, bytes: &[u8]) -> Traffic<'_> {
        Traffic::FromVehicle { at_s, bytes }
    }

    const fn to(at_s: f64, bytes: &[u8]) -> Traffic<'_> {
        Traffic::ToVehicle { at_s, bytes }
    }

    #[test]
    fn sentences_in_parts_are_joined_within_their_direction() {
        let (lines, tally) = decoded(&[
            from(1.0, b"$BFCTL,081025.987,1*78\r\n$BFCTL,0810"),
            to(1.5, b"$BPLOG,NV"),
            from(2.0, b"25.987,1*78\r\n"),
            to(2.5, b"G,ON\r\n"),
        ]);
        assert_eq!(
            lines,
            [
                "    1.000  BFCTL  backseat control: created 08:10:25.987, granted yes",
                "    2.000  BFCTL  backseat control: created 08:10:25.987, granted yes",
                "    2.500  BPLOG  logging control: message NVG, on yes  (no checksum)",
            ]
        );
        assert_eq!(tally.to_string(), "3 sentences, 3 read");
    }

    #[test]
    fn what_a_lost_link_cut_off_is_not_joined_with_what_comes_after_it() {
        let (lines, tally) = decoded(&[
            from(1.0, b"$BFCTL,0810"),
            Traffic::Break { at_s: 1.5 },
            from(2.0, b"25.987,1*78\r\n$BFCTL,081025.987,1*78\r\n"),
        ]);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].contains("1.500  BFCTL  error: cut off"), "{lines:?}");
        assert_eq!(tally.to_string(), "2 sentences, 1 read, 1 cut short, 11 bytes of noise");
    }
}
