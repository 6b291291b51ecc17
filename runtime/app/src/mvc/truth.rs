use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_mvc::{Activity, Mvc};
use backseat_units::Timestamp;
use tracing::warn;

use crate::clock::Clock;

/// How much real time of the file a killed process can lose.
const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// The columns, with their units.
const COLUMNS: &str = "time_s,utc,latitude_deg,longitude_deg,east_m,north_m,depth_m,altitude_m,heading_deg,pitch_deg,\
                       roll_deg,speed_through_water_mps,east_mps,north_mps,down_mps,control,activity";

/// Where the vehicle truly was, a line of comma-separated values for each second, while it goes.
pub(crate) struct TruthFile {
    file: BufWriter<File>,
    path: PathBuf,
    clock: Clock,
    flush_at: Duration,
    /// The first whole second that has no line yet.
    next_s: u64,
    failed: bool,
}

impl TruthFile {
    /// Makes the file, with the columns and the first line.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub(crate) fn create(path: &Path, clock: Clock, vehicle: &Mvc) -> Result<Self> {
        let file = File::create(path).with_context(|| format!("{}", path.display()))?;
        let mut made = Self {
            file: BufWriter::with_capacity(1 << 16, file),
            path: path.to_path_buf(),
            clock,
            flush_at: Duration::ZERO,
            next_s: 0,
            failed: false,
        };
        let written = writeln!(made.file, "{COLUMNS}");
        made.check(written);
        made.step(vehicle);
        Ok(made)
    }

    /// The vehicle has taken a step.
    pub(crate) fn step(&mut self, vehicle: &Mvc) {
        let at = vehicle.truth().time;
        let second = at.as_nanos() / 1_000_000_000;
        if self.failed || second < self.next_s {
            return;
        }
        self.next_s = second + 1;
        let written = line(&mut self.file, at, vehicle);
        self.check(written);
        let real = self.clock.elapsed();
        if real >= self.flush_at && !self.failed {
            self.flush_at = real + FLUSH_EVERY;
            let flushed = self.file.flush();
            self.check(flushed);
        }
    }

    /// Writes what is left.
    ///
    /// # Errors
    ///
    /// If the file is incomplete.
    pub(crate) fn finish(&mut self) -> Result<()> {
        if !self.failed {
            let flushed = self.file.flush();
            self.check(flushed);
        }
        if self.failed {
            bail!("{}: the file is incomplete", self.path.display());
        }
        Ok(())
    }

    fn check(&mut self, written: std::io::Result<()>) {
        if let Err(error) = written
            && !std::mem::replace(&mut self.failed, true)
        {
            warn!(
                "{}: {error}; the file ends here, the vehicle goes on",
                self.path.display()
            );
        }
    }
}

fn line(out: &mut impl Write, at: Timestamp, vehicle: &Mvc) -> std::io::Result<()> {
    let truth = vehicle.truth();
    write!(
        out,
        "{:.3},{},{:.8},{:.8},{:.3},{:.3},{:.3},{:.3},",
        at.as_secs_f64(),
        vehicle.utc(at).time_of_day(),
        truth.position.latitude.as_deg(),
        truth.position.longitude.as_deg(),
        truth.local.east_m,
        truth.local.north_m,
        truth.depth_m,
        truth.altitude_m,
    )?;
    writeln!(
        out,
        "{:.2},{:.2},{:.2},{:.3},{:.3},{:.3},{:.3},{},{}",
        truth.heading_deg,
        truth.pitch_deg,
        truth.roll_deg,
        truth.speed_mps,
        truth.east_mps,
        truth.north_mps,
        truth.down_mps,
        if truth.control { "payload" } else { "vehicle" },
        match truth.activity {
            Activity::Waiting => "waiting",
            Activity::Plan { .. } => "plan",
            Activity::Insert { .. } => "insert",
            Activity::Modified { .. } => "modified",
            Activity::Suspended => "suspended",
            Activity::WrappingUp => "wrapping-up",
            Activity::Stopped => "stopped",
        }
    )
}
