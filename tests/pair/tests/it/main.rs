//! Each capability with the mock vehicle: accepted, refused, without an answer, and with the link lost midway.

mod capabilities;
mod dives;
mod helm;
mod recovery;
mod terms;
mod unheard;
