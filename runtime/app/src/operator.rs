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
        })
    }

    /// Also stops when this is sent.
    #[cfg(feature = "simulation")]
    pub(crate) fn or_end(mut self, end: Receiver<()>) -> Self {
        self.end = Some(end);
        self
    }

    pub(crate) async fn next(&mut self) -> Operator {
        tokio::select! {
            // If both wait because the process stood still, their order is unknown. The hold is taken last, so that it
            // wins.
            biased;
            _ = self.release.recv() => Operator::Release,
            _ = self.hold.recv() => Operator::Hold,
            _ = self.interrupt.recv() => Operator::Stop,
            _ = self.terminate.recv() => Operator::Stop,
            _ = self.hang_up.recv() => Operator::Stop,
            () = sent(&mut self.end) => Operator::Stop,
        }
    }
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
