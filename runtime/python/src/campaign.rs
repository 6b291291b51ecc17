//! Flies a campaign as `backseat campaign` does, with the same results folder.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use backseat_campaign::{Crew, Given, Order, Shard, Stop, finish, fly};
use backseat_campaign_report::write;
use backseat_plugin_host::{Cache, Host};
use serde_json::{Value, json};

use crate::error::Error;

/// What to fly, and where its results go.
#[derive(Clone, Debug)]
pub struct Campaign<'a> {
    /// A campaign's file, or a mission's folder.
    pub campaign: &'a Path,
    /// The results folder. If it has a part of this campaign, the campaign goes on.
    pub out: &'a Path,
    /// The seeds, such as `1..1000`, instead of those of the file.
    pub seeds: Option<&'a str>,
    /// Keys of `mission.toml`, and of `world.toml` behind `world.`, that are set in every run.
    pub set: Vec<String>,
    /// The folder in which plugins are looked for first.
    pub plugins: Option<&'a Path>,
    /// The number of threads; one for each core if `None`.
    pub workers: Option<usize>,
}

/// Flies what is not flown yet, and writes the results; returns how many runs there are, passed, were not flown, and broke
/// rules. `is_interrupted` is asked several times a second.
///
/// # Errors
///
/// [`Error::Campaign`], [`Error::Report`], [`Error::Host`], and [`Error::Interrupted`]; what was flown stays then.
pub fn campaign(campaign: &Campaign<'_>, mut is_interrupted: impl FnMut() -> bool) -> Result<Value, Error> {
    let seeds = campaign
        .seeds
        .map(|seeds| seeds.parse().map_err(backseat_campaign::CampaignError::Option))
        .transpose()?;
    let given = Given::read(campaign.campaign, seeds, &campaign.set)?;
    // What is wrong with the cache is no error, and compiling takes its place.
    let host = Host::new()?.with_cache(Cache::of_user(|_| {}));
    let crew = Crew::new(host, campaign.plugins.map(Path::to_path_buf));
    let folder = given.open(&crew, campaign.out, env!("CARGO_PKG_VERSION"))?;
    let cores = || thread::available_parallelism().map_or(1, usize::from);
    let order = Order {
        plan: &given.plan,
        crew: &crew,
        folder: &folder,
        shard: Shard::WHOLE,
        workers: campaign.workers.unwrap_or_else(cores),
        stop_after: None,
        host: "python",
    };
    let (stop, interrupted) = (Stop::default(), AtomicBool::new(false));
    let ended = fly(&order, &stop, |_| {
        if is_interrupted() {
            interrupted.store(true, Ordering::Relaxed);
            stop.set();
        }
    })?;
    if ended.stopped || interrupted.load(Ordering::Relaxed) {
        return Err(Error::Interrupted);
    }
    let finished = finish(&given.plan, std::slice::from_ref(&folder), &folder)?;
    write(&folder, &given.plan, Some(&crew))?;
    Ok(json!({
        "runs": finished.runs,
        "passed": finished.passed,
        "not_flown": finished.not_flown,
        "violations": finished.violations,
    }))
}
