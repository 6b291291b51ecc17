//! Clients over TCP, in real time.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::memory::resident_kib;

const GROWTH_MAX_KIB: u64 = 4096;
/// Clients stop sending this long before the end, so that nothing is in transit then.
const QUIET_BEFORE_END: Duration = Duration::from_secs(2);

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Tcp {
    /// Duration in minutes of real time
    #[arg(long, default_value_t = 60.0)]
    pub minutes: f64,
    /// Number of clients, at most 16
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub clients: u32,
    /// The program [default: built from the tree]
    #[arg(long)]
    pub program: Option<PathBuf>,
}

/// The results.
#[derive(Clone, Debug)]
pub struct TcpReport {
    /// Real time.
    pub real: Duration,
    /// The program's memory after a tenth, in the middle and at the end, KiB.
    pub resident_kib: Vec<u64>,
    /// Sentences counted by the clients: received and sent.
    pub by_clients: (u64, u64),
    /// Sentences in the log.
    pub by_log: (u64, u64),
    /// Clients whose sentences differ from the log's, compared one by one and in order.
    pub different: Vec<String>,
    /// The number of BFNVG in the log whose stamp differs from their line's time.
    pub clock_wrong: u64,
    /// The vehicle's time at the end of the log, seconds, and the expected time.
    pub clock_s: (f64, f64),
}

/// A count and a hash of lines in their order: two equal ones stand for the same lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    lines: u64,
    sum: u64,
}

impl Tally {
    fn add(&mut self, line: &[u8]) {
        self.lines += 1;
        // FNV-1a, including the line's end.
        for byte in line.iter().chain(b"\n") {
            self.sum = (self.sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

/// Serves the clients.
///
/// # Errors
///
/// If the program does not run, or a connection fails.
pub fn run(arguments: &Tcp) -> Result<TcpReport> {
    let program = match &arguments.program {
        Some(program) => program.clone(),
        None => backseat_test_support::program().to_path_buf(),
    };
    let folder = tempfile::tempdir()?;
    let (log, errors) = (folder.path().join("vehicle.log"), folder.path().join("stderr"));
    let lasts = Duration::from_secs_f64(arguments.minutes * 60.0);
    let child = Command::new(program)
        .arg("mvc")
        .arg(backseat_test_support::workspace().join("tests/suite/missions/steady"))
        .args([
            "--listen",
            "127.0.0.1:0",
            "--duration",
            &lasts.as_secs_f64().to_string(),
            "--log",
        ])
        .arg(&log)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&errors)?)
        .spawn()
        .context("the program does not start")?;
    let mut child = Guard(child);
    let start = Instant::now();
    let address = listening(&errors)?;
    let quiet = lasts.saturating_sub(QUIET_BEFORE_END);
    let clients = (0..arguments.clients)
        .map(|number| client(&address, number, start, quiet))
        .collect::<Result<Vec<_>>>()?;
    let mut resident = Vec::new();
    for share in [0.1, 0.5, 0.95] {
        thread::sleep(lasts.mul_f64(share).saturating_sub(start.elapsed()));
        resident.push(resident_kib(&child.0.id().to_string())?);
    }
    let mut report = TcpReport {
        real: lasts,
        resident_kib: resident,
        by_clients: (0, 0),
        by_log: (0, 0),
        different: Vec::new(),
        clock_wrong: 0,
        clock_s: (0.0, lasts.as_secs_f64()),
    };
    let mut by_port = BTreeMap::new();
    for client in clients {
        let (port, received, sent) = client.join().map_err(|_| anyhow::anyhow!("a client panicked"))??;
        by_port.insert(port, (received, sent));
    }
    let status = child.0.wait()?;
    if !status.success() {
        bail!("the program ended with {status}: {}", std::fs::read_to_string(&errors)?);
    }
    compare(&log, by_port, &mut report)?;
    Ok(report)
}

struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        // It has usually ended already.
        let _ended = self.0.kill();
        let _status = self.0.wait();
    }
}

fn listening(errors: &PathBuf) -> Result<String> {
    for _ in 0..300 {
        let text = std::fs::read_to_string(errors)?;
        if let Some(line) = text.lines().find(|line| line.contains("listening on ")) {
            return Ok(line.rsplit(' ').next().unwrap_or_default().to_owned());
        }
        thread::sleep(Duration::from_millis(100));
    }
    bail!("the program does not listen: {}", std::fs::read_to_string(errors)?)
}

type Counted = Result<(u16, Tally, Tally)>;

/// A client that subscribes to everything, sends sentences in pieces each second, and reads to the end.
fn client(address: &str, number: u32, start: Instant, quiet: Duration) -> Result<JoinHandle<Counted>> {
    let mut stream = TcpStream::connect(address)?;
    let port = stream.local_addr()?.port();
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(Duration::from_millis(200)))?;
    Ok(thread::spawn(move || {
        let (mut received, mut sent) = (Tally::default(), Tally::default());
        let mut say = |stream: &mut TcpStream, line: &str| -> Result<()> {
            sent.add(line.as_bytes());
            let bytes = format!("{line}\r\n");
            let (one, other) = bytes.as_bytes().split_at(bytes.len() / 2);
            stream.write_all(one)?;
            Ok(stream.write_all(other)?)
        };
        say(&mut stream, "$BPLOG,ALL,ON")?;
        say(&mut stream, "$BPLOG,ACK,ON")?;
        let (mut buffer, mut partial, mut said) = ([0; 16_384], Vec::new(), 0);
        loop {
            let now = start.elapsed();
            if now.as_secs() > said && now < quiet {
                said = now.as_secs();
                say(&mut stream, &format!("$BPMSG,120000.000,client {number} second {said}"))?;
                if said % 7 == u64::from(number % 7) {
                    say(&mut stream, "$BPRMP,120000.000")?;
                }
            }
            match stream.read(&mut buffer) {
                Ok(0) => return Ok((port, received, sent)),
                Ok(count) => {
                    partial.extend_from_slice(buffer.get(..count).unwrap_or_default());
                    let end = partial.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
                    for line in partial.drain(..end).collect::<Vec<u8>>().split(|byte| *byte == b'\n') {
                        let line = line.trim_ascii_end();
                        if !line.is_empty() {
                            received.add(line);
                        }
                    }
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => return Err(error).context(format!("client {number}")),
            }
        }
    }))
}

fn compare(log: &PathBuf, by_port: BTreeMap<u16, (Tally, Tally)>, report: &mut TcpReport) -> Result<()> {
    let (mut ports, mut tallies): (BTreeMap<String, u16>, BTreeMap<String, (Tally, Tally)>) = Default::default();
    for line in BufReader::new(File::open(log)?).lines() {
        let line = line?;
        let (at, rest) = line.split_once(' ').context("a line without a time")?;
        if let Some(event) = rest.strip_prefix("-- ") {
            if let Some((client, address)) = event.split_once(" connected from 127.0.0.1:") {
                ports.insert(client.trim_start_matches("client ").to_owned(), address.parse()?);
            }
            continue;
        }
        let (way, rest) = rest.split_once(" client ").context("a line without a client")?;
        let (client, text) = rest.split_once(' ').context("a line without a text")?;
        let tally = tallies.entry(client.to_owned()).or_default();
        match way {
            ">" => tally.0.add(text.as_bytes()),
            "<" => tally.1.add(text.as_bytes()),
            _ => bail!("a line without a direction: {line}"),
        }
        if way == ">" && text.starts_with("$BFNVG,") {
            report.clock_s.0 = at.parse()?;
            // The mission starts at 08:00.
            let ms = (report.clock_s.0 * 1000.0).round() as u64 + 8 * 3_600_000;
            let (s, ms) = (ms / 1000 % 86_400, ms % 1000);
            let stamp = format!("{:02}{:02}{:02}.{ms:03}", s / 3600, s / 60 % 60, s % 60);
            report.clock_wrong += u64::from(text.get(7..17) != Some(stamp.as_str()));
        }
    }
    for (client, (received, sent)) in tallies {
        let own = ports
            .get(&client)
            .and_then(|port| by_port.get(port))
            .copied()
            .unwrap_or_default();
        report.by_log = (report.by_log.0 + received.lines, report.by_log.1 + sent.lines);
        report.by_clients = (report.by_clients.0 + own.0.lines, report.by_clients.1 + own.1.lines);
        if own != (received, sent) {
            report
                .different
                .push(format!("client {client}: {own:?}, in the log {received:?} {sent:?}"));
        }
    }
    Ok(())
}

impl TcpReport {
    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.different.clone();
        if let [_, middle, end] = *self.resident_kib
            && end > middle + GROWTH_MAX_KIB
        {
            faults.push(format!("memory grew from {middle} to {end} KiB in the second half"));
        }
        if self.by_clients != self.by_log || self.by_log.0 == 0 {
            faults.push(format!(
                "sentences: {:?} by the clients, {:?} by the log",
                self.by_clients, self.by_log
            ));
        }
        if self.clock_wrong > 0 {
            faults.push(format!("{} BFNVG differ from their line's time", self.clock_wrong));
        }
        let (clock, expected) = self.clock_s;
        if (clock - expected).abs() > 0.1001 {
            faults.push(format!(
                "the last BFNVG is from {clock} s, expected the end at {expected} s"
            ));
        }
        faults
    }
}

impl fmt::Display for TcpReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:.0} s of real time", self.real.as_secs_f64())?;
        writeln!(
            f,
            "memory of the program: {:?} KiB at a tenth, in the middle, at the end",
            self.resident_kib
        )?;
        writeln!(
            f,
            "the last BFNVG is from {:.3} s; {} differ from their line's time",
            self.clock_s.0, self.clock_wrong
        )?;
        write!(
            f,
            "{} sentences received and {} sent by the clients; {} and {} in the log",
            self.by_clients.0, self.by_clients.1, self.by_log.0, self.by_log.1
        )
    }
}
