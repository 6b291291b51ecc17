//! Properties that all messages of the crate have.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

mod allocation;
mod bad_input;
mod golden;
mod inner_dollar;
mod tolerance;
mod traffic;

use backseat_spi::{Direction, Entry, FromVehicle, Sentence, ToVehicle};

/// A message of either direction.
#[derive(Debug, PartialEq)]
enum Message {
    FromVehicle(FromVehicle),
    ToVehicle(ToVehicle),
}

impl Message {
    fn decode(direction: Direction, line: &str) -> Self {
        let sentence = Sentence::parse(line).unwrap();
        match direction {
            Direction::FromVehicle => Self::FromVehicle(FromVehicle::decode(&sentence).unwrap()),
            Direction::ToVehicle => Self::ToVehicle(ToVehicle::decode(&sentence).unwrap()),
        }
    }

    fn example(entry: &Entry) -> Self {
        Self::decode(entry.direction, entry.example)
    }

    fn encode(&self, out: &mut Vec<u8>) {
        match self {
            Self::FromVehicle(message) => message.encode(out).unwrap(),
            Self::ToVehicle(message) => message.encode(out).unwrap(),
        }
    }

    fn to_json(&self) -> String {
        match self {
            Self::FromVehicle(message) => serde_json::to_string(message).unwrap(),
            Self::ToVehicle(message) => serde_json::to_string(message).unwrap(),
        }
    }

    fn from_json(direction: Direction, name: &str, json: &str) -> serde_json::Result<Self> {
        let mut json = serde_json::Deserializer::from_str(json);
        Ok(match direction {
            Direction::FromVehicle => Self::FromVehicle(FromVehicle::deserialize_named(name, &mut json)?),
            Direction::ToVehicle => Self::ToVehicle(ToVehicle::deserialize_named(name, &mut json)?),
        })
    }
}
