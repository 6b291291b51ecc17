//! The state that a plugin keeps over a restart: one field, written and read by `serde`.
//!
//! ```
//! use backseat_sdk::{Description, NoConfig, Plugin, Request, StepInput, survey::InsertQueue};
//! use serde::{Deserialize, Serialize};
//!
//! struct Survey {
//!     state: State,
//! }
//!
//! #[derive(Debug, Default, Serialize, Deserialize)]
//! struct State {
//!     queue: InsertQueue,
//!     steps: u64,
//! }
//!
//! impl Plugin for Survey {
//!     type Config = NoConfig;
//! #   fn describe() -> Description {
//! #       Description { name: "survey".into(), version: "0".into(), step_period_ns: 1_000_000_000, topics: vec![], grants: vec![] }
//! #   }
//! #   fn new(_: NoConfig) -> Result<Self, String> {
//! #       Ok(Self { state: State::default() })
//! #   }
//!
//!     fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
//!         self.state.steps += 1;
//!         Ok(vec![])
//!     }
//!
//!     backseat_sdk::keep!(state);
//! }
//!
//! let mut first = Survey { state: State::default() };
//! first.step(&StepInput::default()).unwrap();
//! let mut second = Survey { state: State::default() };
//! second.restore(&first.snapshot()).unwrap();
//! assert_eq!(second.state.steps, 1);
//! assert!(second.restore(&[1, 2]).unwrap_err().starts_with("the state does not parse"));
//! ```

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Writes [`Plugin::snapshot`](crate::Plugin::snapshot) and [`Plugin::restore`](crate::Plugin::restore) for a field of the
/// plugin. Its type derives `serde::Serialize` and `serde::Deserialize`.
#[macro_export]
macro_rules! keep {
    ($field:ident) => {
        fn snapshot(&self) -> ::std::vec::Vec<u8> {
            $crate::kept::write(&self.$field)
        }

        fn restore(&mut self, state: &[u8]) -> ::std::result::Result<(), ::std::string::String> {
            self.$field = $crate::kept::read(state)?;
            ::std::result::Result::Ok(())
        }
    };
}

/// The bytes of a state. Empty if a map or a sequence in it does not know its length, which no type of this SDK and of the
/// standard library does.
#[must_use]
pub fn write<S: Serialize>(state: &S) -> Vec<u8> {
    postcard::to_allocvec(state).unwrap_or_default()
}

/// The state of these bytes.
///
/// # Errors
/// One line with what is wrong.
pub fn read<S: DeserializeOwned>(state: &[u8]) -> Result<S, String> {
    match postcard::take_from_bytes(state) {
        Ok((state, [])) => Ok(state),
        Ok((_, rest)) => Err(format!("the state does not parse: {} bytes are left", rest.len())),
        Err(error) => Err(format!("the state does not parse: {error}")),
    }
}
