use anyhow::{Context, Result};

/// The memory that a process uses, KiB. The process is `self` or a number.
///
/// # Errors
///
/// If the process has ended, or if there is no /proc.
pub fn resident_kib(process: &str) -> Result<u64> {
    let path = format!("/proc/{process}/status");
    let status = std::fs::read_to_string(&path).with_context(|| path.clone())?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    number.and_then(|number| number.parse().ok()).context(path)
}
