//! Plugins when deployed: each runs on a thread of its own, so that none delays core or another plugin.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::time::Duration;

use backseat_core::Restarted;
use backseat_core::plugin::{FaultKind, PluginFault, PluginId, Returned, StepInput, Version};
use backseat_plugin_host::{Host, PANICKED, Plugin, Seat};
use tokio::sync::mpsc::UnboundedSender;

use crate::aside;
use crate::clock::{Clock, Working};

/// Besides its fuel, a step may take this long by the wall clock before it is interrupted.
pub(crate) const DEADLINE_TICKS: u64 = 100;
const TICK: Duration = Duration::from_millis(10);
/// The same as a time.
#[cfg(feature = "plugin")]
pub(crate) const DEADLINE: Duration = Duration::from_millis(10 * DEADLINE_TICKS);

/// The answer of a plugin's thread.
pub(crate) enum Answer {
    Returned(PluginId, Returned),
    Restarted(PluginId, Restarted),
    /// A version that took the plugin's place has passed its trial.
    Passed(PluginId, Version),
}

enum Order {
    Step(Box<StepInput>),
    Restart,
    /// A version takes the plugin's place at the next restart. This has no answer.
    Offer(Box<Plugin>, Version),
}

/// What a thread runs: a plugin, or a test's substitute.
pub(crate) trait Steps: Send + 'static {
    fn step(&mut self, input: &StepInput) -> Returned;
    fn restart(&mut self) -> Restarted;
    fn offer(&mut self, plugin: Plugin, version: Version);
    fn take_passed(&mut self) -> Option<Version>;
}

impl Steps for Seat {
    fn step(&mut self, input: &StepInput) -> Returned {
        Self::step(self, input)
    }

    fn restart(&mut self) -> Restarted {
        Self::restart(self)
    }

    fn offer(&mut self, mut plugin: Plugin, version: Version) {
        plugin.set_deadline_ticks(Some(DEADLINE_TICKS));
        Self::offer(self, plugin, version);
    }

    fn take_passed(&mut self) -> Option<Version> {
        Self::take_passed(self)
    }
}

/// The threads of all plugins.
pub(crate) struct Crew {
    orders: Vec<mpsc::Sender<Order>>,
    answers: UnboundedSender<Answer>,
    clock: Clock,
    /// Whose answer the loop waits for.
    working: Vec<Option<Working>>,
}

impl Crew {
    /// Starts a thread for each plugin, and one that counts the time of their steps.
    ///
    /// # Errors
    /// If one cannot start.
    pub(crate) fn new(
        host: Host,
        plugins: Vec<Plugin>,
        clock: Clock,
        answers: UnboundedSender<Answer>,
    ) -> io::Result<Self> {
        let bounded = plugins.into_iter().map(|mut plugin| {
            plugin.set_deadline_ticks(Some(DEADLINE_TICKS));
            Box::new(Seat::new(plugin)) as Box<dyn Steps>
        });
        let crew = Self::of(bounded.collect(), clock, answers)?;
        aside::spawn("epoch", move || {
            loop {
                crate::clock::pause(TICK);
                host.increment_epoch();
            }
        })?;
        Ok(crew)
    }

    /// Starts a thread for each plugin.
    ///
    /// # Errors
    /// If one cannot start.
    pub(crate) fn of(plugins: Vec<Box<dyn Steps>>, clock: Clock, answers: UnboundedSender<Answer>) -> io::Result<Self> {
        let orders: Vec<_> = plugins
            .into_iter()
            .enumerate()
            .map(|(index, plugin)| {
                let (sender, receiver) = mpsc::channel();
                let answers = answers.clone();
                let serve = move || serve(PluginId(index), plugin, &receiver, &answers);
                aside::spawn(format!("plugin {index}"), serve)?;
                Ok(sender)
            })
            .collect::<io::Result<_>>()?;
        Ok(Self {
            working: orders.iter().map(|_| None).collect(),
            orders,
            answers,
            clock,
        })
    }

    pub(crate) fn step(&mut self, plugin: PluginId, input: StepInput) {
        self.working[plugin.0] = Some(self.clock.working());
        let order = Order::Step(Box::new(input));
        if let Err(unsent) = self.orders[plugin.0].send(order) {
            let _closed = self.answers.send(unsent.0.lost(plugin));
        }
    }

    pub(crate) fn restart(&mut self, plugin: PluginId) {
        self.working[plugin.0] = Some(self.clock.working());
        if let Err(unsent) = self.orders[plugin.0].send(Order::Restart) {
            let _closed = self.answers.send(unsent.0.lost(plugin));
        }
    }

    /// Has this version take a plugin's place at its next restart.
    pub(crate) fn offer(&mut self, plugin: PluginId, ready: Plugin, version: Version) {
        // A thread that has ended answers the restart with a fault.
        let _gone = self.orders[plugin.0].send(Order::Offer(Box::new(ready), version));
    }

    /// The loop has the plugin's answer.
    pub(crate) fn answered(&mut self, answer: &Answer) {
        match answer {
            Answer::Returned(plugin, _) | Answer::Restarted(plugin, _) => self.working[plugin.0] = None,
            Answer::Passed(..) => {}
        }
    }
}

impl Order {
    /// The answer for a plugin whose thread has ended or panicked.
    fn lost(&self, plugin: PluginId) -> Answer {
        let fault = PluginFault {
            kind: FaultKind::Start,
            text: PANICKED.to_owned(),
        };
        match self {
            Self::Step(_) => Answer::Returned(
                plugin,
                Returned {
                    fuel: 0,
                    measures: Vec::new(),
                    log: Vec::new(),
                    result: Err(fault),
                },
            ),
            Self::Restart | Self::Offer(..) => Answer::Restarted(
                plugin,
                Restarted {
                    fuel: 0,
                    lost_steps: 0,
                    result: Err(fault),
                },
            ),
        }
    }
}

/// Answers each order, even if the host panics (safety requirement 022). Without an answer core would wait for that
/// step for ever and never act on the plugin's failure.
fn serve(id: PluginId, plugin: Box<dyn Steps>, orders: &mpsc::Receiver<Order>, answers: &UnboundedSender<Answer>) {
    let mut plugin = Some(plugin);
    while let Ok(order) = orders.recv() {
        let order = match (order, &mut plugin) {
            (Order::Offer(ready, version), Some(plugin)) => {
                plugin.offer(*ready, version);
                continue;
            }
            (Order::Offer(..), None) => continue,
            (order, _) => order,
        };
        let answered = plugin.as_mut().and_then(|plugin| {
            let act = AssertUnwindSafe(|| match &order {
                Order::Step(input) => Answer::Returned(id, plugin.step(input)),
                Order::Restart | Order::Offer(..) => Answer::Restarted(id, plugin.restart()),
            });
            catch_unwind(act).ok()
        });
        if answered.is_none() {
            // The panic may have left the plugin in any state, so it is not used again, and not even dropped.
            std::mem::forget(plugin.take());
        }
        if answers.send(answered.unwrap_or_else(|| order.lost(id))).is_err() {
            return;
        }
        if let Some(version) = plugin.as_mut().and_then(|plugin| plugin.take_passed()) {
            // The loop may have ended.
            let _gone = answers.send(Answer::Passed(id, version));
        }
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::{Timestamp, Utc};
    use tokio::sync::mpsc::unbounded_channel;

    use super::*;

    /// A plugin whose host panics in the first step.
    struct Panics;

    impl Steps for Panics {
        fn step(&mut self, _: &StepInput) -> Returned {
            panic!("the test panics in a step")
        }

        fn restart(&mut self) -> Restarted {
            unreachable!("a plugin that has panicked is not used again")
        }

        fn offer(&mut self, _: Plugin, _: Version) {
            unreachable!("nobody swaps it")
        }

        fn take_passed(&mut self) -> Option<Version> {
            None
        }
    }

    /// A plugin that requests nothing.
    struct Idle;

    impl Steps for Idle {
        fn step(&mut self, _: &StepInput) -> Returned {
            Returned {
                fuel: 1,
                measures: Vec::new(),
                log: Vec::new(),
                result: Ok(Vec::new()),
            }
        }

        fn restart(&mut self) -> Restarted {
            unreachable!("this plugin does not fail")
        }

        fn offer(&mut self, _: Plugin, _: Version) {
            unreachable!("nobody swaps it")
        }

        fn take_passed(&mut self) -> Option<Version> {
            None
        }
    }

    fn nothing() -> StepInput {
        StepInput {
            now: Timestamp::ZERO,
            utc: Utc::from_unix_nanos(0),
            clocks_apart: None,
            navigation: None,
            relative: None,
            cartesian: None,
            control: false,
            events: Vec::new(),
        }
    }

    #[test]
    fn sr_022_a_host_that_panics_in_a_step_answers_as_a_plugin_that_failed() {
        let (sender, mut answers) = unbounded_channel();
        let mut crew = Crew::of(vec![Box::new(Panics), Box::new(Idle)], Clock::start(), sender).unwrap();
        let (bad, good) = (PluginId(0), PluginId(1));
        crew.step(bad, nothing());
        let Some(Answer::Returned(PluginId(0), returned)) = answers.blocking_recv() else {
            panic!("expected an answer to the step");
        };
        assert_eq!(returned.result.map_err(|fault| fault.kind), Err(FaultKind::Start));
        for _ in 0..2 {
            crew.restart(bad);
            let Some(Answer::Restarted(PluginId(0), restarted)) = answers.blocking_recv() else {
                panic!("expected an answer to the restart");
            };
            assert!(restarted.result.is_err());
        }
        crew.step(good, nothing());
        assert!(
            matches!(answers.blocking_recv(), Some(Answer::Returned(PluginId(1), returned)) if returned.result.is_ok())
        );
    }
}
