//! The format of a file: a header, then the artefact as the engine serialized it.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 7 | `BACKSEAT` |
//! | 8 to 11 | the version of this format |
//! | 12 to 43 | SHA-256 of the component |
//! | 44 to 75 | hash of the engine's version and settings |
//! | 76 to 83 | length of the artefact |
//! | 84 to 115 | SHA-256 of the artefact |
//! | 116 to the end | the artefact |
//!
//! Numbers are little-endian. Each byte counts: none can change without a check that fails.

use sha2::{Digest, Sha256};

use crate::cache::fault::Flaw;
use crate::cache::key::{Hash256, Key, VERSION};

const MAGIC: &[u8; 8] = b"BACKSEAT";
/// The bytes before the artefact.
pub(super) const HEADER: usize = 116;

/// The header of an artefact.
pub(super) fn header(key: &Key, artefact: &[u8]) -> [u8; HEADER] {
    let digest: Hash256 = Sha256::digest(artefact).into();
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

/// The artefact of a file that was written for this key.
pub(super) fn artefact<'a>(file: &'a [u8], key: &Key) -> Result<&'a [u8], Flaw> {
    let (magic, rest) = file.split_first_chunk::<8>().ok_or(Flaw::Short)?;
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
    let (digest, artefact) = rest.split_first_chunk::<32>().ok_or(Flaw::Short)?;
    if *component != key.component {
        return Err(Flaw::Component);
    }
    if *settings != key.settings {
        return Err(Flaw::Settings);
    }
    let length = u64::from_le_bytes(*length);
    if length != artefact.len() as u64 {
        return Err(Flaw::Length {
            records: length,
            has: artefact.len() as u64,
        });
    }
    if *digest != Hash256::from(Sha256::digest(artefact)) {
        return Err(Flaw::Digest);
    }
    Ok(artefact)
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

    #[test]
    fn what_was_written_is_read() {
        assert_eq!(artefact(&file(), &key(b"plugin")), Ok(&b"native code"[..]));
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
        assert_eq!(of(|file| file[8] = 2), Some(Flaw::Version { found: 2 }));
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
