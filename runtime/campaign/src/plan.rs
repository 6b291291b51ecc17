use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use backseat_scenario::split_sets;
use serde::Serialize;

use crate::design::{Design, Value};
use crate::error::CampaignError;
use crate::faults::DrawnFaults;
use crate::file::{Better, CampaignFile, flat, overlap};
use crate::seeds::Seeds;

/// The most runs of a campaign.
const RUNS_MAX: u64 = 1_000_000_000;

/// A variant of a plan.
#[derive(Clone, Debug)]
struct Variant {
    /// Its name; empty if the campaign has no variants.
    name: String,
    /// `KEY=VALUE` each.
    sets: Vec<String>,
}

/// All runs of a campaign in their canonical order: by mission, then variant, then point, then seed.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The folder that missions are relative to.
    folder: PathBuf,
    /// The missions as they are written.
    missions: Vec<PathBuf>,
    variants: Vec<Variant>,
    design: Design,
    points: u64,
    seeds: Seeds,
    runs: u64,
    faults: Option<DrawnFaults>,
    measure: Option<(String, Better)>,
}

/// What a run is: the place of each of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The run's number, from 0.
    pub run: u64,
    /// The mission's place.
    pub mission: usize,
    /// The variant's place.
    pub variant: usize,
    /// The point, from 0.
    pub point: u64,
    /// The seed.
    pub seed: u64,
}

/// What makes two campaigns the same, as far as their file says it.
#[derive(Clone, Debug, PartialEq, Serialize, serde::Deserialize)]
pub(crate) struct Outline {
    pub(crate) missions: Vec<String>,
    pub(crate) variants: Vec<(String, Vec<String>)>,
    /// Keys, with the values of a few points, which tell designs apart.
    pub(crate) parameters: Vec<String>,
    pub(crate) seeds: String,
    pub(crate) faults: Option<DrawnFaults>,
    pub(crate) runs: u64,
}

impl Plan {
    /// Resolves a campaign's file. `path` is the file, or the mission's folder for a campaign of one mission; `folder` is
    /// what missions are relative to; `sets` are further `KEY=VALUE` for every run.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] with the file and the key.
    pub fn new(file: &CampaignFile, path: &Path, folder: &Path, sets: &[String]) -> Result<Self, CampaignError> {
        let fault = |message: String| CampaignError::value(path, message);
        let parameters = file
            .parameters()
            .map(|parameter| parameter.resolve().map_err(fault))
            .collect::<Result<Vec<_>, _>>()?;
        let design = Design::new(parameters, file.points).map_err(fault)?;
        let points = design.count().map_err(fault)?;
        for set in sets {
            let key = set.split('=').next().unwrap_or_default().trim();
            let parameters = file.parameters().map(|parameter| parameter.key.clone());
            let of_variants = file.variants.iter().flat_map(|variant| flat(&variant.set));
            if let Some(other) = parameters
                .chain(of_variants.map(|(key, _)| key))
                .find(|other| overlap(other, key))
            {
                return Err(CampaignError::Option(format!(
                    "--set {set}: {} sets {other} itself: leave it out",
                    path.display()
                )));
            }
        }
        let common: Vec<String> = lines(&file.set).into_iter().chain(sets.iter().cloned()).collect();
        let with_common = |own: Vec<String>| common.iter().cloned().chain(own).collect();
        let mut variants: Vec<Variant> = file
            .variants
            .iter()
            .map(|variant| Variant {
                name: variant.name.clone(),
                sets: with_common(lines(&variant.set)),
            })
            .collect();
        if variants.is_empty() {
            variants.push(Variant {
                name: String::new(),
                sets: with_common(Vec::new()),
            });
        }
        let runs = [
            file.missions.len() as u64,
            variants.len() as u64,
            points,
            file.seeds.count(),
        ]
        .into_iter()
        .try_fold(1u64, u64::checked_mul)
        .filter(|runs| *runs <= RUNS_MAX)
        .ok_or_else(|| fault(format!("too many runs: expected at most {RUNS_MAX}")))?;
        Ok(Self {
            folder: folder.to_path_buf(),
            missions: file.missions.clone(),
            variants,
            design,
            points,
            seeds: file.seeds.clone(),
            runs,
            faults: file.faults,
            measure: file.report.measure.clone().map(|measure| (measure, file.report.better)),
        })
    }

    /// How many runs there are.
    #[must_use]
    pub const fn runs(&self) -> u64 {
        self.runs
    }

    /// How many missions there are.
    #[must_use]
    pub fn missions(&self) -> usize {
        self.missions.len()
    }

    /// The measure that the report shows first, and which of its values are better.
    #[must_use]
    pub fn measure(&self) -> Option<(&str, Better)> {
        self.measure.as_ref().map(|(name, better)| (name.as_str(), *better))
    }

    /// How many points each mission and variant is flown at.
    #[must_use]
    pub const fn points(&self) -> u64 {
        self.points
    }

    /// How many runs in a row have the same mission, variant and point.
    #[must_use]
    pub const fn runs_of_point(&self) -> u64 {
        self.seeds.count()
    }

    /// What a run is; `None` if there is no run of this number.
    #[must_use]
    pub fn key(&self, run: u64) -> Option<Key> {
        if run >= self.runs {
            return None;
        }
        let (rest, seed) = (run / self.seeds.count(), run % self.seeds.count());
        let (rest, point) = (rest / self.points, rest % self.points);
        let variants = self.variants.len() as u64;
        Some(Key {
            run,
            mission: (rest / variants) as usize,
            variant: (rest % variants) as usize,
            point,
            seed: self.seeds.at(seed)?,
        })
    }

    /// Some runs of each mission and variant, at most so many: at points and seeds that lie at even distances.
    #[must_use]
    pub fn some_runs(&self, most: u64) -> Vec<Key> {
        let seeds = self.seeds.count();
        let of_arm = self.points * seeds;
        let arms = (self.runs / of_arm.max(1)).min(most);
        let varied = self.drawn_from_seeds().any(|drawn| drawn);
        let values = if varied { self.points.max(seeds) } else { self.points };
        let count = (most / arms.max(1)).clamp(1, values);
        let run = |arm: u64, place: u64| {
            let (point, seed) = (place * self.points / count, place * seeds / count);
            arm * of_arm + point * seeds + seed
        };
        (0..arms)
            .flat_map(|arm| (0..count).filter_map(move |place| self.key(run(arm, place))))
            .collect()
    }

    /// If the measure that the report shows first is named, and not among these: which one it is, and these.
    pub(crate) fn unmeasured(&self, names: &BTreeSet<String>) -> Option<String> {
        let (measure, _) = self.measure.as_ref()?;
        let lacks = !names.is_empty() && !names.contains(measure);
        lacks.then(|| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!(
                "report.measure is `{measure}`, which the first runs do not have; they have {}",
                names.join(", ")
            )
        })
    }

    /// The names of the parameters: keys of `mission.toml`, or of `world.toml` behind `world.`.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.design.keys()
    }

    /// The variants: their names, and what each sets.
    pub fn variants(&self) -> impl Iterator<Item = (&str, &[String])> {
        let variants = self.variants.iter();
        variants.map(|variant| (variant.name.as_str(), variant.sets.as_slice()))
    }

    /// For each parameter in words which values it has.
    pub fn ranges(&self) -> impl Iterator<Item = String> {
        self.design.ranges()
    }

    /// The value of each parameter in a run.
    #[must_use]
    pub fn values(&self, key: &Key) -> Vec<Value> {
        self.design.values(key.point, key.seed)
    }

    /// Values of a parameter of every type that it has: all of a list, one of a range.
    pub(crate) fn samples(&self, place: usize) -> Vec<Value> {
        self.design.samples(place, self.seeds.at(0).unwrap_or_default())
    }

    /// For each parameter whether its value is drawn from the seed: then runs of one point differ in it.
    pub fn drawn_from_seeds(&self) -> impl Iterator<Item = bool> {
        self.design.drawn_from_seeds()
    }

    /// For each parameter whether its values are even in their logarithm.
    pub fn logarithmic(&self) -> impl Iterator<Item = bool> {
        self.design.logarithmic()
    }

    /// Everything that a run sets: of `mission.toml`, then of `world.toml`.
    #[must_use]
    pub fn sets(&self, key: &Key) -> (Vec<String>, Vec<String>) {
        split_sets(&self.all_sets(key))
    }

    fn all_sets(&self, key: &Key) -> Vec<String> {
        let mut sets = self.variants[key.variant].sets.clone();
        let values = self.values(key);
        sets.extend(
            self.parameters()
                .zip(&values)
                .map(|(name, value)| format!("{name}={value}")),
        );
        sets
    }

    /// A mission as it is written in the campaign's file.
    #[must_use]
    pub fn mission(&self, key: &Key) -> &Path {
        &self.missions[key.mission]
    }

    /// The name of a run's variant; empty if there are no variants.
    #[must_use]
    pub fn variant(&self, key: &Key) -> &str {
        &self.variants[key.variant].name
    }

    /// Where a mission is.
    #[must_use]
    pub fn place(&self, key: &Key) -> PathBuf {
        self.folder.join(&self.missions[key.mission])
    }

    /// The faults that each run draws.
    #[must_use]
    pub const fn faults(&self) -> Option<DrawnFaults> {
        self.faults
    }

    /// The command that flies a run alone, from the folder of the campaign's file.
    #[must_use]
    pub fn replay(&self, key: &Key) -> String {
        let mut text = format!(
            "backseat sim {} --seed {}",
            word(&self.mission(key).display().to_string()),
            key.seed
        );
        if let Some(faults) = self.faults {
            text.push_str(&format!(" --draw-faults {faults}"));
        }
        for set in self.all_sets(key) {
            text.push_str(&format!(" --set {}", word(&set)));
        }
        text
    }

    pub(crate) fn outline(&self) -> Outline {
        // These tell any two designs apart that differ by more than one value in some thousands.
        const SAMPLES: u64 = 16;
        let parameters = self.parameters().enumerate().map(|(place, name)| {
            let points = (0..self.points.min(SAMPLES)).chain(self.points.checked_sub(1));
            let values = points.filter_map(|point| {
                let seed = self.seeds.at(point % self.seeds.count())?;
                Some(self.design.values(point, seed)[place].to_string())
            });
            format!("{name}: {}", values.collect::<Vec<_>>().join(" "))
        });
        Outline {
            missions: self.missions.iter().map(|path| path.display().to_string()).collect(),
            variants: self
                .variants
                .iter()
                .map(|variant| (variant.name.clone(), variant.sets.clone()))
                .collect(),
            parameters: parameters.collect(),
            seeds: self.seeds.to_string(),
            faults: self.faults,
            runs: self.runs,
        }
    }
}

/// `KEY=VALUE` for each key of a table.
fn lines(table: &toml::Table) -> Vec<String> {
    flat(table)
        .into_iter()
        .map(|(key, value)| format!("{key}={}", Value::of(&value)))
        .collect()
}

/// A word of a shell's command line, in quotes if it needs them.
#[must_use]
pub fn word(text: &str) -> String {
    let plain = |character: char| character.is_ascii_alphanumeric() || "._-/=,:@+".contains(character);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str) -> Plan {
        let file: CampaignFile = toml::from_str(text).unwrap();
        Plan::new(&file, Path::new("campaign.toml"), Path::new("here"), &[]).unwrap()
    }

    const TWO: &str = "missions = [\"a\", \"b c\"]\nseeds = \"1..4\"\n[set]\nlimits.x = 1\n\
                       [[variant]]\nname = \"old\"\nset = { plugin.p.component = \"old\" }\n[[variant]]\nname = \"new\"\n\
                       [[parameter]]\nkey = \"world.current.speed_mps\"\nvalues = [0.0, [0.1, 0.2], 0.5]\n";

    #[test]
    fn a_run_is_its_number() {
        let plan = plan(TWO);
        assert_eq!(plan.runs(), 2 * 2 * 3 * 4);
        let mut next = 0;
        for mission in 0..2 {
            for variant in 0..2 {
                for point in 0..3 {
                    for seed in 1..=4 {
                        let key = Key {
                            run: next,
                            mission,
                            variant,
                            point,
                            seed,
                        };
                        assert_eq!(plan.key(next), Some(key));
                        next += 1;
                    }
                }
            }
        }
        assert_eq!(plan.key(next), None);
    }

    #[test]
    fn a_run_sets_keys_of_both_files_and_can_be_flown_alone() {
        let plan = plan(TWO);
        let key = plan.key(24 + 4).unwrap();
        let (mission, world) = plan.sets(&key);
        assert_eq!(mission, ["limits.x=1", "plugin.p.component=old"]);
        assert_eq!(world, ["world.current.speed_mps=[0.1, 0.2]"]);
        assert_eq!(
            plan.replay(&key),
            "backseat sim 'b c' --seed 1 --set limits.x=1 --set plugin.p.component=old \
             --set 'world.current.speed_mps=[0.1, 0.2]'"
        );
        assert_eq!(plan.place(&key), Path::new("here/b c"));
    }

    #[test]
    fn some_runs_are_of_every_arm_and_of_points_at_even_distances() {
        let plan = plan(TWO);
        let looked_at = plan.some_runs(8);
        let places: Vec<_> = looked_at
            .iter()
            .map(|key| (key.mission, key.variant, key.point))
            .collect();
        let expected: Vec<_> = [(0, 0), (0, 1), (1, 0), (1, 1)]
            .into_iter()
            .flat_map(|(mission, variant)| [(mission, variant, 0), (mission, variant, 1)])
            .collect();
        assert_eq!(places, expected);
        assert_eq!(plan.some_runs(2).len(), 2);
        assert_eq!(plan.some_runs(1000).len(), 2 * 2 * 3);
    }

    #[test]
    fn a_million_runs_cost_as_much_as_one() {
        let plan = plan("missions = [\"a\"]\nseeds = \"1..1000000\"\n");
        assert_eq!(plan.key(999_999).unwrap().seed, 1_000_000);
        let file: CampaignFile = toml::from_str("missions = [\"a\", \"b\"]\nseeds = \"1..900000000\"\n").unwrap();
        let error = Plan::new(&file, Path::new("c.toml"), Path::new(""), &[]).unwrap_err();
        assert_eq!(error.to_string(), "c.toml: too many runs: expected at most 1000000000");
    }
}
