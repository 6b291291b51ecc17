use backseat_core::plugin::PluginFault;

/// Why a plugin cannot be loaded or started. `plugin` is the name that the caller gave it.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// WebAssembly cannot be run on this machine.
    #[error("the WebAssembly engine cannot be set up: {0}")]
    Engine(String),
    /// A file of no bytes.
    #[error("{plugin}: the file is empty, expected a WebAssembly component")]
    Empty {
        /// Which.
        plugin: String,
    },
    /// Not WebAssembly at all.
    #[error("{plugin}: not WebAssembly (it does not begin with `\\0asm`), expected a component")]
    NotWasm {
        /// Which.
        plugin: String,
    },
    /// What a compiler makes, before it is a component.
    #[error("{plugin}: a core module, expected a component: `cargo xtask plugins` makes one of each plugin")]
    CoreModule {
        /// Which.
        plugin: String,
    },
    /// Over the cap on the size of a component.
    #[error("{plugin}: {bytes} bytes, expected at most {bytes_max}")]
    TooLarge {
        /// Which.
        plugin: String,
        /// Its size.
        bytes: usize,
        /// The most that it may have.
        bytes_max: usize,
    },
    /// It took too long to be compiled.
    #[error("{plugin}: not compiled after {seconds} s: a component that takes so long is refused")]
    TooSlow {
        /// Which.
        plugin: String,
        /// How long it may take.
        seconds: u64,
    },
    /// Truncated, damaged, or made of WebAssembly proposals that are off here.
    #[error("{plugin}: not a valid component: {reason}")]
    Invalid {
        /// Which.
        plugin: String,
        /// What the validator says.
        reason: String,
    },
    /// It wants what no plugin gets.
    #[error("{plugin}: imports {import}, but a plugin may import only {allowed}")]
    Import {
        /// Which.
        plugin: String,
        /// The import.
        import: String,
        /// What there is.
        allowed: &'static str,
    },
    /// It is a component, but no plugin.
    #[error("{plugin}: does not export {missing}, expected describe, init, step, snapshot and restore")]
    Exports {
        /// Which.
        plugin: String,
        /// What is missing, separated by commas.
        missing: String,
    },
    /// Its imports or exports have other types than this version of the interface.
    #[error("{plugin}: not of the interface {interface}: {reason}")]
    Interface {
        /// Which.
        plugin: String,
        /// The version of the interface that the host speaks.
        interface: &'static str,
        /// What differs.
        reason: String,
    },
    /// What it says of itself is out of bounds.
    #[error("{plugin}: describes itself with {what}, expected {expected}")]
    Description {
        /// Which.
        plugin: String,
        /// What it says.
        what: String,
        /// What it may say.
        expected: &'static str,
    },
    /// It failed in `describe` or `init`.
    #[error("{plugin}: cannot be started: {}", fault.text)]
    Start {
        /// Which.
        plugin: String,
        /// How it failed.
        fault: PluginFault,
    },
}

/// An engine's error as one line: wasmtime spreads its chain of causes over many.
pub(crate) fn one_line(error: &wasmtime::Error) -> String {
    format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ")
}
