use std::path::PathBuf;
use std::process::ExitStatus;

/// Why a component was not built.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A core module that is no plugin.
    #[error("the module cannot be made a component: {0}")]
    Encode(String),
    /// The Rust toolchain cannot compile for WebAssembly.
    #[error("the target wasm32-unknown-unknown is not installed: run `rustup target add wasm32-unknown-unknown`")]
    TargetMissing,
    /// A tool could not be run.
    #[error("{tool} cannot be run: {source}")]
    Tool {
        /// `cargo` or `rustc`.
        tool: String,
        /// Why not.
        source: std::io::Error,
    },
    /// A tool ran and failed; it has written why to standard error.
    #[error("{tool} failed in {directory}: {status}")]
    Failed {
        /// `cargo build`, `cargo metadata` or `rustc`.
        tool: &'static str,
        /// Where it was run.
        directory: PathBuf,
        /// How it ended.
        status: ExitStatus,
    },
    /// A package without a module.
    #[error("package {0} has no module: its Cargo.toml needs `crate-type = [\"cdylib\", \"rlib\"]` under [lib]")]
    NoModule(String),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}
