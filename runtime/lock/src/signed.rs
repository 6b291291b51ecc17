use std::path::Path;

use crate::contents::Contents;
use crate::error::LockError;
use crate::key::{PublicKey, SecretKey, read_file};

/// Before the signature, which is of everything in front of this line.
const MARK: &str = "\n# The signature is of all lines above.\nsignature = \"";
/// A lock is shorter than this, bytes.
const LONGEST: u64 = 1 << 20;
/// How a lock is made.
const SIGN: &str = "sign the mission with `backseat check MISSION --sign NAME.key`";

/// The text of a lock.
#[must_use]
pub fn seal(contents: &Contents, key: &SecretKey) -> String {
    let head = "# What this mission was when it was checked and signed. `backseat run --locked KEY.pub` starts only if nothing\n\
                # has changed since. Written by `backseat check --sign`; whoever changes it breaks the signature.\n\n";
    // Everything in it can be written as TOML.
    let body = format!("{head}{}", toml::to_string(contents).unwrap_or_default());
    let signature = key.sign(&body);
    format!("{body}{MARK}{signature}\"\n")
}

/// Reads a lock, and checks that this key has signed it.
///
/// # Errors
///
/// [`LockError`] with the file.
pub fn open(path: &Path, key: &PublicKey) -> Result<Contents, LockError> {
    read(path, Some(key))
}

/// Reads a lock, whoever has signed it: to tell people how the mission differs from it, never to trust it.
///
/// # Errors
///
/// [`LockError`] with the file.
pub fn open_unverified(path: &Path) -> Result<Contents, LockError> {
    read(path, None)
}

fn read(path: &Path, key: Option<&PublicKey>) -> Result<Contents, LockError> {
    let damaged = |message: String| LockError::Lock {
        path: path.to_path_buf(),
        message: message.trim().replace('\n', " "),
    };
    let text = read_file(path, LONGEST, SIGN)?;
    let (body, signature) = text
        .split_once(MARK)
        .and_then(|(body, rest)| Some((body, rest.strip_suffix("\"\n")?)))
        .ok_or_else(|| damaged("it has no signature".to_owned()))?;
    if let Some(key) = key
        && !key.has_signed(body, signature)
    {
        return Err(LockError::Signature {
            path: path.to_path_buf(),
            key: key.path().to_path_buf(),
        });
    }
    let contents: Contents = toml::from_str(body).map_err(|error| damaged(error.message().to_owned()))?;
    if !contents.is_known() {
        return Err(damaged("another version of the program wrote it".to_owned()));
    }
    Ok(contents)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contents::Parts;
    use crate::key::create_keys;

    fn contents() -> Contents {
        let parts = Parts {
            name: "m",
            file: b"",
            mission: "[limits]\nx = 1\n",
            fence: b"{}",
            plan: None,
            components: &[("p".to_owned(), vec![1])],
            swaps: &[],
            program_sha256: "program",
        };
        Contents::of(&parts, "Ann \"the\" captain", "2026-06-01T08:00:00Z")
    }

    #[test]
    fn a_lock_is_opened_only_by_the_key_of_who_signed_it_and_only_unchanged() {
        let folder = tempfile::tempdir().unwrap();
        let keys = |name: &str| create_keys(&folder.path().join(name)).unwrap();
        let ((ann, ann_public), (_, bob_public)) = (keys("ann"), keys("bob"));
        let path = folder.path().join("mission.lock");
        let text = seal(&contents(), &SecretKey::read(&ann).unwrap());
        std::fs::write(&path, &text).unwrap();
        let key = PublicKey::read(&ann_public).unwrap();
        assert_eq!(open(&path, &key).unwrap(), contents());
        let error = open(&path, &PublicKey::read(&bob_public).unwrap()).unwrap_err();
        assert!(error.to_string().contains("not signed with the key of"), "{error}");
        // Any other byte.
        for place in 0..text.len() {
            let mut other = text.clone().into_bytes();
            other[place] ^= 1;
            std::fs::write(&path, other).unwrap();
            assert!(open(&path, &key).is_err(), "byte {place}");
        }
        for other in ["", "signature = \"\"\n", &text[..text.len() / 2], &format!("{text}\n")] {
            std::fs::write(&path, other).unwrap();
            let error = open(&path, &key).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn keys_are_made_once_and_a_secret_one_is_secret() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("ann");
        let (secret, public) = create_keys(&name).unwrap();
        assert_eq!(std::fs::metadata(&secret).unwrap().permissions().mode() & 0o777, 0o600);
        let error = create_keys(&name).unwrap_err().to_string();
        assert!(error.contains("ann.key: is there already"), "{error}");
        let error = SecretKey::read(&public).err().unwrap().to_string();
        assert!(
            error.contains("others can read") || error.contains("is no secret key"),
            "{error}"
        );
        let error = PublicKey::read(&secret).unwrap_err().to_string();
        assert!(error.contains("is no public key"), "{error}");
        let error = PublicKey::read(Path::new("/dev/zero")).unwrap_err().to_string();
        assert!(error.contains("expected a file of at most"), "{error}");
        let twice = std::fs::read_to_string(&public).unwrap().repeat(2);
        std::fs::write(&public, &twice).unwrap();
        assert!(PublicKey::read(&public).is_err(), "two keys");
        let one: Vec<&str> = twice.lines().take(2).collect();
        std::fs::write(&public, one.join("\n")).unwrap();
        std::fs::set_permissions(&public, std::fs::Permissions::from_mode(0o666)).unwrap();
        let error = PublicKey::read(&public).unwrap_err().to_string();
        assert!(error.contains("others can write this key"), "{error}");
        std::fs::set_permissions(&secret, std::fs::Permissions::from_mode(0o640)).unwrap();
        let error = SecretKey::read(&secret).err().unwrap().to_string();
        assert!(error.contains("others can read this secret key"), "{error}");
    }
}
