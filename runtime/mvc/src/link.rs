mod faulty;

pub use faulty::{Chunk, Direction, FaultyLink, LinkFaults};
