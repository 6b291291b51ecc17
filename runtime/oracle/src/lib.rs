//! Judges a run by the bytes on the link and the mock vehicle's true state alone.
//!
//! An [`Oracle`] receives every write on the vehicle link with the time at which it left its sender, every change of
//! the link, and the vehicle's true state ten times a second, all in order of time. It knows the fence, the [`Limits`],
//! and what the safety requirements promise. It reports [`Violation`]s, and [`Statistics`] that say how much there was
//! to judge, so that nobody takes an empty run for a clean one.
//!
//! The oracle shares no code with what it judges: it depends on no other crate of this project. It has its own reader
//! of sentences ([`wire`]) and of the fence. Its times are nanoseconds, its positions are degrees, and its lines run
//! straight through the earth, while the runtime's lines are straight in a projection.
//!
//! If the delay of the link leaves open what the runtime knew, the oracle assumes the longest delay, so every violation
//! is one under any interpretation. The oracle sees the vehicle's bytes when they start on their way to us, after the
//! faults of the link. So the runtime is not blamed for what a fault held back, damaged or lost. The oracle sees our
//! bytes when we write them, and also when they reach the vehicle if the run calls [`Oracle::arrived`]. A stopped
//! runtime hears what the vehicle sent meanwhile when it continues. A new process does not know what the previous one
//! knew.
//!
//! # Requirements and rules
//!
//! | requirement | rules |
//! |---|---|
//! | 001 control | `no-control` |
//! | 002 fence | `request-fence`, `request-vertical`, `request-speed`, `request-surfacing`, `request-box`, `bottom-unknown`, `modify-fence`, `plan-unknown`, `begin-unheard`; by the vehicle's own estimate of its position `insert-margin`; by truth `truth-fence`, `truth-depth`, `truth-grounded` |
//! | 003 modifies live and end | `modify-gap`, `modify-abandoned`, `modify-too-fast`, `modify-inherits`, `modify-unanswered`, `lease-outlives`, `lease-after-stop` |
//! | 004 each refresh | `refresh-fence`, `modify-margin` |
//! | 005 station keeping | `station-gap`, `station-dead` |
//! | 006 faulty plugins | none of its own: the leases and the station keeping of the other plugins are judged by the rules of 003 and 005 |
//! | 007 requests that outlive the runtime | by truth `modify-outlives`, `station-outlives`; `stale-delivery`; for inserts the caps of 019 and the fence of 002 |
//! | 008 stale navigation | `stale-navigation` |
//! | 009 one outcome | `identifier-repeated`, `stamp-repeated`, `insert-in-doubt` |
//! | 010 interrupts | `interrupt-of-interrupt` |
//! | 011 shutdown | `after-shutdown` |
//! | 012 aborts and kills | `operator-only` |
//! | 013 bad bytes | none: a panic ends the run, and the link does not show memory |
//! | 014 without control | `end-missing`, `end-surplus`, `not-allowed-without-control`, `cancel-foreign` |
//! | 015 operator's hold | `operator-hold`, `hold-cancel-missing` |
//! | 016 acoustic windows | `packet-window` |
//! | 017 DVL triggering | `trigger-without-leave`, `trigger-not-ceased` |
//! | 018 silent mode | `silence-repeated` |
//! | 019 rates and totals | `inserts-total`, `inserts-open`, `inserts-duration`, `requests-total` |
//! | 020 recovery | `modify-fence` if a lease begins outside; by truth `truth-cancel` |
//! | 021 the monitor's truth | `jump-ignored`, `moves-truth` |
//! | 023 the vehicle hears us | `unheard`, `pause-ignored`, `clock-set` |
//! | 024 navigation that cannot be true | `velocity-missing`; by truth `navigation-untrue` |
//! | 025 another dive | `another-dive` |
//!
//! # What a rule is judged by
//!
//! Each rule is judged by one [`Side`]: our sentences alone; our sentences compared with what the vehicle or the
//! operator did before; the arrival of our sentences; or the truth. [`Oracle::rules`] reports how often each rule was
//! judged, and the reason if it was not judged. The log of a dive has no truth and no arrivals, and can have gaps
//! ([`Oracle::gap`]). Its times are those at which the runtime sent and received.
//!
//! `navigation-untrue` looks at windows of at most 9.5 s, by the times of the solutions. For each window the oracle
//! computes how far the reported position moved away from the truth, and subtracts how far the integrated velocities
//! moved away from it, because no payload can see an error that both share. The rest may be `position_step_m`, plus
//! `position_drift_mps` for each second of the window, plus 0.5 m for the decimals of the sentences. With a mission's
//! default limits that is 13.35 m in a whole window: the rule finds a position that creeps away at 1.5 m/s, and does
//! not find one at 1.3 m/s. A disagreement counts only if all samples of a stretch of half a second disagree with a
//! later sample. Nothing that steers may leave from the time when the runtime has heard that later sample until 9.9 s
//! after the start of the stretch. A new window starts where the runtime cannot compare either: on a new connection,
//! after a gap, after the runtime was stopped, and while the vehicle uses GPS at the surface.
//!
//! `malformed` is a rule of the interface (SPI 4.2) and belongs to no requirement.
//!
//! Bytes and truth cannot show everything. Besides 006 and 013, the oracle does not judge
//! - whether plugins were told and logs were closed in time (011);
//! - whether somebody ordered an abort, if the mission has any policy of the operator (012);
//! - what a plugin learns about its requests (009);
//! - the rates of each plugin, and those of the lines that plugins write into our own log (019);
//! - the path on which a hovering vehicle goes to the place that it is sent to. The place itself is judged by the
//!   boxes, in the vehicle's own frame (002, 005);
//! - what else follows from silent mode (018). The oracle judges only that silent mode is not requested again while it
//!   is on.

mod area;
mod clock;
mod conduct;
mod consequence;
mod control;
mod delivery;
mod dive;
mod due;
mod earth;
mod error;
mod flaws;
mod geojson;
mod heartbeat;
mod inserts;
mod integrity;
mod judged;
mod lease;
mod limits;
mod lines;
mod margin;
mod moment;
mod navigation;
mod operator;
mod oracle;
mod pause;
mod plan;
mod plane;
mod process;
mod rule;
mod services;
mod stamps;
mod state;
mod station;
mod statistics;
mod surroundings;
mod time_of_day;
mod violation;
pub mod wire;
mod zone;

pub use earth::Position;
pub use error::OracleError;
pub use judged::{Judged, Side};
pub use limits::{Activity, Caps, ControlHook, Limits, Truth};
pub use margin::{Bound, Margin, Margins, Nearest};
pub use oracle::Oracle;
pub use state::State;
pub use statistics::Statistics;
pub use time_of_day::{Echo, TimeOfDay};
pub use violation::Violation;
