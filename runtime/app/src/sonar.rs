//! The client of the sonars at sea: a thread of its own with its connection, and bounded queues to core's loop.
//! Whatever the payload controller does, core's loop does not wait for it (safety requirement 022).

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;

use anyhow::{Context, Result};
use backseat_core::plugin::SonarEvent;
use backseat_core::{FromSonar, SonarOutcome, StatusCondition, ToSonar};
use backseat_mission::Mission;
use backseat_sonar::Input;
use backseat_sonar_bridge::{Act, Bridge, SonarSettings};
use tokio::net::TcpStream;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};

use crate::aside;
use crate::clock::Clock;
use crate::link::{Link, Ready, connect};

/// How many wishes of core may wait for the thread. At 10 Hz of navigation this is over 20 s.
const WISHES_MAX: usize = 256;
/// How many reports may wait for core's loop.
const REPORTS_MAX: usize = 64;
/// How many further reports the thread keeps for itself. Beyond it, pings and lines are dropped; there can be no more of
/// the others than core has asked for and the client limits.
const BACKLOG_MAX: usize = 512;

/// What core's loop tells the thread.
enum Wish {
    Tell(ToSonar),
    UtcSet(i64),
}

/// Core's end of the queues.
pub(crate) struct Sonars {
    wishes: Sender<Wish>,
    reports: Receiver<FromSonar>,
    /// Outcomes of requests that the thread could not take.
    refused: VecDeque<FromSonar>,
}

impl Sonars {
    /// Starts the thread, if the mission has sonars.
    ///
    /// # Errors
    /// If the mission's `[sonar]` has a value that is not allowed, or if no thread can be started.
    pub(crate) fn start(mission: &Mission, clock: Clock) -> Result<Option<Self>> {
        let Some(settings) = SonarSettings::of(mission) else {
            return Ok(None);
        };
        let bridge = settings.bridge(clock.utc_at_start()).context("mission.toml: [sonar]")?;
        let (wishes, wanted) = channel(WISHES_MAX);
        let (sender, reports) = channel(REPORTS_MAX);
        let address = format!("{}:{}", bridge.config().host, bridge.config().port);
        let served = move || {
            let sent = sender.clone();
            let serving = AssertUnwindSafe(|| Server::new(bridge, clock, address).serve(wanted, &sender));
            if !matches!(catch_unwind(serving), Ok(Ok(()))) {
                gone(&sent);
            }
        };
        aside::spawn("sonar", served)?;
        Ok(Some(Self {
            wishes,
            reports,
            refused: VecDeque::new(),
        }))
    }

    /// Tells the thread something. Never waits: if its queue is full, a request fails, and anything else is dropped.
    pub(crate) fn tell(&mut self, wish: ToSonar) {
        let Err(TrySendError::Full(unsent) | TrySendError::Closed(unsent)) = self.wishes.try_send(Wish::Tell(wish))
        else {
            return;
        };
        if let Wish::Tell(ToSonar::Order { request, .. }) = unsent {
            let outcome = SonarOutcome::Failed("the thread of the sonars does not take it".to_owned());
            self.refused.push_back(FromSonar::Outcome { request, outcome });
        }
    }

    /// The system's clock was set, by so much in all since the start.
    pub(crate) fn utc_set(&self, by_nanos: i64) {
        // A thread that is gone needs no clock.
        let _gone = self.wishes.try_send(Wish::UtcSet(by_nanos));
    }

    /// The next report. Waits for ever if there will be none.
    pub(crate) async fn next(sonars: &mut Option<Self>) -> FromSonar {
        if let Some(sonars) = sonars {
            if let Some(refused) = sonars.refused.pop_front() {
                return refused;
            }
            if let Some(report) = sonars.reports.recv().await {
                return report;
            }
        }
        std::future::pending().await
    }
}

/// The last words of a thread that has panicked or cannot go on.
fn gone(reports: &Sender<FromSonar>) {
    let text = "the thread of the sonars has ended: no pings come and no requests are sent until the next start";
    for report in [
        FromSonar::Event(SonarEvent::Ready(false)),
        FromSonar::Status {
            text: "sonar client ended".to_owned(),
            conditions: vec![StatusCondition::SonarNotReady],
        },
        FromSonar::Line(text.to_owned()),
    ] {
        // If core's loop is gone too, nobody needs to know.
        let _closed = reports.blocking_send(report);
    }
}

type Connecting = Pin<Box<dyn Future<Output = std::io::Result<TcpStream>>>>;

/// The thread: the bridge, its connection, and what waits for core.
struct Server {
    bridge: Bridge,
    clock: Clock,
    address: String,
    link: Link,
    connecting: Option<Connecting>,
    /// The connection has ended, and the bridge does not know it yet.
    lost: bool,
    finished: bool,
    backlog: VecDeque<FromSonar>,
}

impl Server {
    fn new(bridge: Bridge, clock: Clock, address: String) -> Self {
        Self {
            bridge,
            clock,
            address,
            link: Link::default(),
            connecting: None,
            lost: false,
            finished: false,
            backlog: VecDeque::new(),
        }
    }

    fn serve(mut self, mut wishes: Receiver<Wish>, reports: &Sender<FromSonar>) -> std::io::Result<()> {
        let clock = self.clock;
        let runtime = clock.runtime()?;
        clock.block_on(&runtime, async {
            let mut buffer = vec![0; 64 * 1024];
            self.carry_out_all();
            while !self.finished {
                let wake = [self.bridge.poll_timeout(), self.link.write_deadline()];
                let wake = wake.into_iter().flatten().min();
                let wake = wake.unwrap_or(backseat_units::Timestamp::MAX);
                tokio::select! {
                    biased;
                    () = clock.sleep_until(wake) => self.handle(Input::Timeout),
                    wish = wishes.recv() => match wish {
                        Some(Wish::Tell(wish)) => self.bridge.tell(self.clock.now(), wish),
                        Some(Wish::UtcSet(by_nanos)) => self.handle(Input::UtcSet(by_nanos)),
                        // Core's loop has ended.
                        None => return,
                    },
                    Ok(permit) = reports.reserve(), if !self.backlog.is_empty() => {
                        if let Some(report) = self.backlog.pop_front() {
                            permit.send(report);
                        }
                    }
                    connected = connected(&mut self.connecting) => {
                        self.connecting = None;
                        match connected {
                            Ok(stream) => {
                                self.link.open(stream);
                                self.handle(Input::Connected);
                            }
                            Err(_) => self.lost = true,
                        }
                    }
                    ready = self.link.ready(&mut buffer) => match ready {
                        Ready::Read(read) => self.handle(Input::Received(&buffer[..read])),
                        Ready::Writable => self.lost |= self.link.flush(self.clock.now()).is_err(),
                        Ready::Closed => self.lost = true,
                    },
                }
                self.lost |= self.link.write_deadline().is_some_and(|at| at <= self.clock.now());
                self.carry_out_all();
            }
            // The controller is shut down. What is still to be reported goes to core as it takes it.
            for report in self.backlog {
                if reports.send(report).await.is_err() {
                    return;
                }
            }
            // Core's wishes are taken and dropped, so that none of them is a failure.
            while wishes.recv().await.is_some() {}
        });
        Ok(())
    }

    fn handle(&mut self, input: Input<'_>) {
        self.bridge.handle(self.clock.now(), input);
    }

    fn carry_out_all(&mut self) {
        loop {
            while let Some(act) = self.bridge.poll() {
                self.carry_out(act);
            }
            if !std::mem::take(&mut self.lost) {
                return;
            }
            self.link.reset();
            self.connecting = None;
            self.handle(Input::Lost);
        }
    }

    fn carry_out(&mut self, act: Act) {
        match act {
            Act::Connect => {
                let address = self.address.clone();
                self.connecting = Some(Box::pin(async move { connect(&address).await }));
            }
            Act::Disconnect => self.lost = true,
            Act::Send(bytes) => {
                let now = self.clock.now();
                self.lost |= self.link.send(now, now, &bytes).is_err();
            }
            Act::Report(report) => {
                let spare = matches!(report, FromSonar::Ping(..) | FromSonar::Line(_));
                if self.backlog.len() < BACKLOG_MAX || !spare {
                    self.backlog.push_back(report);
                }
            }
            Act::Finished => self.finished = true,
        }
    }
}

/// The result of an attempt to connect; waits for ever without one.
async fn connected(connecting: &mut Option<Connecting>) -> std::io::Result<TcpStream> {
    match connecting {
        Some(connecting) => connecting.await,
        None => std::future::pending().await,
    }
}
