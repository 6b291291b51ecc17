use std::path::PathBuf;
use std::process::ExitStatus;

/// Why a component was not built.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A core module is not a plugin.
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
        /// The reason.
        source: std::io::Error,
    },
    /// A tool ran and failed; its message is on standard error.
    #[error("{directory}: {tool} failed ({status}): its lines above say why")]
    Failed {
        /// `cargo build`, `cargo metadata` or `rustc`.
        tool: &'static str,
        /// The folder in which it was run.
        directory: PathBuf,
        /// How it ended.
        status: ExitStatus,
    },
    /// A package has no module.
    #[error("package {0} has no module: its Cargo.toml needs `crate-type = [\"cdylib\", \"rlib\"]` under [lib]")]
    NoModule(String),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
}
