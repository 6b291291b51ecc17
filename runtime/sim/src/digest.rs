use backseat_units::Timestamp;
use sha2::{Digest as _, Sha256};

/// Which way a write on the vehicle link goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the vehicle to the payload: 0 in the digest.
    FromVehicle,
    /// From the payload to the vehicle: 1 in the digest.
    ToVehicle,
    /// From the sonars' payload controller to its client: 2 in the digest.
    FromController,
    /// From the client to the payload controller: 3 in the digest.
    ToController,
}

/// SHA-256 over every write on the vehicle link, and on that to the payload controller, at its sender: direction as one byte, time in nanoseconds as `u64` and
/// length as `u32`, both little-endian, then the bytes.
#[derive(Clone, Debug, Default)]
pub struct Digest(Sha256);

impl Digest {
    /// Adds a write.
    pub fn write(&mut self, direction: Direction, at: Timestamp, bytes: &[u8]) {
        let mut head = [0; 13];
        head[0] = match direction {
            Direction::FromVehicle => 0,
            Direction::ToVehicle => 1,
            Direction::FromController => 2,
            Direction::ToController => 3,
        };
        head[1..9].copy_from_slice(&at.as_nanos().to_le_bytes());
        let length = u32::try_from(bytes.len()).expect("a write on the link is far below 4 GiB");
        head[9..].copy_from_slice(&length.to_le_bytes());
        self.0.update(head);
        self.0.update(bytes);
    }

    /// In hexadecimal.
    #[must_use]
    pub fn finish(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_documented_bytes() {
        let mut digest = Digest::default();
        digest.write(Direction::ToVehicle, Timestamp::from_nanos(258), b"ab");
        let expected = Sha256::digest([1, 2, 1, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'a', b'b']);
        let expected: String = expected.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(digest.finish(), expected);
    }
}
