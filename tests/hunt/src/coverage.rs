use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use backseat_oracle::State;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::flight::Flight;
use crate::margins::Distributions;

/// The states, requests and faults that a hunt has met, to show that it was not passed by doing nothing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Coverage {
    met: BTreeMap<String, [u64; State::ALL.len()]>,
    /// Missions flown.
    pub flights: u64,
    /// The number of those with a lease and an accepted insert.
    pub with_both: u64,
    /// The number of missions of hovering vehicles, and of those with both.
    pub hovering: [u64; 2],
    /// The number of missions of 20 minutes or more.
    pub long: u64,
    /// Virtual seconds.
    pub sim_seconds: f64,
    /// The number of faults that began.
    pub faults: u64,
    /// Leases, inserts accepted, inserts begun, BPRMB, connections, seconds of control, positions judged.
    pub sums: Sums,
    /// Failures by rule.
    pub failures: BTreeMap<String, u64>,
    /// Missions with a failure.
    pub failed: u64,
    /// How near the missions came to what is forbidden.
    #[serde(default)]
    pub margins: Distributions,
    /// The ends of missions.
    pub outcomes: BTreeMap<String, u64>,
}

/// The sums of what the oracle counted.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Sums {
    leases: u64,
    stations: u64,
    inserts_accepted: u64,
    inserts_begun: u64,
    modifies: u64,
    connections: u64,
    control_s: f64,
    judged: u64,
}

impl Coverage {
    pub(crate) fn add(&mut self, flight: &Flight) {
        self.flights += 1;
        let seen = &flight.report.seen;
        let both = seen.leases + seen.stations > 0 && seen.inserts_accepted > 0;
        self.with_both += u64::from(both);
        if flight.resolved.scenario.hovering {
            self.hovering[0] += 1;
            self.hovering[1] += u64::from(both);
        }
        self.long += u64::from(flight.report.sim_seconds >= 1200.0);
        self.sim_seconds += flight.report.sim_seconds;
        for (kind, state) in &flight.met {
            self.faults += 1;
            self.met.entry(kind.clone()).or_default()[*state as usize] += 1;
        }
        self.sums.leases += seen.leases;
        self.sums.stations += seen.stations;
        self.sums.inserts_accepted += seen.inserts_accepted;
        self.sums.inserts_begun += seen.inserts_begun;
        self.sums.modifies += seen.modifies;
        self.sums.connections += seen.connections;
        self.sums.control_s += seen.control_s;
        self.sums.judged += seen.truth_judged;
        self.margins.add(&seen.margins, flight.resolved.seed);
        self.failed += u64::from(!flight.failures.is_empty());
        for failure in &flight.failures {
            *self.failures.entry(failure.rule.clone()).or_default() += 1;
        }
        *self.outcomes.entry(flight.report.outcome.to_owned()).or_default() += 1;
    }

    /// Adds the coverage of other missions.
    pub fn merge(&mut self, other: &Self) {
        for (kind, counts) in &other.met {
            let row = self.met.entry(kind.clone()).or_default();
            for (count, more) in row.iter_mut().zip(counts) {
                *count += more;
            }
        }
        self.flights += other.flights;
        self.with_both += other.with_both;
        self.hovering[0] += other.hovering[0];
        self.hovering[1] += other.hovering[1];
        self.long += other.long;
        self.sim_seconds += other.sim_seconds;
        self.faults += other.faults;
        self.failed += other.failed;
        self.sums.leases += other.sums.leases;
        self.sums.stations += other.sums.stations;
        self.sums.inserts_accepted += other.sums.inserts_accepted;
        self.sums.inserts_begun += other.sums.inserts_begun;
        self.sums.modifies += other.sums.modifies;
        self.sums.connections += other.sums.connections;
        self.sums.control_s += other.sums.control_s;
        self.sums.judged += other.sums.judged;
        self.margins.merge(&other.margins);
        for (rule, count) in &other.failures {
            *self.failures.entry(rule.clone()).or_default() += count;
        }
        for (outcome, count) in &other.outcomes {
            *self.outcomes.entry(outcome.clone()).or_default() += count;
        }
    }

    /// How often a kind of fault began in a state.
    #[must_use]
    pub fn count(&self, kind: &str, state: State) -> u64 {
        self.met.get(kind).map_or(0, |row| row[state as usize])
    }

    /// The failures with their counts, in one line.
    #[must_use]
    pub fn brief(&self) -> String {
        let failures: Vec<String> = self
            .failures
            .iter()
            .map(|(rule, count)| format!("{count} x {rule}"))
            .collect();
        format!(
            "{} of {} missions failed: {}",
            self.failed,
            self.flights,
            if failures.is_empty() {
                "none".to_owned()
            } else {
                failures.join(", ")
            }
        )
    }

    /// The pairs that were met less often than `least`.
    #[must_use]
    pub fn rare(&self, least: u64) -> Vec<(String, State, u64)> {
        let mut rare = Vec::new();
        for kind in Fault::kinds() {
            for state in State::ALL {
                let count = self.count(&kind, state);
                if count < least {
                    rare.push((kind.clone(), state, count));
                }
            }
        }
        rare
    }
}

impl Display for Coverage {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let part = |count: u64| 100.0 * count as f64 / self.flights.max(1) as f64;
        writeln!(
            f,
            "{} missions, {:.0} h of virtual time ({:.0} s each), {:.2} % of 20 min or more",
            self.flights,
            self.sim_seconds / 3600.0,
            self.sim_seconds / self.flights.max(1) as f64,
            part(self.long)
        )?;
        let [hovering, hovering_both] = self.hovering;
        writeln!(
            f,
            "{:.2} % with a lease or station keeping and an accepted insert; {hovering} of hovering vehicles, {hovering_both} of them \
             with both",
            part(self.with_both)
        )?;
        let ended: Vec<String> = self
            .outcomes
            .iter()
            .map(|(outcome, count)| format!("{count} {outcome}"))
            .collect();
        writeln!(f, "ended: {}", ended.join(", "))?;
        let Sums {
            leases,
            stations,
            inserts_accepted,
            inserts_begun,
            modifies,
            connections,
            control_s,
            judged,
        } = &self.sums;
        writeln!(
            f,
            "{leases} leases ({modifies} BPRMB), station kept {stations} times, {inserts_accepted} inserts accepted and {inserts_begun} begun, \
             {connections} connections, {:.0} h of control, {judged} positions judged",
            control_s / 3600.0
        )?;
        writeln!(f, "{} faults; how often each met each state:", self.faults)?;
        write!(f, "{:32}", "")?;
        for state in State::ALL {
            write!(f, "{:>13}", state.name())?;
        }
        writeln!(f)?;
        for kind in Fault::kinds() {
            write!(f, "{kind:32}")?;
            for state in State::ALL {
                write!(f, "{:>13}", self.count(&kind, state))?;
            }
            writeln!(f)?;
        }
        writeln!(f, "how near the missions came to what is forbidden:")?;
        writeln!(f, "{}", self.margins)?;
        if self.failures.is_empty() {
            write!(f, "no violation, and every mission converged")
        } else {
            writeln!(f, "{} missions failed:", self.failed)?;
            for (rule, count) in &self.failures {
                writeln!(f, "  {count} x {rule}")?;
            }
            Ok(())
        }
    }
}
