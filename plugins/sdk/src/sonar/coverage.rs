//! Which part of an area a sidescan has seen, which gaps are left, and where the next line lies.
//!
//! A survey by a sidescan looks to both sides of its track, but not straight below it. What it sees depends on the
//! altitude, on the range and on what comes back. The parts of this module, in the order of their use:
//!
//! 1. An [`Area`] is a polygon. [`Axes`] are a frame along the survey's lines.
//! 2. A [`PingStack`] takes some successive pings together, and finds what each side has truly seen: a [`Band`] from the
//!    edge of the gap below the vehicle to the range from which nothing comes back. A [`NoiseFloor`] says what the sonar
//!    hears when it is silent. Without pings, [`Look::of_swath`] takes the upper bound that a
//!    [`Swath`](crate::Swath) event reports.
//! 3. A [`Look`] is such a pair of bands at a pose. [`Strips`] makes strips of successive looks, and leaves out turns.
//! 4. A [`CoverageMap`] counts for each cell of the area how many lines have seen it.
//! 5. A [`LineReach`] remembers the bands along a line, and [`Sweep`] lays the next line by them.
//! 6. [`CoverageMap::best_fill`] finds the short line that fills the most gaps for its length.
//!
//! # Why lines come in pairs
//! A sidescan does not see the gap below the vehicle, which is about as wide as the altitude. With even spacing, the two
//! neighbours of a line see its gap, so lines can be as far apart as the outer reach R. [`Sweep`] lays lines in pairs
//! instead. The second line of a pair lies so that its near side sees the gap of the first one, and its own gap is
//! within the far side of the first one. The next pair begins where the outer swaths just overlap. With half of the gap
//! g, a pair advances by 3R - g, where two lines of even spacing advance by 2R.
//!
//! # Sources
//! - H. Choset, "Coverage for robotics - A survey of recent results", *Annals of Mathematics and Artificial
//!   Intelligence* 31 (2001): back-and-forth (boustrophedon) lines as wide apart as the sensor sees.
//! - E. Galceran and M. Carreras, "A survey on coverage path planning for robotics", *Robotics and Autonomous Systems*
//!   61 (2013): coverage with planning while the sensor's footprint is still unknown, and its use under water.
//! - B. Bourgeois, A. Martinez, P. Alleman, J. Cheramie and J. Gravley, "Autonomous Bathymetry Survey System", *IEEE
//!   Journal of Oceanic Engineering* 24 (1999): the next line follows from the swath that the last one achieved.
//! - L. Paull, S. Saeedi, M. Seto and H. Li, "Sensor-Driven Online Coverage Planning for Autonomous Underwater
//!   Vehicles", *IEEE/ASME Transactions on Mechatronics* 18 (2013): with a sidescan, the next leg is the one that gains
//!   most by what the sensor has seen, as [`CoverageMap::best_fill`] does for the gaps.
//!
//! The pairs, the figures and the code are this module's own.

mod area;
mod fill;
mod look;
mod map;
mod noise;
mod reach;
mod stack;
mod sweep;

pub use area::{Area, AreaError, Axes, Place};
pub use fill::{Fill, FillWish};
pub use look::{Band, Look, Strip, Strips};
pub use map::{CoverageMap, Gap, MapError, MapState};
pub use noise::NoiseFloor;
pub use reach::LineReach;
pub use stack::{PingStack, Quality, StackedLook};
pub use sweep::Sweep;
