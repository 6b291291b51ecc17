//! Plugins when deployed: a thread each, so that none holds up core or another.

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

/// The threads.
pub(crate) struct Crew {
    orders: Vec<mpsc::Sender<Order>>,
    answers: UnboundedSender<Answer>,
}

impl Crew {
    pub(crate) fn new(host: Host, plugins: Vec<Plugin>, answers: UnboundedSender<Answer>) -> Self {
        let orders = plugins
            .into_iter()
            .enumerate()
            .map(|(index, mut plugin)| {
                plugin.set_deadline_ticks(Some(DEADLINE_TICKS));
                let (sender, receiver) = mpsc::channel();
                let answers = answers.clone();
                thread::spawn(move || serve(PluginId(index), plugin, &receiver, &answers));
                sender
            })
            .collect();
        thread::spawn(move || {
            loop {
                crate::clock::pause(TICK);
                host.increment_epoch();
            }
        });
        Self { orders, answers }
    }

    pub(crate) fn step(&self, plugin: PluginId, input: StepInput) {
        if self.orders[plugin.0].send(Order::Step(Box::new(input))).is_err() {
            let result = Err(lost());
            let _closed = self.answers.send(Answer::Returned(
                plugin,
                Returned {
                    fuel: 0,
                    log: Vec::new(),
                    result,
                },
            ));
        }
    }

    pub(crate) fn restart(&self, plugin: PluginId) {
        if self.orders[plugin.0].send(Order::Restart).is_err() {
            let restarted = Restarted {
                fuel: 0,
                lost_steps: 0,
                result: Err(lost()),
            };
            let _closed = self.answers.send(Answer::Restarted(plugin, restarted));
        }
    }
}

fn lost() -> PluginFault {
    PluginFault {
        kind: FaultKind::Start,
        text: "its thread is gone".to_owned(),
    }
}

fn serve(id: PluginId, mut plugin: Plugin, orders: &mpsc::Receiver<Order>, answers: &UnboundedSender<Answer>) {
    while let Ok(order) = orders.recv() {
        let answer = match order {
            Order::Step(input) => Answer::Returned(id, plugin.step(&input)),
            Order::Restart => {
                let restarted = plugin.restart();
                let restarted = Restarted {
                    fuel: restarted.fuel,
                    lost_steps: restarted.lost_steps,
                    result: restarted.result,
                };
                Answer::Restarted(id, restarted)
            }
        };
        if answers.send(answer).is_err() {
            return;
        }
    }
}
