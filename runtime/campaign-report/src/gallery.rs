use backseat_campaign::{CampaignError, Crew, Key, Plan, Prepared, Stop};
use backseat_fence::Kind;
use backseat_sim::survey_map;
use backseat_units::EastNorth;

use crate::ReportError;
use crate::chart::{Ring, Series, tracks};
use crate::outcome::Outcomes;
use crate::worst::worst;

/// The most pictures of worst runs.
const PICTURES: usize = 6;
/// The most tracks of an arm on the map.
const TRACKS: u64 = 24;
/// The fewest tracks of an arm.
const TRACKS_LEAST: u64 = 2;
/// One picture and one track of each arm is drawn for so many runs, so that the report takes a small part of a
/// campaign's time.
const RUNS_OF_PICTURE: u64 = 100;
/// A track has at most so many points.
const POINTS: usize = 400;

/// Pictures of runs, drawn by flying these runs again.
#[derive(Clone, Debug, Default)]
pub struct Gallery {
    /// By run: a picture of it, as SVG.
    pub(crate) runs: Vec<(u64, String)>,
    /// By mission: its name, and the tracks of some runs of each arm, as SVG.
    pub(crate) maps: Vec<(String, String)>,
    /// Why the first run that could not be flown again could not.
    pub(crate) lacking: Option<String>,
}

impl Gallery {
    /// Flies the worst runs and some others again.
    ///
    /// # Errors
    ///
    /// [`ReportError::Chart`]. A run that cannot be flown again has no picture.
    pub fn draw(outcomes: &Outcomes, plan: &Plan, crew: &Crew) -> Result<Self, ReportError> {
        let pictures = (plan.runs() / RUNS_OF_PICTURE).clamp(1, PICTURES as u64);
        let mut gallery = Self::default();
        for worst in worst(outcomes, pictures as usize) {
            let Some(key) = plan.key(worst.run) else { continue };
            match picture(plan, crew, &key) {
                Ok(svg) => gallery.runs.extend(svg.map(|svg| (worst.run, svg))),
                Err(error) => gallery.lacks(worst.run, &error),
            }
        }
        let per_mission = outcomes.arms.len() / plan.missions().max(1);
        for arms in outcomes.arms.chunks(per_mission.max(1)) {
            let mut rings = Vec::new();
            let mut series = Vec::new();
            let mut name = String::new();
            for arm in arms {
                let count = (arm.runs / RUNS_OF_PICTURE).clamp(TRACKS_LEAST, TRACKS).min(arm.runs);
                let mut drawn = Vec::new();
                for place in 0..count {
                    // Another point and another seed each time.
                    let seeds = plan.runs_of_point();
                    let run = arm.first + place * plan.points() / count * seeds + place * seeds / count;
                    let Some(key) = plan.key(run).filter(|_| outcomes.flown[run as usize]) else {
                        continue;
                    };
                    let (prepared, track) = match track(plan, crew, &key) {
                        Ok(Some(flown)) => flown,
                        Ok(None) => continue,
                        Err(error) => {
                            gallery.lacks(run, &error);
                            continue;
                        }
                    };
                    drawn.push(track);
                    if rings.is_empty() {
                        rings = rings_of(&prepared);
                        name.clone_from(&prepared.mission.name);
                    }
                }
                series.push(Series {
                    name: &arm.name,
                    values: drawn,
                });
            }
            if let Some(svg) = tracks(&rings, &series)?.filter(|_| !name.is_empty()) {
                gallery.maps.push((name, svg));
            }
        }
        Ok(gallery)
    }

    fn lacks(&mut self, run: u64, error: &CampaignError) {
        self.lacking.get_or_insert_with(|| format!("run {run}: {error}"));
    }
}

fn picture(plan: &Plan, crew: &Crew, key: &Key) -> Result<Option<String>, CampaignError> {
    let prepared = crew.prepare(plan, key)?;
    let flown = prepared.fly(key.seed, &Stop::default())?;
    Ok(flown.map(|flown| {
        survey_map(
            &prepared.mission,
            &prepared.scenario,
            &flown.report,
            &flown.trace,
            &flown.mvc,
        )
    }))
}

fn track(plan: &Plan, crew: &Crew, key: &Key) -> Result<Option<(Prepared, Vec<EastNorth>)>, CampaignError> {
    let prepared = crew.prepare(plan, key)?;
    let Some(flown) = prepared.fly(key.seed, &Stop::default())? else {
        return Ok(None);
    };
    let frame = *prepared.mission.envelope.fence().frame();
    let step = flown.trace.samples.len().div_ceil(POINTS).max(1);
    let samples = flown.trace.samples.iter().step_by(step);
    let track = samples.map(|sample| frame.to_local(sample.position)).collect();
    Ok(Some((prepared, track)))
}

fn rings_of(prepared: &Prepared) -> Vec<Ring> {
    let zones = prepared.mission.envelope.fence().zones();
    zones
        .flat_map(|zone| {
            let keep_out = matches!(zone.kind(), Kind::KeepOut { .. });
            zone.rings()
                .map(move |ring| Ring {
                    points: ring.points.to_vec(),
                    keep_out,
                })
                .collect::<Vec<_>>()
        })
        .collect()
}
