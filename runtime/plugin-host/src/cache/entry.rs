//! The format of a file: a header, then the artefact as the engine serialized it.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 7 | `BACKSEAT` |
//! | 8 to 11 | the version of this format |
//! | 12 to 43 | BLAKE3 of the component |
//! | 44 to 75 | hash of the engine's version and settings |
//! | 76 to 83 | length of the artefact |
//! | 84 to 115 | BLAKE3 of the artefact |
//! | 116 to the end | the artefact |
//!
//! Numbers are little-endian. Each byte counts: none can change without a check that fails.

use std::io::{self, ErrorKind, Read, Write};

use crate::cache::fault::Flaw;
use crate::cache::key::{Hash256, Key, VERSION};

const MAGIC: &[u8; 8] = b"BACKSEAT";
/// The bytes before the artefact.
const HEADER: usize = 116;
/// How much is read, hashed and copied at once, bytes: it stays in the processor's cache.
const PIECE: usize = 256 << 10;

/// The header of an artefact.
pub(super) fn header(key: &Key, artefact: &[u8]) -> [u8; HEADER] {
    let digest: Hash256 = blake3::hash(artefact).into();
    let mut header = [0; HEADER];
    let parts: [&[u8]; 6] = [
        MAGIC,
        &VERSION.to_le_bytes(),
        &key.component,
        &key.settings,
        &(artefact.len() as u64).to_le_bytes(),
        &digest,
    ];
    let mut at = 0;
    for part in parts {
        header[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    }
    header
}

/// Why an artefact was not copied.
#[derive(Debug)]
pub(super) enum NotCopied {
    /// Something is wrong with the file.
    Flaw(Flaw),
    /// Its copy could not be written.
    Written(io::Error),
}

impl From<Flaw> for NotCopied {
    fn from(flaw: Flaw) -> Self {
        Self::Flaw(flaw)
    }
}

/// Copies the artefact of a file of so many bytes that was written for this key. Only if there is no error is the copy the
/// artefact.
pub(super) fn copy(mut file: impl Read, bytes: u64, key: &Key, mut to: impl Write) -> Result<(), NotCopied> {
    let mut header = [0; HEADER];
    let found = fill(&mut file, &mut header)?;
    let (length, digest) = read_header(&header[..found], key)?;
    let has = bytes.saturating_sub(HEADER as u64);
    if length != has {
        return Err(Flaw::Length { records: length, has }.into());
    }
    let (mut hash, mut copied) = (blake3::Hasher::new(), 0);
    let mut piece = vec![0; PIECE];
    loop {
        let found = fill(&mut file, &mut piece)?;
        let piece = &piece[..found];
        copied += found as u64;
        // It has grown or shrunk since it was opened.
        if copied > length || (found == 0 && copied < length) {
            return Err(Flaw::Length {
                records: length,
                has: copied,
            }
            .into());
        }
        if found == 0 {
            break;
        }
        hash.update(piece);
        to.write_all(piece).map_err(NotCopied::Written)?;
    }
    if digest != Hash256::from(hash.finalize()) {
        return Err(Flaw::Digest.into());
    }
    Ok(())
}

/// The length and the BLAKE3 of the artefact, from the header of a file that was written for this key.
fn read_header(header: &[u8], key: &Key) -> Result<(u64, Hash256), Flaw> {
    let (magic, rest) = header.split_first_chunk::<8>().ok_or(Flaw::Short)?;
    if magic != MAGIC {
        return Err(Flaw::Magic);
    }
    let (version, rest) = rest.split_first_chunk::<4>().ok_or(Flaw::Short)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Err(Flaw::Version { found: version });
    }
    let (component, rest) = rest.split_first_chunk::<32>().ok_or(Flaw::Short)?;
    let (settings, rest) = rest.split_first_chunk::<32>().ok_or(Flaw::Short)?;
    let (length, rest) = rest.split_first_chunk::<8>().ok_or(Flaw::Short)?;
    let (digest, _) = rest.split_first_chunk::<32>().ok_or(Flaw::Short)?;
    if *component != key.component {
        return Err(Flaw::Component);
    }
    if *settings != key.settings {
        return Err(Flaw::Settings);
    }
    Ok((u64::from_le_bytes(*length), *digest))
}

/// Reads until the buffer is full or the file ends. Returns how much was read.
fn fill(file: &mut impl Read, buffer: &mut [u8]) -> Result<usize, Flaw> {
    let mut full = 0;
    while full < buffer.len() {
        match file.read(&mut buffer[full..]) {
            Ok(0) => break,
            Ok(read) => full += read,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(Flaw::Read(error.to_string())),
        }
    }
    Ok(full)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wasmtime::{Config, Engine};

    fn key(bytes: &[u8]) -> Key {
        Key::new(&Engine::default(), bytes)
    }

    fn file() -> Vec<u8> {
        [&header(&key(b"plugin"), b"native code")[..], b"native code"].concat()
    }

    /// The artefact of a file.
    fn artefact(file: &[u8], key: &Key) -> Result<Vec<u8>, Flaw> {
        let mut copy = Vec::new();
        match super::copy(file, file.len() as u64, key, &mut copy) {
            Ok(()) => Ok(copy),
            Err(NotCopied::Flaw(flaw)) => Err(flaw),
            Err(NotCopied::Written(error)) => panic!("{error}"),
        }
    }

    #[test]
    fn what_was_written_is_read() {
        assert_eq!(artefact(&file(), &key(b"plugin")), Ok(b"native code".to_vec()));
        // Longer than what is read at once, to the byte and with a rest.
        for length in [0, 1, PIECE - 1, PIECE, PIECE + 1, 3 * PIECE + 7] {
            let code: Vec<u8> = (0..length).map(|at| (at % 251) as u8).collect();
            let file = [&header(&key(b"plugin"), &code)[..], &code].concat();
            assert!(artefact(&file, &key(b"plugin")) == Ok(code), "{length}");
        }
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_noticed() {
        let file = file();
        let copied = |bytes: u64| super::copy(&file[..], bytes, &key(b"plugin"), io::sink());
        assert!(copied(file.len() as u64).is_ok());
        for bytes in [file.len() as u64 - 1, file.len() as u64 + 1] {
            assert!(matches!(copied(bytes), Err(NotCopied::Flaw(Flaw::Length { .. }))));
        }
        let shorter = super::copy(&file[..120], file.len() as u64, &key(b"plugin"), io::sink());
        assert!(matches!(
            shorter,
            Err(NotCopied::Flaw(Flaw::Length { records: 11, has: 4 }))
        ));
    }

    #[test]
    fn a_copy_that_cannot_be_written_is_no_flaw_of_the_file() {
        let file = file();
        let full = super::copy(&file[..], file.len() as u64, &key(b"plugin"), &mut [0; 4][..]);
        assert!(matches!(full, Err(NotCopied::Written(_))));
    }

    #[test]
    fn each_flipped_bit_and_each_cut_is_noticed() {
        let whole = file();
        for at in 0..whole.len() {
            for bit in 0..8 {
                let mut file = whole.clone();
                file[at] ^= 1 << bit;
                assert!(artefact(&file, &key(b"plugin")).is_err(), "bit {bit} of byte {at}");
            }
            assert!(artefact(&whole[..at], &key(b"plugin")).is_err(), "cut at {at}");
        }
        let longer = [&whole[..], b"!"].concat();
        let flaw = Flaw::Length { records: 11, has: 12 };
        assert_eq!(artefact(&longer, &key(b"plugin")), Err(flaw));
    }

    #[test]
    fn each_flaw_has_its_name() {
        let of = |change: fn(&mut Vec<u8>)| {
            let mut file = file();
            change(&mut file);
            artefact(&file, &key(b"plugin")).err()
        };
        assert_eq!(of(Vec::clear), Some(Flaw::Short));
        assert_eq!(of(|file| file.truncate(40)), Some(Flaw::Short));
        assert_eq!(of(|file| file[0] = 0), Some(Flaw::Magic));
        assert_eq!(of(|file| file[8] = 3), Some(Flaw::Version { found: 3 }));
        assert_eq!(
            of(|file| file.truncate(120)),
            Some(Flaw::Length { records: 11, has: 4 })
        );
        assert_eq!(of(|file| file[84] ^= 1), Some(Flaw::Digest));
        assert_eq!(of(|file| file[116] ^= 1), Some(Flaw::Digest));
        assert_eq!(artefact(&file(), &key(b"other")), Err(Flaw::Component));
        let fuelled = Engine::new(Config::new().consume_fuel(true)).unwrap();
        assert_eq!(artefact(&file(), &Key::new(&fuelled, b"plugin")), Err(Flaw::Settings));
    }
}
