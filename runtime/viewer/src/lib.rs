//! Serves the messages of a run's log while they are recorded, by Foxglove's WebSocket protocol: Foxglove and Lichtblick
//! show a dive as it goes, with the same channels and schemas as its log.
//!
//! A run tells a [`Feed`], which never waits: a bounded queue leads to a thread, and each viewer has a bounded queue after
//! it. A viewer that hangs loses messages, and delays nobody. Viewers can do nothing but look: the server has none of the
//! protocol's capabilities.

mod door;
mod feed;
mod server;
mod words;

pub use feed::Feed;
pub use server::{PORT, Port, ViewerError, serve};
