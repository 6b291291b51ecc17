//! The operator's signals: SIGUSR1 holds, SIGUSR2 releases, SIGINT and SIGTERM stop.

use std::io;

use backseat_core::Operator;
use tokio::signal::unix::{Signal, SignalKind, signal};

pub(crate) struct Signals {
    hold: Signal,
    release: Signal,
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self {
            hold: signal(SignalKind::user_defined1())?,
            release: signal(SignalKind::user_defined2())?,
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
        })
    }

    pub(crate) async fn next(&mut self) -> Operator {
        tokio::select! {
            _ = self.hold.recv() => Operator::Hold,
            _ = self.release.recv() => Operator::Release,
            _ = self.interrupt.recv() => Operator::Stop,
            _ = self.terminate.recv() => Operator::Stop,
        }
    }
}
