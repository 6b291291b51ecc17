//! Locks: what a mission was when somebody checked it, by hash, with that person's signature.
//!
//! A lock is a text file. It has the SHA-256 of everything that decides what a vehicle may be asked for: the mission as the
//! program resolved it, its limits, its fence, the plan that it names, each plugin's component, and the program itself. The
//! signature is Ed25519's (RFC 8032) of these lines. A runtime that is told which key to trust computes the same hashes of what
//! it has loaded, and does not start if one differs.
//!
//! Hashes are of what was loaded into memory and is going to be used, never of files that are read a second time.

mod contents;
mod difference;
mod error;
mod key;
mod signed;

pub use contents::{Contents, Parts, sha256};
pub use difference::Difference;
pub use error::LockError;
pub use key::{PublicKey, SecretKey, create_keys};
pub use signed::{open, open_unverified, seal};

/// The name of a mission's lock in its folder.
pub const LOCK: &str = "mission.lock";
