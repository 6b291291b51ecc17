//! Each capability against the mock vehicle: its good path, refused, without an answer, the link lost midway.

mod capabilities;
mod helm;
mod recovery;
mod terms;
mod unheard;
