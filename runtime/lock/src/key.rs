use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ed25519_dalek::{Signature, Signer as _, SigningKey, VerifyingKey};

use crate::error::LockError;

const SECRET: &str = "backseat secret key 1";
const PUBLIC: &str = "backseat public key 1";
/// A key's file is shorter than this, bytes.
const KEY_MAX: u64 = 4096;
/// How a key is made.
const MAKE: &str = "make a pair of keys with `backseat key NAME`";
/// Where a public key comes from.
const COPY: &str = "copy the .pub of whoever signed the mission there; `backseat key NAME` makes a pair";

/// The key with which a person signs.
pub struct SecretKey(SigningKey);

/// The key by which a signature is checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicKey {
    key: VerifyingKey,
    path: PathBuf,
}

/// Makes a pair of keys: `NAME.key`, which only its owner can read, and `NAME.pub`. Returns both paths.
///
/// # Errors
///
/// [`LockError`] if one of the files is there, or cannot be written.
pub fn create_keys(name: &Path) -> Result<(PathBuf, PathBuf), LockError> {
    let with = |extension: &str| {
        let mut path = name.as_os_str().to_owned();
        path.push(extension);
        PathBuf::from(path)
    };
    let (secret, public) = (with(".key"), with(".pub"));
    let mut seed = [0u8; 32];
    getrandom::fill(&mut seed).map_err(|error| LockError::Random(error.to_string()))?;
    let key = SigningKey::from_bytes(&seed);
    write(&secret, 0o600, SECRET, &key.to_bytes())?;
    write(&public, 0o644, PUBLIC, key.verifying_key().as_bytes())?;
    Ok((secret, public))
}

fn write(path: &Path, mode: u32, head: &str, bytes: &[u8]) -> Result<(), LockError> {
    let failed = |source: io::Error| {
        if source.kind() == io::ErrorKind::AlreadyExists {
            LockError::Exists {
                path: path.to_path_buf(),
            }
        } else {
            LockError::file(path, source)
        }
    };
    let opened = OpenOptions::new().write(true).create_new(true).mode(mode).open(path);
    let mut file: File = opened.map_err(failed)?;
    writeln!(file, "{head}\n{}", STANDARD.encode(bytes)).map_err(failed)
}

/// Reads a file, if it is one and no larger than this: not a pipe, on which it would wait, nor a device without an end. The
/// advice says how the file is made.
pub(crate) fn read_file(path: &Path, most: u64, advice: &'static str) -> Result<String, LockError> {
    let about = std::fs::metadata(path).map_err(|source| LockError::read(path, advice, source))?;
    if !about.is_file() || about.len() > most {
        return Err(LockError::NoFile {
            path: path.to_path_buf(),
            most,
        });
    }
    std::fs::read_to_string(path).map_err(|source| LockError::file(path, source))
}

fn read(path: &Path, head: &str, expected: &'static str) -> Result<[u8; 32], LockError> {
    let text = read_file(path, KEY_MAX, MAKE)?;
    let mut lines = text.lines();
    let bytes = (lines.next() == Some(head))
        .then(|| lines.next().and_then(|line| STANDARD.decode(line.trim()).ok()))
        .flatten()
        .and_then(|bytes| <[u8; 32]>::try_from(bytes).ok())
        .filter(|_| lines.next().is_none());
    bytes.ok_or_else(|| LockError::Key {
        path: path.to_path_buf(),
        expected,
    })
}

impl SecretKey {
    /// Reads a secret key that nobody else can read.
    ///
    /// # Errors
    ///
    /// [`LockError`] with the file.
    pub fn read(path: &Path) -> Result<Self, LockError> {
        let about = std::fs::metadata(path).map_err(|source| LockError::read(path, MAKE, source))?;
        // A public key, which all may read, is told as what it is.
        let secret = read(path, SECRET, "secret")?;
        if about.permissions().mode() & 0o077 != 0 {
            return Err(LockError::Permissions {
                path: path.to_path_buf(),
            });
        }
        Ok(Self(SigningKey::from_bytes(&secret)))
    }

    pub(crate) fn sign(&self, text: &str) -> String {
        STANDARD.encode(self.0.sign(text.as_bytes()).to_bytes())
    }
}

impl PublicKey {
    /// Reads a public key.
    ///
    /// # Errors
    ///
    /// [`LockError`] with the file.
    pub fn read(path: &Path) -> Result<Self, LockError> {
        let expected = || LockError::Key {
            path: path.to_path_buf(),
            expected: "public",
        };
        let about = std::fs::metadata(path).map_err(|source| LockError::read(path, COPY, source))?;
        let bytes = read(path, PUBLIC, "public")?;
        if about.permissions().mode() & 0o022 != 0 {
            return Err(LockError::Writable {
                path: path.to_path_buf(),
            });
        }
        let key = VerifyingKey::from_bytes(&bytes).map_err(|_| expected())?;
        Ok(Self {
            key,
            path: path.to_path_buf(),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether this is the signature of the text by the secret key of the pair. Signatures and keys of small order are none.
    pub(crate) fn has_signed(&self, text: &str, signature: &str) -> bool {
        let bytes = STANDARD.decode(signature).ok();
        let bytes = bytes.and_then(|bytes| <[u8; 64]>::try_from(bytes).ok());
        bytes.is_some_and(|bytes| {
            let signature = Signature::from_bytes(&bytes);
            self.key.verify_strict(text.as_bytes(), &signature).is_ok()
        })
    }
}
