use std::collections::BTreeMap;

use crate::exports::parse;
use crate::host::{Recorder, with};
use crate::log::Level;
use crate::{Briefing, Event, Navigation, Plugin, Refusal, Request, Restored, StepInput, TEXT_BYTES};

/// The most requests of a step.
const REQUESTS_MAX: usize = 256;

/// A plugin that runs as in the runtime: its configuration goes through JSON, its timers expire, and a restart goes
/// through a snapshot.
pub struct Harness<P: Plugin> {
    /// The instance.
    pub plugin: P,
    /// The time of the next step.
    pub now_ns: u64,
    /// Whether the backseat has control; true at first.
    pub control: bool,
    /// Where the vehicle is.
    pub navigation: Option<Navigation>,
    briefing: Briefing,
    timers: BTreeMap<u64, u64>,
    waiting: Vec<Event>,
    recorder: Option<Recorder>,
}

impl<P: Plugin> Harness<P> {
    /// Starts a plugin with its configuration as JSON, and the default [`Briefing`]. The fence allows everything.
    ///
    /// # Errors
    /// The line with which the plugin refuses to start.
    pub fn new(config: &str) -> Result<Self, String> {
        let briefing = Briefing {
            grants: P::describe().grants,
            ..Briefing::default()
        };
        Self::with_briefing(config, briefing)
    }

    /// Starts a plugin with another briefing.
    ///
    /// # Errors
    /// The line with which the plugin refuses to start, or the grants that it lacks.
    pub fn with_briefing(config: &str, mut briefing: Briefing) -> Result<Self, String> {
        config.clone_into(&mut briefing.config);
        let lacks = |grant: &&crate::Grant| !briefing.grants.contains(grant);
        if let Some(grant) = P::describe().grants.iter().find(lacks) {
            let name = format!("{grant:?}").replace("Grant::", "").to_lowercase();
            return Err(format!("needs the grant {name}"));
        }
        let recorder = Recorder {
            lines: Vec::new(),
            measures: BTreeMap::new(),
            fence: Box::new(|_| None),
        };
        let (recorder, plugin) = with(recorder, || started::<P>(&briefing));
        Ok(Self {
            plugin: plugin?,
            now_ns: 10_000_000_000,
            control: true,
            navigation: None,
            briefing,
            timers: BTreeMap::new(),
            waiting: Vec::new(),
            recorder: Some(recorder),
        })
    }

    /// Answers the plugin's questions to the fence from now on: a refusal, or `None` if there is room.
    pub fn set_fence(&mut self, fence: impl FnMut(&Request) -> Option<Refusal> + 'static) {
        if let Some(recorder) = &mut self.recorder {
            recorder.fence = Box::new(fence);
        }
    }

    /// Runs one step with these events, and the timers that have expired. Then the plugin's period goes by.
    ///
    /// # Errors
    /// The plugin's error, or what the runtime would call a failure: too many requests, too long a text.
    pub fn step(&mut self, events: Vec<Event>) -> Result<Vec<Request>, String> {
        let now_ns = self.now_ns;
        let mut happened = std::mem::take(&mut self.waiting);
        let due: Vec<u64> = self
            .timers
            .iter()
            .filter(|(_, at_ns)| **at_ns <= now_ns)
            .map(|(id, _)| *id)
            .collect();
        for id in due {
            self.timers.remove(&id);
            happened.push(Event::Timer(id));
        }
        happened.extend(events);
        let input = StepInput {
            now_ns,
            utc_ns: 1_780_000_000_000_000_000 + now_ns,
            navigation: self.navigation,
            control: self.control,
            events: happened,
            ..StepInput::default()
        };
        self.now_ns += P::describe().step_period_ns;
        let requests = self.hosted(|plugin| plugin.step(&input))?;
        if requests.len() > REQUESTS_MAX {
            return Err(format!(
                "{} requests in one step, more than {REQUESTS_MAX}",
                requests.len()
            ));
        }
        for request in &requests {
            if let Request::Timer(timer) = request {
                self.timers.insert(timer.id, now_ns + timer.after_ns);
            }
            if let Request::Message(text) = request
                && text.len() > TEXT_BYTES
            {
                return Err(format!("a message of {} bytes, more than {TEXT_BYTES}", text.len()));
            }
        }
        Ok(requests)
    }

    /// Replaces the instance by a new one from its snapshot. The next step has the event [`Event::Restored`] with these
    /// open tags.
    ///
    /// # Errors
    /// The plugin's error: the runtime would not restart it.
    pub fn restart(&mut self, lost_steps: u64, open: Vec<u64>) -> Result<(), String> {
        let snapshot = self.hosted(|plugin| plugin.snapshot());
        self.restart_from(&snapshot, lost_steps, open)
    }

    /// As [`Harness::restart`], from an earlier snapshot.
    ///
    /// # Errors
    /// The plugin's error.
    pub fn restart_from(&mut self, snapshot: &[u8], lost_steps: u64, open: Vec<u64>) -> Result<(), String> {
        let briefing = self.briefing.clone();
        self.plugin = self.hosted(|_| {
            let mut plugin = started::<P>(&briefing)?;
            plugin.restore(snapshot)?;
            Ok::<P, String>(plugin)
        })?;
        self.waiting = vec![Event::Restored(Restored { lost_steps, open })];
        Ok(())
    }

    /// The plugin's state now, as the runtime would keep it.
    #[must_use]
    pub fn snapshot(&mut self) -> Vec<u8> {
        self.hosted(|plugin| plugin.snapshot())
    }

    /// The briefing with which the plugin was started.
    #[must_use]
    pub const fn briefing(&self) -> &Briefing {
        &self.briefing
    }

    /// The lines that it has logged, oldest first.
    #[must_use]
    pub fn lines(&self) -> &[(Level, String)] {
        self.recorder.as_ref().map_or(&[], |recorder| &recorder.lines)
    }

    /// The values that it has published under a name, oldest first.
    #[must_use]
    pub fn measures(&self, name: &str) -> &[f64] {
        let recorder = self.recorder.as_ref();
        recorder
            .and_then(|recorder| recorder.measures.get(name))
            .map_or(&[], Vec::as_slice)
    }

    fn hosted<R>(&mut self, call: impl FnOnce(&mut P) -> R) -> R {
        match self.recorder.take() {
            Some(recorder) => {
                let (recorder, result) = with(recorder, || call(&mut self.plugin));
                self.recorder = Some(recorder);
                result
            }
            None => call(&mut self.plugin),
        }
    }
}

fn started<P: Plugin>(briefing: &Briefing) -> Result<P, String> {
    let mut plugin = P::new(parse(&briefing.config)?)?;
    plugin.brief(briefing)?;
    Ok(plugin)
}
