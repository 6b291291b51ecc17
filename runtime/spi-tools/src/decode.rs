use std::io::{ErrorKind, Read, Write};

use crate::error::Error;
use crate::reading::Reading;
use crate::sheet::{Form, write_reading};
use crate::splitter::Splitter;
use crate::tally::Tally;

/// How to decode a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decoding {
    /// The output format.
    pub form: Form,
    /// Whether to decode sentences with a wrong checksum too. They stay marked as such.
    pub ignore_checksum: bool,
}

const CHUNK: usize = 1 << 16;

/// Decodes bytes of any kind: writes one line for each sentence and returns the counts.
///
/// A sentence begins with `$` and a name. The name gives the direction: `BF…` comes from the vehicle, `BP…` goes to it.
/// For each sentence the output has its message, or the reason why it has none. Other bytes are counted. What has been
/// read is written before waiting for more, so that a live pipe can be watched. Memory does not grow with the input.
///
/// # Errors
///
/// [`Error::Input`] and [`Error::Output`]. A faulty sentence is not an error.
pub fn decode(mut input: impl Read, decoding: Decoding, out: &mut impl Write) -> Result<Tally, Error> {
    let mut splitter = Splitter::default();
    let mut tally = Tally::default();
    let mut chunk = vec![0; CHUNK];
    let mut lines = Vec::with_capacity(4 * CHUNK);
    loop {
        let read = match input.read(&mut chunk) {
            Ok(read) => read,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => return Err(Error::Input(error)),
        };
        if read == 0 {
            splitter.end();
        }
        splitter.push(&chunk[..read]);
        while let Some(piece) = splitter.next() {
            let length = piece.bytes.len() as u64;
            match Reading::of(piece, decoding.ignore_checksum) {
                Some(reading) => {
                    tally.count(&reading);
                    write_reading(&mut lines, decoding.form, &reading, None).map_err(Error::Output)?;
                }
                None => splitter.count_noise(length),
            }
            if lines.len() > CHUNK {
                out.write_all(&lines).map_err(Error::Output)?;
                lines.clear();
            }
        }
        out.write_all(&lines)
            .and_then(|()| out.flush())
            .map_err(Error::Output)?;
        lines.clear();
        if read == 0 {
            tally.set_passed(splitter.too_long, splitter.noise_bytes);
            return Ok(tally);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::io;
    use std::rc::Rc;

    use backseat_spi::catalogue;
    use serde_json::Value;

    use super::*;

    const JSON: Decoding = Decoding {
        form: Form::Json,
        ignore_checksum: false,
    };
    const TEXT: Decoding = Decoding {
        form: Form::Text { colour: false },
        ignore_checksum: false,
    };

    fn decoded(input: &[u8], decoding: Decoding) -> (String, Tally) {
        let mut out = Vec::new();
        let tally = decode(input, decoding, &mut out).unwrap();
        (String::from_utf8(out).unwrap(), tally)
    }

    fn objects(input: &[u8]) -> (Vec<Value>, Tally) {
        let (text, tally) = decoded(input, JSON);
        let objects = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        (objects, tally)
    }

    /// Every kind of fault that recordings of real traffic have.
    const NASTY: &[u8] = b"login: \r\n\
        $BFCTL,081025.987,1*78\r\n\
        $BPLOG,NVG,ON\n\
        $BFMIS,081026.000,a.dive,Running,*1C\r\n\n\
        \xff\xfe$BFCTL,081025.987,1*79\r\n\
        $BFMSC,081025.987,lev\xe9*00\r\n\
        $BFNVG,0810$BFXYZ,1,2\r\n\
        $BFCTL,081025.987,2\n\
        $,\n\
        $BFSHT,0810";

    #[test]
    fn every_sentence_of_a_nasty_recording_gives_one_object() {
        let (objects, tally) = objects(NASTY);
        let said: Vec<_> = objects
            .iter()
            .map(|object| {
                let object = object.as_object().unwrap();
                assert!(
                    object.contains_key("message") != object.contains_key("error"),
                    "{object:?}"
                );
                let text = |key: &str| object.get(key).and_then(Value::as_str).unwrap_or("").to_owned();
                let line = object.get("line").and_then(Value::as_u64).unwrap_or(0);
                (text("name"), text("checksum"), text("error"), line)
            })
            .collect();
        let right = |name: &str, checksum: &str| (name.to_owned(), checksum.to_owned(), String::new(), 0);
        let wrong = |name: &str, checksum: &str, error: &str, line| {
            (name.to_owned(), checksum.to_owned(), error.to_owned(), line)
        };
        assert_eq!(said[0], right("BFCTL", "valid"));
        assert_eq!(said[1], right("BPLOG", "absent"));
        assert_eq!(said[2].0, "BFMIS");
        assert_eq!(
            said[3],
            wrong("BFCTL", "invalid", "checksum \"79\" is wrong: 78 is right", 6)
        );
        assert_eq!(said[4], wrong("BFMSC", "invalid", "not utf-8 from byte 21 on", 7));
        assert_eq!(
            said[5],
            wrong(
                "BFNVG",
                "absent",
                "cut short: the next sentence begins before the line ends",
                8
            )
        );
        assert_eq!(said[6], wrong("BFXYZ", "absent", "unknown message", 8));
        assert_eq!((said[7].0.as_str(), said[7].3), ("BFCTL", 9));
        assert_eq!(
            said[8],
            wrong("BFSHT", "absent", "cut off: the input ends before the line does", 11)
        );
        assert_eq!(said.len(), 9);
        assert_eq!((tally.sentences(), tally.noise_bytes), (9, 11));
    }

    #[test]
    fn the_summary_names_every_fault_on_one_line() {
        let (_, tally) = decoded(NASTY, TEXT);
        assert_eq!(
            tally.to_string(),
            "9 sentences, 2 read, 2 with a wrong checksum, 1 unknown, 1 not decodable, 1 not utf-8, 2 cut short, \
             11 bytes of noise"
        );
        assert_eq!(
            decoded(b"$BFCTL,081025.987,1*78", TEXT).1.to_string(),
            "1 sentence, 1 read"
        );
    }

    #[test]
    fn people_see_name_title_and_fields_and_what_is_wrong_with_the_line() {
        let (text, _) = decoded(NASTY, TEXT);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[0], "BFCTL  backseat control: created 08:10:25.987, granted yes");
        assert_eq!(lines[1], "BPLOG  logging control: message NVG, on yes  (no checksum)");
        assert_eq!(lines[6], "BFXYZ  error in line 8: unknown message  $BFXYZ,1,2");
        assert!(!text.contains('\u{1b}'));
    }

    #[test]
    fn a_wrong_checksum_can_be_ignored_and_is_told_all_the_same() {
        let ignoring = Decoding {
            ignore_checksum: true,
            ..JSON
        };
        let (text, tally) = decoded(b"$BFCTL,081025.987,1*79\n", ignoring);
        let object: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (&object["checksum"], &object["message"]["granted"]),
            (&"invalid".into(), &true.into())
        );
        assert_eq!(
            tally.to_string(),
            "1 sentence, 1 read, 1 read in spite of a wrong checksum"
        );
    }

    #[test]
    fn ten_megabytes_without_a_line_end_are_one_count() {
        let mut input = b"$BFNVG,".to_vec();
        input.resize(10 << 20, b'7');
        input.extend_from_slice(b"\n$BFCTL,081025.987,1*78\r\n");
        let (objects, tally) = objects(&input);
        assert_eq!((objects.len(), tally.too_long), (1, 1));
    }

    #[test]
    fn a_thousand_unknown_names_are_one_count_more_each_and_no_memory() {
        let input: String = (0..1000).map(|number| format!("$XX{number},1\r\n")).collect();
        let (objects, tally) = objects(input.as_bytes());
        assert_eq!((objects.len(), tally.messages.len()), (1000, 0));
        assert_eq!(tally.to_string(), "1000 sentences, 0 read, 1000 unknown");
    }

    #[test]
    fn a_live_pipe_is_shown_before_more_is_waited_for() {
        /// Gives one sentence at a time, and records what has been written when the next is requested.
        struct Live(usize, Rc<RefCell<Vec<u8>>>);
        impl Read for Live {
            fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
                assert_eq!(self.1.borrow().iter().filter(|byte| **byte == b'\n').count(), self.0);
                let Some(entry) = catalogue().get(self.0) else {
                    return Ok(0);
                };
                self.0 += 1;
                let line = format!("{}\r\n", entry.example);
                out[..line.len()].copy_from_slice(line.as_bytes());
                Ok(line.len())
            }
        }
        struct Shown(Rc<RefCell<Vec<u8>>>);
        impl Write for Shown {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0.borrow_mut().write(bytes)
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let shown = Rc::new(RefCell::new(Vec::new()));
        let tally = decode(Live(0, Rc::clone(&shown)), TEXT, &mut Shown(shown)).unwrap();
        assert_eq!(tally.read(), 71);
    }
}
