//! Tools for the imagery of a sidescan sonar: from the samples of a ping to places on the seabed, and to contacts.
//!
//! All tools work on plain slices and values, so a test needs no runtime. [`Look::of`] makes their input from the event
//! [`Event::Sidescan`](crate::Event::Sidescan).
//!
//! | tool | what it does |
//! |---|---|
//! | [`ground_m`], [`slant_m`], [`shadow_height_m`], [`first_return_m`] | the geometry of a ping over a level seabed |
//! | [`Cells`] | the samples of one side as intensities in even cells over the ground |
//! | [`Gain`] | takes the falloff with range and the beam pattern out of such rows |
//! | [`Chance`] | thresholds on ratios of intensities, for a stated probability of a false alarm |
//! | [`Detector`] | highlights followed by shadows, over successive pings: [`Contact`]s |
//! | [`Sightings`] | merges what several lines show of the same object |
//! | [`Aspects`] | from how many directions an object is seen |
//!
//! # What is assumed
//!
//! The seabed is level across the track, the sonar sits at the vehicle's navigated place, sound travels straight, and
//! roll and pitch do not matter: a sidescan's beam is wide across the track, so roll changes levels, which [`Gain`] and
//! the detector's local reference take out, and not places. Pitch moves what the beam meets ahead or astern by the
//! altitude times its sine (0.5 m at 10 m and 3 degrees).
//!
//! ```
//! use backseat_sdk::sonar::{Detector, DetectorSettings, Look, Pose, Strip};
//! use backseat_sdk::units::EastNorth;
//!
//! let mut detector = Detector::new(DetectorSettings::default())?;
//! let samples = vec![1.0; 1000];
//! for ping in 0..100 {
//!     let look = Look {
//!         pose: Pose {
//!             at: EastNorth::new(0.0, 0.2 * f64::from(ping)),
//!             latitude_deg: 42.0,
//!             longitude_deg: -70.0,
//!             heading_deg: 0.0,
//!             altitude_m: Some(10.0),
//!         },
//!         port: Some(Strip::along_slant(&samples, 75.0)),
//!         starboard: Some(Strip::along_slant(&samples, 75.0)),
//!     };
//!     assert!(detector.look(&look).is_empty(), "nothing lies on an even seabed");
//! }
//! # Ok::<(), backseat_sdk::sonar::SettingsError>(())
//! ```

mod aspects;
mod cells;
mod chance;
mod contact;
pub mod coverage;
mod detector;
mod gain;
mod geometry;
mod look;
mod settings;
mod sightings;

pub use aspects::{Aspects, Sector, Verdict};
pub use cells::Cells;
pub use chance::Chance;
pub use contact::{Contact, Hit};
pub use detector::Detector;
pub use gain::Gain;
pub use geometry::{first_return_m, ground_m, shadow_height_m, slant_m};
pub use look::{Look, Pose, Side, Strip};
pub use settings::{DetectorSettings, SettingsError};
pub use sightings::{Sighted, Sightings};
