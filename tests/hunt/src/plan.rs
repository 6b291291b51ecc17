mod renamed;

use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_mvc::{Fault as VehicleFault, FaultPlan};
use backseat_oracle::State;
use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

use crate::dice::Dice;
use crate::fault::{Fault, Written};
use crate::phase::{CALM_S, FIRST_S, SAFETY_S};
use crate::scenario::Scenario;

/// A mission with its faults: everything that decides a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The seed of the world, the links and the random parts of faults.
    pub seed: u64,
    /// The fence, the limits, the plan and the world.
    pub scenario: Scenario,
    /// The faults.
    pub faults: Vec<Planned>,
    /// When the flight ends, if before the mission's own end.
    pub until: Option<Timestamp>,
}

/// A fault with its beginning.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// When it begins.
    pub come: Come,
    /// The fault.
    pub fault: Fault,
}

/// When a fault begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Come {
    /// At a time.
    At(Timestamp),
    /// Some time after the run has entered a state.
    In {
        /// The state.
        state: State,
        /// The number of the entry, from 1.
        nth: u32,
        /// The time after it.
        after: Duration,
    },
}

/// The least and the most faults of a drawn plan.
const FAULTS: (usize, usize) = (3, 9);
/// The share of missions that are ended from outside.
const FATAL_SHARE: f64 = 0.04;
/// The share of faults waiting for a state that wait for a request for an insert.
const ASKED_SHARE: f64 = 0.2;
/// The share of links that are constantly or increasingly slow.
const SLOW_SHARE: f64 = 0.1;

impl Plan {
    /// Draws the plan of a seed.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let scenario = Scenario::draw(seed);
        // The stream keeps the former name of faults, because with another name a seed would draw another mission.
        let mut dice = Dice::new(seed, "troubles");
        let count = FAULTS.0 + dice.below(FAULTS.1 - FAULTS.0 + 1);
        let states = scenario.states();
        let mut faults: Vec<Planned> = (0..count)
            .map(|_| {
                let fault = Fault::draw(&mut dice, SAFETY_S / 4.0);
                let come = draw_come(&mut dice, states);
                Planned { come, fault }
            })
            .collect();
        let fatal_share = if scenario.hovering { 3.0 } else { 1.0 } * FATAL_SHARE;
        if dice.chance(fatal_share) {
            let fault = Fault::draw_fatal(&mut dice);
            let come = draw_come(&mut dice, states);
            if fault.ends_mission() && dice.chance(0.5) {
                // Some of its sentences are lost.
                let lasts = Duration::from_secs(2);
                faults.push(Planned {
                    come,
                    fault: Fault::dropping(&mut dice).at_most(lasts),
                });
            }
            faults.push(Planned { come, fault });
        }
        if dice.chance(SLOW_SHARE) {
            faults.push(Planned {
                come: Come::At(Timestamp::ZERO),
                fault: Fault::draw_slow_link(&mut dice),
            });
        }
        // A fault that begins while the link is down needs another that takes it down.
        if faults
            .iter()
            .any(|planned| matches!(planned.come, Come::In { state: State::Down, .. }))
        {
            let away = dice.millis(0.1, 30.0);
            let at = Timestamp::ZERO + dice.millis(2.0 * FIRST_S, SAFETY_S);
            faults.push(Planned {
                come: Come::At(at),
                fault: Fault::Kill { away, clock_s: 0.0 },
            });
        }
        Self {
            seed,
            scenario,
            faults,
            until: None,
        }
    }

    /// A mission of [`Scenario::draw_detours`] without faults.
    #[must_use]
    pub fn draw_detours(seed: u64) -> Self {
        Self {
            seed,
            scenario: Scenario::draw_detours(seed),
            faults: Vec::new(),
            until: None,
        }
    }

    /// Reads a plan's file.
    ///
    /// # Errors
    ///
    /// In one line: the table, the key, what was expected.
    pub fn from_toml(text: &str) -> Result<Self> {
        let file: File = toml::from_str(text).map_err(|error| {
            let place = error
                .span()
                .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            anyhow::anyhow!("line {place}: {}", renamed::with_new_name(error.message()))
        })?;
        let mut faults = Vec::new();
        for (index, entry) in file.fault.into_iter().enumerate() {
            let of = || format!("fault {}", index + 1);
            faults.push(entry.planned().with_context(of)?);
        }
        Ok(Self {
            seed: file.seed,
            scenario: file.scenario,
            faults,
            until: match file.until_s {
                Some(s) => Some(Timestamp::ZERO + span(s, "until_s")?),
                None => None,
            },
        })
    }

    /// The whole plan, in the form that [`Plan::from_toml`] reads.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let file = File {
            seed: self.seed,
            until_s: self.until.map(Timestamp::as_secs_f64),
            fault: self.faults.iter().map(Entry::of).collect(),
            scenario: self.scenario.clone(),
        };
        toml::to_string_pretty(&file).expect("a plan has only numbers, strings and tables")
    }

    /// The faults, one line each.
    pub fn lines(&self) -> impl Iterator<Item = String> + '_ {
        self.faults.iter().map(|planned| {
            let when = match planned.come {
                Come::At(at) => format!("at {:.3} s", at.as_secs_f64()),
                Come::In { state, nth, after } => {
                    format!("{:.3} s into {} number {nth}", after.as_secs_f64(), state.name())
                }
            };
            format!(
                "{when}: {} for {:.3} s",
                planned.fault.kind(),
                planned.fault.lasts().as_secs_f64()
            )
        })
    }
}

/// Half of them begin at any time, half in a drawn state, so that short states are met too.
fn draw_come(dice: &mut Dice, states: &[State]) -> Come {
    if dice.chance(0.35) {
        return Come::At(Timestamp::ZERO + dice.millis(FIRST_S, SAFETY_S));
    }
    // The shortest state is met rarely otherwise.
    let state = if dice.chance(ASKED_SHARE) {
        State::Asked
    } else {
        dice.one(states)
    };
    let nth = 1 + dice.below(if state == State::Asked { 2 } else { 4 }) as u32;
    // Short states end soon.
    let most_s = match state {
        State::Asked => 0.05,
        State::Down => 1.0,
        State::NoControl | State::Idle | State::Queued | State::Lease | State::LeaseInsert => 8.0,
        State::Insert | State::Station => 15.0,
    };
    let share = dice.between(0.0, 1.0);
    Come::In {
        state,
        nth,
        after: Duration::from_millis((1000.0 * most_s * share * share) as u64),
    }
}

/// The longest that a fault that begins now may last, so that it is over when the liveness phase begins.
pub(crate) fn until_calm(now: Timestamp) -> Duration {
    (Timestamp::ZERO + Duration::from_secs_f64(CALM_S)).since(now)
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    seed: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    until_s: Option<f64>,
    #[serde(default)]
    fault: Vec<Entry>,
    scenario: Scenario,
}

/// A `[[fault]]` table: `at_s`, or `state`, `nth` and `after_s`; and either a `vehicle` table, in the form of the
/// mock's own files of faults, or an `ours` table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    #[serde(skip_serializing_if = "Option::is_none")]
    at_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nth: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    after_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vehicle: Option<toml::Table>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ours: Option<Written>,
}

impl Entry {
    fn of(planned: &Planned) -> Self {
        let vehicle = match &planned.fault {
            Fault::Vehicle(fault) => Some(fault_table(fault)),
            Fault::Plugin { .. }
            | Fault::Swap { .. }
            | Fault::Kill { .. }
            | Fault::Stop { .. }
            | Fault::Hold { .. }
            | Fault::AllTrap { .. }
            | Fault::DiskFull { .. } => None,
        };
        let mut entry = Self {
            at_s: None,
            state: None,
            nth: None,
            after_s: None,
            vehicle,
            ours: Written::of(&planned.fault),
        };
        match planned.come {
            Come::At(at) => entry.at_s = Some(at.as_secs_f64()),
            Come::In { state, nth, after } => {
                entry.state = Some(state.name().to_owned());
                entry.nth = Some(nth);
                entry.after_s = Some(after.as_secs_f64());
            }
        }
        entry
    }

    fn planned(self) -> Result<Planned> {
        let come = match (self.at_s, self.state) {
            (Some(at_s), None) => Come::At(Timestamp::ZERO + span(at_s, "at_s")?),
            (None, Some(name)) => {
                let state = State::ALL.into_iter().find(|state| state.name() == name);
                let Some(state) = state else {
                    if let Some(now) = renamed::state(&name) {
                        bail!("state is {name:?}, whose name is {now:?} now");
                    }
                    let names: Vec<&str> = State::ALL.iter().map(|state| state.name()).collect();
                    bail!("state is {name:?}: expected one of {}", names.join(", "));
                };
                Come::In {
                    state,
                    nth: self.nth.unwrap_or(1).max(1),
                    after: span(self.after_s.unwrap_or(0.0), "after_s")?,
                }
            }
            (Some(_), Some(_)) | (None, None) => bail!("expected either at_s or state"),
        };
        let fault = match (self.vehicle, self.ours) {
            (Some(table), None) => Fault::Vehicle(fault_of(table)?),
            (None, Some(written)) => written.fault().map_err(anyhow::Error::msg)?,
            (Some(_), Some(_)) | (None, None) => bail!("expected either a vehicle table or an ours table"),
        };
        Ok(Planned { come, fault })
    }
}

fn span(s: f64, key: &str) -> Result<Duration> {
    match Duration::try_from_secs_f64(s) {
        Ok(span) if span <= Duration::from_secs(86_400) => Ok(span),
        _ => bail!("{key} is {s}: expected 0 to 86400"),
    }
}

/// A fault in the form of the mock's own files.
fn fault_table(fault: &VehicleFault) -> toml::Table {
    let plan = FaultPlan {
        faults: vec![fault.clone()],
    };
    let mut file: toml::Table = toml::from_str(&plan.to_toml()).expect("the mock reads what it writes");
    match file.remove("fault") {
        Some(toml::Value::Array(mut faults)) => match faults.pop() {
            Some(toml::Value::Table(mut table)) => {
                // The time is that of the plan's fault.
                table.remove("at_s");
                table
            }
            Some(_) | None => unreachable!("a fault is a table"),
        },
        Some(_) | None => unreachable!("a plan of faults is a list"),
    }
}

fn fault_of(mut table: toml::Table) -> Result<VehicleFault> {
    table.insert("at_s".to_owned(), toml::Value::Float(0.0));
    let mut file = toml::Table::new();
    file.insert("fault".to_owned(), toml::Value::Array(vec![toml::Value::Table(table)]));
    let mut plan = FaultPlan::from_toml(&toml::to_string(&file)?)?;
    plan.faults.pop().context("the vehicle table is no fault")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_is_the_same_after_it_was_written_and_read() {
        for plan in (0..300).flat_map(|seed| [Plan::draw(seed), Plan::draw_detours(seed)]) {
            let seed = plan.seed;
            let text = plan.to_toml();
            let read = Plan::from_toml(&text).unwrap_or_else(|error| panic!("seed {seed}: {error:#}\n{text}"));
            assert_eq!(read, plan, "seed {seed}");
        }
    }

    #[test]
    fn a_plan_that_is_none_is_refused_in_a_line() {
        let text = Plan::draw(7).to_toml();
        for (from, to, expected) in [
            ("seed = 7", "sead = 7", "unknown field"),
            (
                "seed = 7",
                "seed = 7\nuntil_s = -1",
                "until_s is -1: expected 0 to 86400",
            ),
            ("[[fault]]", "[[fault]]\nwhat = 1", "unknown field"),
        ] {
            assert!(text.contains(from));
            let error = format!("{:#}", Plan::from_toml(&text.replacen(from, to, 1)).unwrap_err());
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
    }
}
