//! What a sidescan sonar and a sub-bottom profiler see in a [`World`](backseat_world::World).
//!
//! [`SideScan`] and [`SubBottom`] turn a [`Pose`] and settings into the samples of one ping. They are pure: no clock, no
//! input or output, and each ping is a function of the world, the pose, the settings, the seed, the sonar's name and the
//! number of the ping. So a ping that is left out changes no other.
//!
//! # Sidescan
//!
//! The sonar looks in a plane across the vehicle, which pitch tilts and heading turns. Along that plane it looks the
//! seabed up every 12.5 m at most and puts cubics between, with the depths and the slopes of the world. On a seabed that
//! the seed draws, that is within 1 mm of the world for meanders and banks of 50 m radius, 2 cm for banks of 20 m radius
//! and 10 m height, and 7 cm for the shortest and steepest meanders that a world can have (50 m, a slope of 0.5). A grid
//! has edges at the middles of its cells: there the error is at most an eighth of 12.5 m times the change of slope. Then it
//! walks outwards in steps of an eighth of the slant range; from step to step what comes back is a straight line over
//! slant range (0.05 dB).
//!
//! | what | how | where |
//! |---|---|---|
//! | slant range | distance from the sonar to the seabed's own shape: the water column is dark, and the first return is at the altitude, or nearer on a slope | `sidescan/swath` |
//! | levels | source + power + gains - 40 log r - 2 α r + target strength | `sidescan/ranging` |
//! | absorption α | Francois and Garrison (1982) | [`Water`] |
//! | gain with time | 30 log r + 2 α r | [`SideScan::tvg_db`] |
//! | beams | Gaussian: across track about 30 degrees down, turned by roll; along track 0.88 λ / 0.7 m, so targets smear with range | `beam`, `sidescan/ranging` |
//! | seabed | Lambert's law by texture, with reflection from facets near the vertical (APL-UW TR 9407, simplified) | `backscatter` |
//! | its area | beam width times the pulse along the seabed, √(2 r Δ) straight below (Lurton 2010) | `sidescan/swath` |
//! | textures | the edges of patches are where the plane crosses them | `sidescan/swath` |
//! | targets | a highlight with the target's strength, from the foot of its near side to the last place that sound reaches; then a shadow to where the ray over that place meets the seabed | `sidescan/objects` |
//! | terrain | the seabed shadows itself, and pieces with the same slant range add up | `sidescan/swath` |
//! | surface | Lambert's law on a plane, if asked for | [`SideScan::with_surface`] |
//! | noise | wind and heat (Coates 1989), in the band of the pulse and the directions of the beam | `level` |
//! | speckle | Rayleigh, correlated over the pulse | `speckle` |
//!
//! # Sub-bottom
//!
//! The bed is a mirror with the reflectivity of its texture, and so is each layer below it; a target is a point. Their
//! pulses are compressed sweeps with the phase of their distance, so layers are lines from ping to ping. Between the
//! boundaries the sediment scatters a little, and attenuates; each boundary lets through what it does not reflect. Sound
//! is as fast in sediment as in water.
//!
//! # What this is not
//!
//! - No multipath: no second echo of seabed or surface, no echo from the hull.
//! - No bending of rays: the speed of sound is one figure, that of the settings, and rays are straight.
//! - No motion within a ping: the sonar hears from where it sent, at one pose.
//! - No side lobes but an even floor, no grating lobes, no crosstalk between sides or sonars, no interference of phases
//!   on the sidescan: powers add, and speckle stands for the phases.
//! - Absorption is that of one place and time, see [`Water::of`]. Levels of source and vehicle are figures typical of the
//!   class, and not a maker's; samples are not calibrated.
//! - Targets are simple shapes on the seabed with one strength each, whatever the aspect. A target that only part of the
//!   beam meets shadows that part in all of the ping. They do not hide the far side of the seabed from the sub-bottom.
//! - Patches of texture have sharp edges, also where the beam is wide. There is no small-scale relief such as ripples.

mod absorption;
mod backscatter;
mod beam;
mod error;
mod level;
mod pose;
mod settings;
mod sidescan;
mod speckle;
mod subbottom;

pub use absorption::Water;
pub use error::AcousticsError;
pub use pose::Pose;
pub use settings::{SAMPLES_MAX, SideScanSettings, SubBottomSettings};
pub use sidescan::SideScan;
pub use subbottom::SubBottom;
