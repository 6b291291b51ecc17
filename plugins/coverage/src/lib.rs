//! Surveys an area by sidescan, line by line: each line lies as far from the last one as the swath allows that the sonar
//! has truly achieved there. Then short lines fill the gaps.
//!
//! The lines are inserts, which the vehicle flies by itself, one after the other. The vehicle returns to its own plan
//! when nothing is queued, so it must receive the next line before the current one ends. [`Coverage`] therefore decides
//! on the next line a little before the end of the current one.
//!
//! # The survey
//! 1. *Marking.* Some pings together give what each side sees: from the edge of the gap below the vehicle to where the
//!    signal ends. What successive looks see is marked in a map of the area; turns are left out. Without pings, the
//!    swath that the runtime reports takes their place.
//! 2. *Lines.* A sweep across the area lays lines in pairs. The worst reach along the last line is the reach that the
//!    next line is expected to have. If the water gets deeper, the gap below the vehicle grows and the reach shrinks,
//!    so lines come closer.
//! 3. *Gaps.* What single places have missed is left in the map. The line that sees most of it for its way is flown
//!    next, as long as one is worth it.
//!
//! The tools are those of [`backseat_sdk::sonar::coverage`], which also names the papers they follow. This plugin differs
//! from them in these ways: Bourgeois et al. (1999) let a multibeam's swath lay the next line along its edge, and this
//! plugin keeps its lines parallel, because a sidescan's gap must be seen from the next line. Paull et al. (2013) choose
//! each leg by what it gains; this plugin does so for gaps only, and covers the open area by back-and-forth lines as in
//! Choset (2001). Galceran and Carreras (2013) list both kinds.

mod config;
mod dial;
mod lines;
mod observer;
mod plugin;
mod queue;

pub use config::{AreaConfig, Config, ConfigError, NoiseConfig, RangeConfig};
pub use plugin::Coverage;

backseat_sdk::export!(Coverage);
