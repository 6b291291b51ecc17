//! The extension module `backseat._native`. Results are JSON, which `python/backseat` reads, so that this file stays
//! small: what a user sees is written in Python, with its types.

use std::path::PathBuf;

use pyo3::prelude::*;

/// What `python/backseat` calls.
#[pymodule]
mod _native {
    use super::*;
    use crate::{Campaign, Error, Flight};

    pyo3::create_exception!(
        backseat,
        MissionError,
        pyo3::exceptions::PyValueError,
        "A mission, or one of its files, plugins or settings, is invalid."
    );
    pyo3::create_exception!(
        backseat,
        LogError,
        pyo3::exceptions::PyValueError,
        "A file is not the log of a run, or does not have what was asked for."
    );
    pyo3::create_exception!(
        backseat,
        SpiError,
        pyo3::exceptions::PyValueError,
        "A sentence or a message is not one of the Standard Payload Interface."
    );

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let py = module.py();
        module.add("MissionError", py.get_type::<MissionError>())?;
        module.add("LogError", py.get_type::<LogError>())?;
        module.add("SpiError", py.get_type::<SpiError>())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    /// Flies a mission; returns the report as JSON.
    #[pyfunction]
    #[pyo3(signature = (mission, seed, set, faults, draw_faults, plugins, log))]
    fn simulate(
        py: Python<'_>,
        mission: PathBuf,
        seed: u64,
        set: Vec<String>,
        faults: Option<PathBuf>,
        draw_faults: Option<String>,
        plugins: Option<PathBuf>,
        log: Option<PathBuf>,
    ) -> PyResult<String> {
        let mut signal = None;
        let report = py.detach(|| {
            let flight = Flight {
                mission: &mission,
                seed,
                set,
                faults: faults.as_deref(),
                draw_faults: draw_faults.as_deref(),
                plugins: plugins.as_deref(),
                log: log.as_deref(),
            };
            // Ctrl-C ends a run.
            crate::simulate(&flight, || {
                signal = Python::attach(|py| py.check_signals().err());
                signal.is_some()
            })
        });
        match (report, signal) {
            (Err(Error::Interrupted), Some(signal)) => Err(signal),
            (report, _) => json(&report.map_err(raised)?),
        }
    }

    /// Flies a campaign; returns the counts of its runs as JSON.
    #[pyfunction]
    #[pyo3(signature = (campaign, out, seeds, set, plugins, workers))]
    fn campaign(
        py: Python<'_>,
        campaign: PathBuf,
        out: PathBuf,
        seeds: Option<String>,
        set: Vec<String>,
        plugins: Option<PathBuf>,
        workers: Option<usize>,
    ) -> PyResult<String> {
        let mut signal = None;
        let counts = py.detach(|| {
            let campaign = Campaign {
                campaign: &campaign,
                out: &out,
                seeds: seeds.as_deref(),
                set,
                plugins: plugins.as_deref(),
                workers,
            };
            // Ctrl-C stops the campaign.
            crate::campaign(&campaign, || {
                signal = Python::attach(|py| py.check_signals().err());
                signal.is_some()
            })
        });
        match (counts, signal) {
            (Err(Error::Interrupted), Some(signal)) => Err(signal),
            (counts, _) => json(&counts.map_err(raised)?),
        }
    }

    /// What a log has, as JSON.
    #[pyfunction]
    fn describe(py: Python<'_>, log: PathBuf) -> PyResult<String> {
        json(&py.detach(|| crate::describe(&log)).map_err(raised)?)
    }

    /// Writes a channel's table as Parquet; returns remarks.
    #[pyfunction]
    fn table(py: Python<'_>, log: PathBuf, channel: String, out: PathBuf) -> PyResult<Vec<String>> {
        py.detach(|| crate::table(&log, &channel, &out)).map_err(raised)
    }

    /// Writes the trajectory as NetCDF; returns remarks.
    #[pyfunction]
    fn trajectory(py: Python<'_>, log: PathBuf, out: PathBuf) -> PyResult<Vec<String>> {
        py.detach(|| crate::trajectory(&log, &out)).map_err(raised)
    }

    /// Decodes every sentence in some bytes; returns a JSON array.
    #[pyfunction]
    fn decode(bytes: Vec<u8>, ignore_checksum: bool) -> PyResult<String> {
        json(&crate::decode(&bytes, ignore_checksum).map_err(raised)?)
    }

    /// Encodes a message, which is a JSON object.
    #[pyfunction]
    fn encode(name: &str, message: &str) -> PyResult<String> {
        let message = serde_json::from_str(message).map_err(|error| SpiError::new_err(error.to_string()))?;
        crate::encode(name, &message).map_err(raised)
    }

    /// The messages of the interface; returns a JSON array.
    #[pyfunction]
    fn catalogue(names: Vec<String>) -> PyResult<String> {
        json(&crate::catalogue(&names).map_err(raised)?)
    }

    fn json(value: &impl serde::Serialize) -> PyResult<String> {
        serde_json::to_string(value).map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))
    }

    /// The exception of an error.
    fn raised(error: Error) -> PyErr {
        let text = error.to_string();
        if error.is_of_mission() {
            return MissionError::new_err(text);
        }
        match error {
            Error::Log(
                backseat_log_export::Error::Read { source, .. } | backseat_log_export::Error::Write { source, .. },
            ) if source.kind() == std::io::ErrorKind::NotFound => pyo3::exceptions::PyFileNotFoundError::new_err(text),
            Error::Log(backseat_log_export::Error::Read { .. } | backseat_log_export::Error::Write { .. })
            | Error::Recorder(_) => pyo3::exceptions::PyOSError::new_err(text),
            Error::Log(_) => LogError::new_err(text),
            Error::Spi(_) => SpiError::new_err(text),
            Error::Mission(_)
            | Error::Faults(_)
            | Error::Campaign(_)
            | Error::Report(_)
            | Error::Scenario(_)
            | Error::Plugin(_)
            | Error::Simulation(_)
            | Error::Host(_)
            | Error::Interrupted => pyo3::exceptions::PyRuntimeError::new_err(text),
        }
    }
}
