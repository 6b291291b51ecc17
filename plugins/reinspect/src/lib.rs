//! Looks at objects on the seabed again, from all sides: it searches the sidescan's imagery for contacts while the
//! vehicle flies its own plan, and circles each good one.
//!
//! [`Detector`](backseat_sdk::sonar::Detector) finds highlights with shadows, and
//! [`Sightings`](backseat_sdk::sonar::Sightings) merges what several lines show. For each object of a height and a size
//! that the mission asks for, the plugin inserts a trackcircle, with a radius by which the object lies well inside the
//! swath. The vehicle flies it when its leg ends, and then goes on with its plan by itself. During the circle
//! [`Aspects`](backseat_sdk::sonar::Aspects) counts from how many sides the object shows: that confirms or rejects it.
//!
//! That a vehicle which detects on board should turn to a contact at once, and see it from other aspects, is the idea of
//! Zerr, Bovio and Stage 2001 ("Automatic mine classification approach based on AUV manoeuverability and COTS side scan
//! sonar", *Proceedings of the GOATS 2000 Conference*, SACLANTCEN). How much further aspects of an object tell is in
//! Reed, Petillot and Bell 2004 ("Automated approach to classification of mine-like objects in sidescan sonar using
//! highlight and shadow information", *IEE Proceedings - Radar, Sonar and Navigation* 151(1)), who fuse several views.

mod config;
mod inspection;
mod plugin;

pub use config::{Config, ConfigError};
pub use plugin::Reinspect;

backseat_sdk::export!(Reinspect);
