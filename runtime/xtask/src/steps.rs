use std::fmt;
use std::time::{Duration, Instant};

use anyhow::Result;

/// The steps of a task, with the cost of each.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    done: Vec<Step>,
}

#[derive(Debug)]
struct Step {
    name: &'static str,
    wall: Duration,
    /// Processor time of the processes that the step has run; `None` if the system does not report it.
    processor: Option<Duration>,
}

impl Steps {
    /// Runs a step and records its cost, whether it fails or not.
    pub(crate) fn run<T>(&mut self, name: &'static str, step: impl FnOnce() -> Result<T>) -> Result<T> {
        println!("\n== {name}");
        let processor = processor_time();
        #[expect(clippy::disallowed_methods, reason = "a task runs in real time")]
        let start = Instant::now();
        let result = step();
        self.done.push(Step {
            name,
            wall: start.elapsed(),
            processor: processor.and_then(|before| processor_time()?.checked_sub(before)),
        });
        result
    }

    /// Prints the cost of each step, if there was one.
    pub(crate) fn show(&self) {
        if !self.done.is_empty() {
            println!("\n{self}");
        }
    }
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:32} {:>8} {:>12}", "step", "wall s", "processor s")?;
        let mut row = |name: &str, wall: Duration, processor: Option<Duration>| {
            let processor = processor.map_or_else(|| "-".to_owned(), |time| format!("{:.1}", time.as_secs_f64()));
            writeln!(f, "{name:32} {:>8.1} {processor:>12}", wall.as_secs_f64())
        };
        for step in &self.done {
            row(step.name, step.wall, step.processor)?;
        }
        let wall = self.done.iter().map(|step| step.wall).sum();
        row("all", wall, self.done.iter().map(|step| step.processor).sum())
    }
}

/// Processor time of all processes that this one has waited for, from Linux' `/proc/self/stat` (proc(5): the fields
/// `cutime` and `cstime`, in ticks of 10 ms on every Linux that Rust runs on).
fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name is in brackets and may contain spaces, so fields are counted after it, from the third on.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks: u64 = fields
        .split_whitespace()
        .skip(16 - 3)
        .take(2)
        .map(|field| field.parse::<u64>().ok())
        .sum::<Option<u64>>()?;
    Some(Duration::from_millis(10 * ticks))
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn a_step_costs_what_its_processes_cost_and_its_failure_is_kept() {
        let mut steps = Steps::default();
        let busy = || -> Result<()> {
            let script = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done";
            Command::new("sh").args(["-c", script]).status()?;
            anyhow::bail!("no")
        };
        assert!(steps.run("busy", busy).is_err());
        steps.run("idle", || Ok(())).unwrap();
        let spent = |step: &Step| step.processor.unwrap_or_default();
        assert!(
            cfg!(not(target_os = "linux")) || spent(&steps.done[0]) > spent(&steps.done[1]),
            "{steps}"
        );
        assert_eq!(steps.to_string().lines().count(), 4, "{steps}");
    }
}
