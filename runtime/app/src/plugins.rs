//! Plugins when deployed: a thread each, so that none holds up core or another.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use backseat_core::Restarted;
use backseat_core::plugin::{FaultKind, PluginFault, PluginId, Returned, StepInput};
use backseat_plugin_host::{Host, Plugin};
use tokio::sync::mpsc::UnboundedSender;

/// A step may take this long by the wall clock before it is cut off, beside its fuel.
const DEADLINE_TICKS: u64 = 100;
const TICK: Duration = Duration::from_millis(10);

/// What comes back from a plugin's thread.
pub(crate) enum Answer {
    Returned(PluginId, Returned),
    Restarted(PluginId, Restarted),
}

enum Order {
    Step(Box<StepInput>),
    Restart,
}

/// What a thread serves: a plugin, or what a test puts in its place.
pub(crate) trait Steps: Send + 'static {
    fn step(&mut self, input: &StepInput) -> Returned;
    fn restart(&mut self) -> Restarted;
}

impl Steps for Plugin {
    fn step(&mut self, input: &StepInput) -> Returned {
        Self::step(self, input)
    }

    fn restart(&mut self) -> Restarted {
        let restarted = Self::restart(self);
        Restarted {
            fuel: restarted.fuel,
            lost_steps: restarted.lost_steps,
            result: restarted.result,
        }
    }
}

/// The threads.
pub(crate) struct Crew {
    orders: Vec<mpsc::Sender<Order>>,
    answers: UnboundedSender<Answer>,
}

impl Crew {
    pub(crate) fn new(host: Host, plugins: Vec<Plugin>, answers: UnboundedSender<Answer>) -> Self {
        let bounded = plugins.into_iter().map(|mut plugin| {
            plugin.set_deadline_ticks(Some(DEADLINE_TICKS));
            Box::new(plugin) as Box<dyn Steps>
        });
        let crew = Self::of(bounded.collect(), answers);
        thread::spawn(move || {
            loop {
                crate::clock::pause(TICK);
                host.increment_epoch();
            }
        });
        crew
    }

    /// A thread for each of these.
    pub(crate) fn of(plugins: Vec<Box<dyn Steps>>, answers: UnboundedSender<Answer>) -> Self {
        let orders = plugins
            .into_iter()
            .enumerate()
            .map(|(index, plugin)| {
                let (sender, receiver) = mpsc::channel();
                let answers = answers.clone();
                thread::spawn(move || serve(PluginId(index), plugin, &receiver, &answers));
                sender
            })
            .collect();
        Self { orders, answers }
    }

    pub(crate) fn step(&self, plugin: PluginId, input: StepInput) {
        let order = Order::Step(Box::new(input));
        if let Err(unsent) = self.orders[plugin.0].send(order) {
            let _closed = self.answers.send(unsent.0.lost(plugin));
        }
    }

    pub(crate) fn restart(&self, plugin: PluginId) {
        if let Err(unsent) = self.orders[plugin.0].send(Order::Restart) {
            let _closed = self.answers.send(unsent.0.lost(plugin));
        }
    }
}

impl Order {
    /// The answer of a plugin whose thread is gone, or has panicked.
    fn lost(&self, plugin: PluginId) -> Answer {
        let fault = PluginFault {
            kind: FaultKind::Start,
            text: "its thread has panicked".to_owned(),
        };
        match self {
            Self::Step(_) => Answer::Returned(
                plugin,
                Returned {
                    fuel: 0,
                    log: Vec::new(),
                    result: Err(fault),
                },
            ),
            Self::Restart => Answer::Restarted(
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

/// Answers each order, also where the host itself panics (safety requirement 022): core would wait for that step for ever,
/// and the plugin's failure would never be acted on.
fn serve(id: PluginId, plugin: Box<dyn Steps>, orders: &mpsc::Receiver<Order>, answers: &UnboundedSender<Answer>) {
    let mut plugin = Some(plugin);
    while let Ok(order) = orders.recv() {
        let answered = plugin.as_mut().and_then(|plugin| {
            let act = AssertUnwindSafe(|| match &order {
                Order::Step(input) => Answer::Returned(id, plugin.step(input)),
                Order::Restart => Answer::Restarted(id, plugin.restart()),
            });
            catch_unwind(act).ok()
        });
        if answered.is_none() {
            // Nobody knows what a panic has left of it: it is not used again, and not even taken apart.
            std::mem::forget(plugin.take());
        }
        if answers.send(answered.unwrap_or_else(|| order.lost(id))).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::{Timestamp, Utc};
    use tokio::sync::mpsc::unbounded_channel;

    use super::*;

    /// The host panics in this plugin's first step.
    struct Panics;

    impl Steps for Panics {
        fn step(&mut self, _: &StepInput) -> Returned {
            panic!("as it is meant to")
        }

        fn restart(&mut self) -> Restarted {
            unreachable!("what has panicked is not used again")
        }
    }

    /// A plugin that wants nothing.
    struct Idle;

    impl Steps for Idle {
        fn step(&mut self, _: &StepInput) -> Returned {
            Returned {
                fuel: 1,
                log: Vec::new(),
                result: Ok(Vec::new()),
            }
        }

        fn restart(&mut self) -> Restarted {
            unreachable!("it does not fail")
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
        let crew = Crew::of(vec![Box::new(Panics), Box::new(Idle)], sender);
        let (bad, good) = (PluginId(0), PluginId(1));
        crew.step(bad, nothing());
        let Some(Answer::Returned(PluginId(0), returned)) = answers.blocking_recv() else {
            panic!("core waits for its step");
        };
        assert_eq!(returned.result.map_err(|fault| fault.kind), Err(FaultKind::Start));
        for _ in 0..2 {
            crew.restart(bad);
            let Some(Answer::Restarted(PluginId(0), restarted)) = answers.blocking_recv() else {
                panic!("core waits for its restart");
            };
            assert!(restarted.result.is_err());
        }
        crew.step(good, nothing());
        assert!(
            matches!(answers.blocking_recv(), Some(Answer::Returned(PluginId(1), returned)) if returned.result.is_ok())
        );
    }
}
