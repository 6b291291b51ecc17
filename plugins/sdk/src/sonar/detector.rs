mod row;
mod track;

use core::ops::Range;

use backseat_units::EastNorth;
use backseat_units::math::wrap_180;
use serde::{Deserialize, Serialize};

use super::cells::Cells;
use super::contact::{Contact, Hit};
use super::gain::Gain;
use super::geometry::{first_return_m, shadow_height_m, slant_m};
use super::look::{Look, Pose, Side};
use super::settings::{DetectorSettings, SettingsError};

use row::{Found, RowSearch};
use track::Tracks;

/// The way over which the turn of the track is measured, metres.
const TURN_M: f64 = 4.0;

/// Finds objects that stand on the seabed: a highlight with a shadow behind it, across range and over successive pings.
///
/// [`Detector::look`] takes one ping after the other, keeps a few rows, and returns a contact once the sonar has passed
/// it. For each side it
///
/// 1. projects the samples to cells over the ground, with the altitude or, without bottom lock, the first return;
/// 2. divides them by the empirical [`Gain`];
/// 3. averages the last [`pings`](DetectorSettings::pings) rows;
/// 4. looks for a cell that is brighter than the seabed on its near side, by the F distribution of the looks that the
///    imagery has ([`Chance`](super::Chance));
/// 5. looks for the ends of the shadow behind it by a cumulative sum, and compares its mean with the same seabed. The
///    stated probability of a false alarm is shared evenly: the root of it for the highlight, the root for the shadow;
/// 6. joins the hits of successive pings to a track, and makes a [`Contact`] of a track that has ended.
///
/// That objects show as highlight and shadow, and that both are compared with the seabed beside them, is the base of the
/// detectors of Dobeck, Hyland and Smedley 1997 ("Automated detection/classification of sea mines in sonar imagery",
/// *Proceedings of SPIE* 3079), whose matched filter has the same windows, and of Reed, Petillot and Bell 2003 ("An
/// automatic approach to the detection and extraction of mine features in sidescan sonar", *IEEE Journal of Oceanic
/// Engineering* 28(1)), who segment the picture instead. The threshold is that of Finn and Johnson 1968; the reference
/// leaves out what is bright in it, after Rohling 1983 ("Radar CFAR thresholding in clutter and multiple target
/// situations", *IEEE Transactions on Aerospace and Electronic Systems* 19(4)).
///
/// While the track turns, the sonar sees the same seabed again on the inside and skips some on the outside. The detector
/// then learns nothing and makes no contacts. [`Detector::hits`] works all the same: see [`Aspects`](super::Aspects).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detector {
    settings: DetectorSettings,
    cells: Cells,
    sides: [SideState; 2],
    turn: Turn,
    poses: Vec<Pose>,
    altitude_m: Option<f64>,
    #[serde(skip)]
    hits: Vec<Hit>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SideState {
    gain: Gain,
    search: RowSearch,
    tracks: Tracks,
    /// The last rows, oldest first, each with the cells that are known.
    rows: Vec<(Vec<f32>, (usize, usize))>,
}

/// How fast the track turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Turn {
    last: Option<(EastNorth, f64)>,
    turned_deg: f64,
    way_m: f64,
}

impl Turn {
    /// Degrees a metre, over the last metres.
    fn deg_per_m(&mut self, pose: &Pose) -> f64 {
        if let Some((at, heading_deg)) = self.last {
            let way_m = at.distance_m(pose.at);
            let left = (1.0 - way_m / TURN_M).max(0.0);
            self.turned_deg = self.turned_deg * left + wrap_180(pose.heading_deg - heading_deg);
            self.way_m = self.way_m * left + way_m;
        }
        self.last = Some((pose.at, pose.heading_deg));
        self.turned_deg.abs() / self.way_m.max(0.1)
    }
}

impl Detector {
    /// A detector that knows nothing of the seabed yet.
    ///
    /// # Errors
    /// [`SettingsError`] with the first setting that is out of its range.
    pub fn new(settings: DetectorSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        let cells = Cells {
            cell_m: settings.cell_m,
            count: (settings.range_m / settings.cell_m) as usize,
        };
        let side = || SideState {
            gain: Gain::new(cells.count, settings.memory_pings),
            search: RowSearch::new(&settings, &cells),
            tracks: Tracks::default(),
            rows: Vec::new(),
        };
        Ok(Self {
            settings,
            cells,
            sides: [side(), side()],
            turn: Turn::default(),
            poses: Vec::new(),
            altitude_m: None,
            hits: Vec::new(),
        })
    }

    /// Takes one ping, and returns the contacts that end with it.
    pub fn look(&mut self, look: &Look<'_>) -> Vec<Contact> {
        let mut contacts = Vec::new();
        self.hits.clear();
        let altitude_m = look.pose.altitude_m.or_else(|| first_return_m(look));
        self.altitude_m = altitude_m.or(self.altitude_m);
        let Some(altitude_m) = self.altitude_m.filter(|altitude_m| *altitude_m > 0.0) else {
            return contacts;
        };
        let is_steady = self.turn.deg_per_m(&look.pose) <= self.settings.turn_deg_per_m;
        let kept = usize::from(self.settings.pings);
        if self.poses.len() >= kept {
            self.poses.remove(0);
        }
        self.poses.push(look.pose);
        let middle = self.poses[self.poses.len() / 2];
        for (state, side) in self.sides.iter_mut().zip(Side::BOTH) {
            let Some(strip) = look.side(side) else {
                state.rows.clear();
                continue;
            };
            let mut row = if state.rows.len() >= kept {
                state.rows.remove(0).0
            } else {
                Vec::new()
            };
            let reached = self.cells.project(strip, altitude_m, &mut row);
            if is_steady {
                state.gain.learn(&row, reached.clone());
            }
            let known = state.gain.normalise(&mut row, reached);
            state.rows.push((row, (known.start, known.end)));
            if state.rows.len() < kept {
                continue;
            }
            let (mean, known) = state.mean();
            let from = (altitude_m * self.settings.nadir / self.settings.cell_m) as usize;
            if is_steady {
                state.search.learn(&mean, known.start.max(from)..known.end);
            }
            let mut found = Vec::new();
            state.search.search(&mean, known, from, &mut found);
            let first = self.hits.len();
            let cells = self.cells;
            self.hits
                .extend(found.iter().map(|found| hit(found, &cells, side, &middle, altitude_m)));
            if is_steady {
                let hits = &self.hits[first..];
                state.tracks.ping(hits, &middle, &self.settings, &mut contacts);
            } else {
                state.tracks.end(&self.settings, &mut contacts);
            }
        }
        contacts
    }

    /// What the last ping, with those before it, shows: also while the track turns.
    #[must_use]
    pub fn hits(&self) -> &[Hit] {
        &self.hits
    }

    /// The altitude that was used last, metres.
    #[must_use]
    pub fn altitude_m(&self) -> Option<f64> {
        self.altitude_m
    }

    /// The looks that a highlight and the shortest shadow have in the imagery of a side, as measured; 0 before they are
    /// known. They decide the thresholds.
    #[must_use]
    pub fn looks(&self, side: Side) -> (f64, f64) {
        self.sides[usize::from(side == Side::Starboard)].search.looks()
    }

    /// Ends all tracks, at the end of a survey, and returns their contacts.
    pub fn end(&mut self) -> Vec<Contact> {
        let mut contacts = Vec::new();
        for side in &mut self.sides {
            side.tracks.end(&self.settings, &mut contacts);
        }
        contacts
    }
}

impl SideState {
    /// The mean of the last rows, and the cells that all of them know.
    fn mean(&self) -> (Vec<f32>, Range<usize>) {
        let mut mean = vec![0.0; self.rows[0].0.len()];
        let mut known = 0..usize::MAX;
        for (row, (start, end)) in &self.rows {
            known = known.start.max(*start)..known.end.min(*end);
            for (mean, cell) in mean.iter_mut().zip(row) {
                *mean += cell;
            }
        }
        let part = 1.0 / self.rows.len() as f32;
        for mean in &mut mean {
            *mean *= part;
        }
        (mean, known.start..known.end.max(known.start))
    }
}

fn hit(found: &Found, cells: &Cells, side: Side, pose: &Pose, altitude_m: f64) -> Hit {
    let edge_m = |cell: usize| cells.edge_m(cell);
    let (near_m, far_m) = (edge_m(found.highlight.0), edge_m(found.highlight.1));
    let ground_m = 0.5 * (near_m + far_m);
    let begin_m = slant_m(edge_m(found.shadow.0), altitude_m);
    let shadow_m = slant_m(edge_m(found.shadow.1), altitude_m) - begin_m;
    Hit {
        side,
        at: pose.beside(side, ground_m),
        from: pose.at,
        ground_m,
        highlight_m: far_m - near_m,
        shadow_slant_m: begin_m,
        shadow_m,
        cut: found.cut,
        height_m: shadow_height_m(altitude_m, begin_m, shadow_m),
        brighter: found.brighter,
        darker: found.darker,
        score: found.score,
    }
}
