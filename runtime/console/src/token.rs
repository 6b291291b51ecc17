use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;

use subtle::ConstantTimeEq as _;

/// What a person must know to hold or release: 32 hexadecimal digits, new at each start.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// Draws a token, and writes it to a file that only its owner can read. A file that is there is replaced.
    ///
    /// # Errors
    ///
    /// If the system has no random numbers, or the file cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        let token = Self::draw()?;
        // A file with other permissions is not written to.
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            Ok(()) | Err(_) => {}
        }
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)?;
        file.write_all(token.0.as_bytes())?;
        file.write_all(b"\n")?;
        Ok(token)
    }

    fn draw() -> io::Result<Self> {
        let mut bytes = [0u8; 16];
        getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Whether this is the token. The time that this takes does not depend on where they differ.
    pub(crate) fn is(&self, given: &str) -> bool {
        self.0.as_bytes().ct_eq(given.trim().as_bytes()).into()
    }

    #[cfg(test)]
    pub(crate) fn text(&self) -> &str {
        &self.0
    }
}

/// Without the token.
impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn a_token_is_new_each_time_and_only_its_owner_can_read_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("console.token");
        std::fs::write(&path, "old").unwrap();
        let first = Token::create(&path).unwrap();
        let second = Token::create(&path).unwrap();
        assert_ne!(first.text(), second.text());
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let written = std::fs::read_to_string(&path).unwrap();
        assert!(second.is(&written) && !first.is(&written) && !second.is(""));
        assert_eq!(format!("{second:?}"), "Token");
    }
}
