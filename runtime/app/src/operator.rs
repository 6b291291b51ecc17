//! The operator's signals: SIGUSR1 holds, SIGUSR2 releases; SIGINT, SIGTERM and SIGHUP (the terminal has closed) stop.

use std::io;

use backseat_core::Operator;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::oneshot::Receiver;

pub(crate) struct Signals {
    hold: Signal,
    release: Signal,
    interrupt: Signal,
    terminate: Signal,
    hang_up: Signal,
    /// Ends the run as a signal would.
    end: Option<Receiver<()>>,
    /// What people at the console ask for.
    #[cfg(feature = "console")]
    console: Option<tokio::sync::mpsc::Receiver<backseat_console::Asked>>,
}

/// What the operator asks for, by a signal or at the console.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) act: Operator,
    /// The name that a person at the console gave.
    pub(crate) who: Option<String>,
}

impl Asked {
    pub(crate) const fn word(&self) -> &'static str {
        match self.act {
            Operator::Hold => "hold",
            Operator::Release => "release",
            Operator::Stop => "stop",
            Operator::Order(_) => "order",
        }
    }
}

impl Signals {
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self {
            hold: signal(SignalKind::user_defined1())?,
            release: signal(SignalKind::user_defined2())?,
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: signal(SignalKind::hangup())?,
            end: None,
            #[cfg(feature = "console")]
            console: None,
        })
    }

    /// Also stops when this is sent.
    #[cfg(feature = "simulation")]
    pub(crate) fn or_end(mut self, end: Receiver<()>) -> Self {
        self.end = Some(end);
        self
    }

    /// Also does what people at the console ask for.
    #[cfg(feature = "console")]
    pub(crate) fn or_console(mut self, asked: Option<tokio::sync::mpsc::Receiver<backseat_console::Asked>>) -> Self {
        self.console = asked;
        self
    }

    pub(crate) async fn next(&mut self) -> Asked {
        #[cfg(feature = "console")]
        let console = at_console(&mut self.console);
        #[cfg(not(feature = "console"))]
        let console = std::future::pending::<Asked>();
        let act = tokio::select! {
            // If both wait because the process stood still, their order is unknown. The hold is taken last, so that it
            // wins.
            biased;
            _ = self.release.recv() => Operator::Release,
            _ = self.hold.recv() => Operator::Hold,
            _ = self.interrupt.recv() => Operator::Stop,
            _ = self.terminate.recv() => Operator::Stop,
            _ = self.hang_up.recv() => Operator::Stop,
            () = sent(&mut self.end) => Operator::Stop,
            asked = console => return asked,
        };
        Asked { act, who: None }
    }
}

/// What somebody at the console asks for; waits for ever where there is none.
#[cfg(feature = "console")]
async fn at_console(console: &mut Option<tokio::sync::mpsc::Receiver<backseat_console::Asked>>) -> Asked {
    if let Some(asked) = console {
        if let Some(backseat_console::Asked { act, who }) = asked.recv().await {
            let act = match act {
                backseat_console::Act::Hold => Operator::Hold,
                backseat_console::Act::Release => Operator::Release,
            };
            return Asked { act, who: Some(who) };
        }
        // The console's thread has ended.
        *console = None;
    }
    std::future::pending().await
}

/// Waits for an end that is announced; for ever where none will be.
async fn sent(end: &mut Option<Receiver<()>>) {
    if let Some(announced) = end {
        let announced = announced.await;
        *end = None;
        if announced.is_ok() {
            return;
        }
    }
    std::future::pending().await
}
