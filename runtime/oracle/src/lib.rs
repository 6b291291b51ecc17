//! Judges a run from the recorded link bytes and the mock vehicle's truth alone.
//!
//! An [`Oracle`] is given every write on the vehicle link at its sender, every change of the link, and the vehicle's
//! truth ten times a second, all in the order of their times. It knows the fence, the [`Limits`], and what the safety
//! requirements promise. What it finds are [`Violation`]s, and its [`Statistics`] say how much there was to judge, so that
//! an empty run is not taken for a clean one.
//!
//! It shares no code with what it judges: it depends on no other crate of this project. It reads sentences by itself
//! ([`wire`]), and the fence; its times are nanoseconds, its places degrees, and its lines run straight through the
//! earth, where the runtime's are straight in a projection.
//!
//! Where the delay of the link leaves open what the runtime could have known, the oracle gives it the benefit of the
//! longest delay: a violation stands on any reading. The vehicle's bytes are those that are let on their way to us, after
//! the faults of the link, so that what a fault has held back, damaged or swallowed is not held against us; ours are
//! those that we write, and where a run tells [`Oracle::arrived`], those that the vehicle receives too. What a stopped
//! runtime was told it has heard when it goes on; what a previous run knew, a new one does not.
//!
//! # Requirements and rules
//!
//! | requirement | rules |
//! |---|---|
//! | 001 control | `no-control` |
//! | 002 fence | `request-fence`, `request-vertical`, `request-speed`, `request-surfacing`, `request-box`, `bottom-unknown`, `modify-fence`, `plan-unknown`, `begin-unheard`; by what the vehicle believes `insert-margin`; by truth `truth-fence`, `truth-depth`, `truth-grounded` |
//! | 003 modifies live and end | `modify-gap`, `modify-abandoned`, `modify-too-fast`, `modify-inherits`, `modify-unanswered`, `lease-outlives`, `lease-after-stop` |
//! | 004 each refresh | `refresh-fence`, `modify-margin` |
//! | 005 station keeping | `station-gap`, `station-dead` |
//! | 006 faulty plugins | none of its own: what a sibling must keep is judged as 003 and 005 |
//! | 007 what outlives us | by truth `modify-outlives`, `station-outlives`; `stale-delivery`; the caps of 019 and the fence of 002 for inserts |
//! | 008 stale navigation | `stale-navigation` |
//! | 009 one outcome | `identifier-repeated`, `stamp-repeated`, `insert-in-doubt` |
//! | 010 interrupts | `interrupt-of-interrupt` |
//! | 011 shutdown | `after-shutdown` |
//! | 012 aborts and kills | `operator-only` |
//! | 013 bad bytes | none: a panic ends the run, and memory is not on the wire |
//! | 014 without control | `end-missing`, `end-surplus`, `not-allowed-without-control`, `cancel-foreign` |
//! | 015 operator's hold | `operator-hold`, `hold-cancel-missing` |
//! | 016 acoustic windows | `packet-window` |
//! | 017 DVL triggering | `trigger-without-leave`, `trigger-not-ceased` |
//! | 018 silent mode | `silence-repeated` |
//! | 019 rates and totals | `inserts-total`, `inserts-open`, `inserts-duration`, `requests-total` |
//! | 020 recovery | `modify-fence` where a lease begins outside; by truth `truth-cancel` |
//! | 021 the monitor's truth | `jump-ignored`, `moves-truth` |
//! | 023 the vehicle hears us | `unheard`, `pause-ignored`, `clock-set` |
//! | 024 navigation that is true | `velocity-missing`; by truth `navigation-untrue` |
//! | 025 another dive | `another-dive` |
//!
//! # What a rule is judged by
//!
//! Each rule is judged by one [`Side`]: our sentences alone, our sentences after the vehicle's or the operator's words, the
//! arrival of our words, or the truth. [`Oracle::rules`] tells how often each was judged, and why not where it was not. The
//! log of a dive has no truth and no arrivals, and may have gaps ([`Oracle::gap`]); its times are those at which the runtime
//! sent and heard.
//!
//! `navigation-untrue` looks at windows of at most 9.5 s of the solutions' time. In each it takes by how much the told place
//! left the truth, and from that by how much the told velocities, added up, left it too: what both have wrong alike no
//! payload can see. The rest may be `position_step_m`, `position_drift_mps` for each second of the window, and 0.5 m for the
//! wire's decimals. By a mission's default limits that is 13.35 m in a whole window: a place that creeps away at 1.5 m/s is
//! found, one at 1.3 m/s is not. Before it counts, a stretch of half a second must disagree with a later sample. Nothing
//! that steers may leave from when that sample was heard until 9.9 s after the begin of the stretch. Windows begin anew
//! where the runtime cannot compare: on another connection, after a gap, after a standstill, by GPS at the surface.
//!
//! `malformed` is of the interface (SPI 4.2) and of no requirement.
//!
//! What bytes and truth cannot show, beside 006 and 013: that plugins and logs were told and closed in time (011), that
//! an abort was ordered where the mission has an operator's policy at all (012), what a plugin is told of its requests
//! (009), the rates of each plugin and those of log lines (019), and on which path a hovering vehicle comes to the place that
//! it is sent to: that place is judged by the boxes, in the vehicle's own frame (002, 005). Of 018 no more shows than that silence is not asked for anew:
//! what else follows from it is the plugin's to know.

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
pub use oracle::Oracle;
pub use state::State;
pub use statistics::Statistics;
pub use time_of_day::{Echo, TimeOfDay};
pub use violation::Violation;
