use std::sync::Arc;

use backseat_core::plugin::PluginId;
use backseat_mission::Mission;
use backseat_plugin_host::{Meter, Stopwatch, Usage};
use backseat_plugin_loader::Components;
use backseat_recorder::{Header, LogReader, Rate, Recorder, Sources};
use backseat_scenario::Scenario;
use backseat_sim::{Report, SimError, Simulation};

use crate::error::{ToolError, of_file};
use crate::tally::Tally;

/// A mission that is flown again and again, each time with another seed.
pub struct Flights<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// Its world.
    pub scenario: &'a Scenario,
    /// Its plugins, compiled.
    pub components: &'a Components,
}

/// A flight, and what one plugin used in it.
pub struct Trial {
    /// What became of the mission.
    pub report: Report,
    /// What the plugin used.
    pub usage: Usage,
}

impl Flights<'_> {
    /// Flies the mission with a seed.
    ///
    /// # Errors
    ///
    /// [`ToolError::Load`] if a plugin cannot be started, [`ToolError::Flight`] if the seed's world cannot be made.
    pub fn fly(&self, seed: u64) -> Result<Report, ToolError> {
        let flight = |source: SimError| ToolError::Flight { seed, source };
        let loaded = self.components.start(self.mission)?;
        let simulation = Simulation::new(self.mission, self.scenario, seed, loaded, None).map_err(flight)?;
        fly_to_the_end(simulation).map_err(flight)
    }

    /// The same, measuring one plugin and counting what it did. The log of the flight is a temporary file.
    pub(crate) fn measure(
        &self,
        seed: u64,
        stopwatch: Stopwatch,
        tally: &mut Tally,
        plugin: PluginId,
    ) -> Result<Trial, ToolError> {
        let flight = |source: SimError| ToolError::Flight { seed, source };
        let logged = |source| ToolError::Log { seed, source };
        let mut loaded = self.components.start(self.mission)?;
        let meter = Arc::new(Meter::new(stopwatch));
        if let Some(measured) = loaded.plugins.get_mut(plugin.0) {
            measured.set_meter(Some(meter.clone()));
        }
        let folder = tempfile::tempdir().map_err(of_file(std::env::temp_dir()))?;
        let path = folder.path().join("trial.mcap");
        let header = Header {
            utc_at_start: self.scenario.world.start.utc,
            rate: Rate::Simulation,
            mission: &self.mission.name,
            seed: Some(seed),
            resolved_mission: &self.mission.resolved,
            fence: &self.mission.fence_text,
            origin: self.mission.envelope.fence().frame().origin(),
            world: None,
            components: &[],
            version: env!("CARGO_PKG_VERSION"),
            sources: Sources {
                plan: None,
                fence: None,
                plugins: &loaded.setups,
            },
        };
        let recorder = Recorder::create(&path, &header).map_err(logged)?;
        let simulation = Simulation::new(self.mission, self.scenario, seed, loaded, Some(recorder)).map_err(flight)?;
        let report = fly_to_the_end(simulation).map_err(flight)?;
        let mut log = LogReader::open(&path).map_err(logged)?;
        tally.take_log(seed, &mut log).map_err(logged)?;
        Ok(Trial {
            report,
            usage: meter.usage(),
        })
    }
}

fn fly_to_the_end(mut simulation: Simulation) -> Result<Report, SimError> {
    simulation.run(|_| {})?;
    let (report, _, _) = simulation.finish()?;
    Ok(report)
}
