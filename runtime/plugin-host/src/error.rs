use backseat_core::Grant;
use backseat_core::plugin::PluginFault;

/// Why a plugin cannot be loaded or started. `plugin` is the name that the caller gave it.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// WebAssembly cannot run on this machine.
    #[error("the WebAssembly engine cannot be set up: {0}")]
    Engine(String),
    /// The file is empty.
    #[error("{plugin}: the file is empty, expected a WebAssembly component")]
    Empty {
        /// The plugin.
        plugin: String,
    },
    /// The file is not WebAssembly.
    #[error("{plugin}: not WebAssembly (it does not begin with `\\0asm`), expected a component")]
    NotWasm {
        /// The plugin.
        plugin: String,
    },
    /// The file is a core module: the output of a compiler, which has yet to be made a component.
    #[error(
        "{plugin}: a core module, expected a component: `backseat plugin build` or `wasm-tools component new` makes one"
    )]
    CoreModule {
        /// The plugin.
        plugin: String,
    },
    /// The component is too large.
    #[error("{plugin}: {bytes} bytes, expected at most {bytes_max}")]
    TooLarge {
        /// The plugin.
        plugin: String,
        /// Its size.
        bytes: usize,
        /// The largest size allowed.
        bytes_max: usize,
    },
    /// The component took too long to compile.
    #[error(
        "{plugin}: took longer than {seconds} s to compile: try again when this computer has less to do; what is compiled once is kept"
    )]
    TooSlow {
        /// The plugin.
        plugin: String,
        /// The longest time allowed.
        seconds: u64,
    },
    /// The component is truncated, damaged, or uses WebAssembly proposals that are turned off here.
    #[error("{plugin}: not a valid component: {reason}")]
    Invalid {
        /// The plugin.
        plugin: String,
        /// The validator's message.
        reason: String,
    },
    /// The component imports something that no plugin is given.
    #[error("{plugin}: imports {import}, but a plugin may import only {allowed}")]
    Import {
        /// The plugin.
        plugin: String,
        /// The import.
        import: String,
        /// The imports that are allowed.
        allowed: &'static str,
    },
    /// The component lacks exports of a plugin.
    #[error("{plugin}: does not export {missing}: expected a plugin (in Rust, `backseat_sdk::export!(TYPE)` once)")]
    Exports {
        /// The plugin.
        plugin: String,
        /// The missing exports, separated by commas.
        missing: String,
    },
    /// The imports or exports have other types than this version of the interface.
    #[error("{plugin}: does not match the interface {interface}: {reason}")]
    Interface {
        /// The plugin.
        plugin: String,
        /// The version of the interface that the host provides.
        interface: &'static str,
        /// The difference.
        reason: String,
    },
    /// The plugin's description is out of bounds.
    #[error("{plugin}: describes itself with {what}, expected {expected}")]
    Description {
        /// The plugin.
        plugin: String,
        /// The value in the description.
        what: String,
        /// The values that are allowed.
        expected: &'static str,
    },
    /// The mission does not grant what the plugin needs.
    #[error("{plugin}: needs {}: add {} to `grants` of this plugin in mission.toml", grants(missing), if missing.len() == 1 { "it" } else { "them" })]
    Grants {
        /// The plugin.
        plugin: String,
        /// The missing grants.
        missing: Vec<Grant>,
    },
    /// The plugin failed in `describe` or `init`.
    #[error("{plugin}: cannot be started: {}", fault.text)]
    Start {
        /// The plugin.
        plugin: String,
        /// The fault.
        fault: PluginFault,
    },
}

impl HostError {
    /// The reason without the plugin's name, for messages that name it already.
    #[must_use]
    pub fn reason(&self) -> String {
        let text = self.to_string();
        let plugin = match self {
            Self::Engine(_) => return text,
            Self::Empty { plugin }
            | Self::NotWasm { plugin }
            | Self::CoreModule { plugin }
            | Self::TooLarge { plugin, .. }
            | Self::TooSlow { plugin, .. }
            | Self::Invalid { plugin, .. }
            | Self::Import { plugin, .. }
            | Self::Exports { plugin, .. }
            | Self::Interface { plugin, .. }
            | Self::Description { plugin, .. }
            | Self::Grants { plugin, .. }
            | Self::Start { plugin, .. } => plugin,
        };
        let without = text
            .strip_prefix(plugin.as_str())
            .and_then(|rest| rest.strip_prefix(": "));
        without.unwrap_or(&text).to_owned()
    }
}

/// The grants as a text.
fn grants(grants: &[Grant]) -> String {
    let names: Vec<&str> = grants.iter().map(|grant| grant.name()).collect();
    format!(
        "the grant{} {}",
        if names.len() == 1 { "" } else { "s" },
        names.join(", ")
    )
}

/// An engine's error in one line: wasmtime puts its chain of causes on several.
pub(crate) fn one_line(error: &wasmtime::Error) -> String {
    format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ")
}
