//! Hits of successive pings that belong together.

use backseat_units::EastNorth;
use serde::{Deserialize, Serialize};

use crate::sonar::contact::{Contact, Hit};
use crate::sonar::look::Pose;
use crate::sonar::settings::DetectorSettings;

/// How many hits the medians of a contact are taken from.
const KEPT: usize = 64;
/// How many tracks of a side may be open.
const OPEN_MAX: usize = 32;

/// An object that pings show at this moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Track {
    best: Hit,
    pose: Pose,
    first: EastNorth,
    last: EastNorth,
    ground_m: f64,
    misses: u8,
    pings: u16,
    weights: f64,
    /// Sums by weight.
    place: EastNorth,
    ranges_m: f64,
    cuts: u16,
    slants_m: Vec<f32>,
    highlights_m: Vec<f32>,
    shadows_m: Vec<f32>,
    heights_m: Vec<f32>,
    hit: bool,
}

impl Track {
    fn new(hit: &Hit, pose: &Pose) -> Self {
        let mut track = Self {
            best: *hit,
            pose: *pose,
            first: hit.from,
            last: hit.from,
            ground_m: hit.ground_m,
            misses: 0,
            pings: 0,
            weights: 0.0,
            place: EastNorth::default(),
            ranges_m: 0.0,
            cuts: 0,
            slants_m: Vec::new(),
            highlights_m: Vec::new(),
            shadows_m: Vec::new(),
            heights_m: Vec::new(),
            hit: false,
        };
        track.take(hit, pose);
        track
    }

    fn take(&mut self, hit: &Hit, pose: &Pose) {
        if hit.score > self.best.score {
            (self.best, self.pose) = (*hit, *pose);
        }
        self.last = hit.from;
        self.ground_m = hit.ground_m;
        self.misses = 0;
        self.pings = self.pings.saturating_add(1);
        let weight = hit.score.max(1e-3);
        self.weights += weight;
        self.place = self.place + hit.at * weight;
        self.ranges_m += hit.ground_m * weight;
        self.cuts = self.cuts.saturating_add(u16::from(hit.cut));
        if self.slants_m.len() < KEPT {
            self.slants_m.push(hit.shadow_slant_m as f32);
            self.highlights_m.push(hit.highlight_m as f32);
            self.shadows_m.push(hit.shadow_m as f32);
            self.heights_m.push(hit.height_m as f32);
        }
        self.hit = true;
    }

    /// The contact, if enough pings showed it. `averaged` pings are in each hit.
    fn contact(mut self, settings: &DetectorSettings) -> Option<Contact> {
        if self.pings < settings.hits {
            return None;
        }
        let at = self.place * (1.0 / self.weights);
        let position = self.pose.position_of(at);
        let way_m = self.first.distance_m(self.last);
        let each_m = way_m / f64::from(self.pings.max(2) - 1);
        Some(Contact {
            side: self.best.side,
            at,
            latitude_deg: position.latitude,
            longitude_deg: position.longitude,
            from: self.best.from,
            ground_m: self.ranges_m / self.weights,
            slant_m: median(&mut self.slants_m),
            highlight_m: median(&mut self.highlights_m),
            shadow_m: median(&mut self.shadows_m),
            height_m: median(&mut self.heights_m),
            cut: 2 * self.cuts > self.pings,
            length_m: (way_m - each_m * f64::from(settings.pings - 1)).max(each_m),
            pings: self.pings,
            score: self.best.score,
        })
    }
}

fn median(values: &mut [f32]) -> f64 {
    values.sort_unstable_by(f32::total_cmp);
    values.get(values.len() / 2).copied().map_or(0.0, f64::from)
}

/// The tracks of one side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tracks(Vec<Track>);

impl Tracks {
    /// Takes the hits of a ping and returns the contacts that it ends.
    pub(super) fn ping(&mut self, hits: &[Hit], pose: &Pose, settings: &DetectorSettings, out: &mut Vec<Contact>) {
        for track in &mut self.0 {
            track.hit = false;
        }
        for hit in hits {
            let has_room = self.0.len() < OPEN_MAX;
            let nearest = self
                .0
                .iter_mut()
                .filter(|track| !track.hit)
                .map(|track| ((track.ground_m - hit.ground_m).abs(), track))
                .filter(|(off_m, _)| *off_m <= settings.join_m)
                .min_by(|one, other| one.0.total_cmp(&other.0));
            match nearest {
                Some((_, track)) => track.take(hit, pose),
                None if has_room => self.0.push(Track::new(hit, pose)),
                None => {}
            }
        }
        let mut index = 0;
        while index < self.0.len() {
            let track = &mut self.0[index];
            if !track.hit {
                track.misses = track.misses.saturating_add(1);
            }
            let too_long = track.first.distance_m(track.last) > settings.length_max_m;
            if track.misses > settings.gap_pings || too_long {
                out.extend(self.0.remove(index).contact(settings));
            } else {
                index += 1;
            }
        }
    }

    /// Ends all tracks.
    pub(super) fn end(&mut self, settings: &DetectorSettings, out: &mut Vec<Contact>) {
        out.extend(self.0.drain(..).filter_map(|track| track.contact(settings)));
    }
}
