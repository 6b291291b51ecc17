use std::fmt;
use std::time::Duration;

use backseat_world::Stream;

/// What the runtime is doing when its fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// It refreshes a modify.
    Modify,
    /// It keeps a hovering vehicle at its station.
    Station,
    /// It inserts tracklines.
    Insert,
}

/// The fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// SIGKILL.
    Kill,
    /// SIGSTOP, without an end.
    Stop,
    /// SIGSTOP, and SIGCONT after this time.
    Pause(Duration),
    /// The connection is closed in order, and there is none for this time.
    Close(Duration),
    /// The connection is reset, and there is none for this time.
    Reset(Duration),
    /// For this time the connections stay open and pass nothing; then they are reset. Written bytes are accepted and
    /// lost, or wait in the sockets' buffers.
    HalfOpen {
        /// The duration.
        lasts: Duration,
        /// Whether bytes stay in the sockets' buffers.
        waits: bool,
    },
    /// SIGTERM.
    Terminate,
}

/// One trial.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Counted from 1.
    pub number: u32,
    /// What the runtime is doing.
    pub subject: Subject,
    /// The fault.
    pub act: Act,
    /// The time from when it begins to steer to the fault.
    pub after: Duration,
}

impl Plan {
    /// Draws a trial; the same seed and number give the same one.
    #[must_use]
    pub fn draw(seed: u64, number: u32, hovering_share: f64, inserting_share: f64) -> Self {
        let mut stream = Stream::new(seed, &format!("kill {number}"));
        let share = stream.uniform();
        let subject = if share < hovering_share {
            Subject::Station
        } else if share < hovering_share + inserting_share {
            Subject::Insert
        } else {
            Subject::Modify
        };
        let after = Duration::from_secs_f64(stream.uniform_in(0.0, 4.0));
        let lasts = Duration::from_secs_f64(stream.uniform_in(0.1, 10.0));
        let waits = stream.uniform() < 0.5;
        let act = match (stream.uniform() * 7.0) as u32 {
            0 => Act::Kill,
            1 => Act::Stop,
            2 => Act::Pause(lasts),
            3 => Act::Close(lasts),
            4 => Act::Reset(lasts),
            5 => Act::HalfOpen { lasts, waits },
            _ => Act::Terminate,
        };
        Self {
            number,
            subject,
            act,
            after,
        }
    }
}

impl Act {
    /// The duration, for faults after which the runtime continues by itself.
    #[must_use]
    pub const fn lasts(&self) -> Option<Duration> {
        match self {
            Self::Pause(lasts) | Self::Close(lasts) | Self::Reset(lasts) | Self::HalfOpen { lasts, .. } => Some(*lasts),
            Self::Kill | Self::Stop | Self::Terminate => None,
        }
    }

    /// Whether the fault is in the connection.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        matches!(self, Self::Close(_) | Self::Reset(_) | Self::HalfOpen { .. })
    }

    /// The name without values.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Kill => "SIGKILL",
            Self::Stop => "SIGSTOP",
            Self::Pause(_) => "SIGSTOP, SIGCONT",
            Self::Close(_) => "link closed",
            Self::Reset(_) => "link reset",
            Self::HalfOpen { .. } => "link half-open",
            Self::Terminate => "SIGTERM",
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Modify => "modify",
            Self::Station => "station",
            Self::Insert => "insert",
        })
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            number,
            subject,
            act,
            after,
        } = self;
        write!(
            f,
            "trial {number}: {subject}, {} {:.3} s in",
            act.kind(),
            after.as_secs_f64()
        )?;
        if let Some(lasts) = act.lasts() {
            write!(f, ", for {:.3} s", lasts.as_secs_f64())?;
        }
        if let Act::HalfOpen { waits, .. } = act {
            write!(f, ", what is written {}", if *waits { "waits" } else { "is lost" })?;
        }
        Ok(())
    }
}
