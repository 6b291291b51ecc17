use std::sync::{Arc, mpsc};
use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::{Description, Judge};
use wasmtime::component::Linker;
use wasmtime::{Config, Engine, OperatorCost, VariableOperatorCost};

use crate::cache::{Cache, Key};
use crate::error::{HostError, one_line};
use crate::instance::State;
use crate::interface::{Interface, Linked};
use crate::plugin::{Plugin, Started};
use crate::{Brief, Budget, inspection, interface};

/// The largest component that is loaded by default, bytes. An interpreter with its library fits.
pub const COMPONENT_BYTES: usize = 32 << 20;
/// How long a component may take to compile by default. Components are compiled ashore, once, and then kept in a
/// [`Cache`]; one that takes longer was probably built to do so.
pub const COMPILE_TIME: Duration = Duration::from_secs(120);

/// How long a compilation may take before the host says that it is at it: see [`Host::with_notice`].
const SILENT: Duration = Duration::from_secs(5);

/// A plugin's stack, bytes. An overflow is a trap.
const STACK_BYTES: usize = 512 << 10;

/// Loads components. A clone is another handle to the same host, for example for a watchdog's thread.
#[derive(Clone)]
pub struct Host {
    engine: Engine,
    linker: Arc<Linker<State>>,
    cache: Option<Cache>,
    notice: Option<Arc<dyn Fn(String) + Send + Sync>>,
}

/// Where the code of a component comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// This process has compiled it.
    Compiled,
    /// An earlier process has, and this one has loaded it from the [`Cache`].
    Cache,
}

/// A compiled component that is known to be a plugin. A clone shares the code.
#[derive(Clone)]
pub struct Component {
    inner: Arc<Inner>,
}

struct Inner {
    name: String,
    engine: Engine,
    origin: Origin,
    plugin: Linked,
}

impl Host {
    /// Creates an engine with settings under which a plugin runs the same on every machine.
    ///
    /// # Errors
    ///
    /// [`HostError::Engine`] if this machine cannot run WebAssembly.
    pub fn new() -> Result<Self, HostError> {
        let engine_error = |error: wasmtime::Error| HostError::Engine(one_line(&error));
        let engine = Engine::new(&config()).map_err(engine_error)?;
        let mut linker = Linker::new(&engine);
        interface::link(&mut linker).map_err(engine_error)?;
        Ok(Self {
            engine,
            linker: Arc::new(linker),
            cache: None,
            notice: None,
        })
    }

    /// Calls this with one line, from the thread that loads a component, when its compilation has taken 5 s and goes on:
    /// one in Python takes half a minute, in which a user would otherwise see nothing.
    #[must_use]
    pub fn with_notice(mut self, notice: impl Fn(String) + Send + Sync + 'static) -> Self {
        self.notice = Some(Arc::new(notice));
        self
    }

    /// Loads components from this cache where it has them, and keeps in it what it compiles. A component behaves the
    /// same either way.
    #[must_use]
    pub fn with_cache(mut self, cache: Option<Cache>) -> Self {
        self.cache = cache;
        self
    }

    /// The cache of compiled components, if it has one.
    #[must_use]
    pub fn cache(&self) -> Option<&Cache> {
        self.cache.as_ref()
    }

    /// Like [`Host::load_within`], with the default bounds [`COMPONENT_BYTES`] and [`COMPILE_TIME`].
    ///
    /// # Errors
    ///
    /// A [`HostError`] that explains in one line why the bytes are not a plugin.
    pub fn load(&self, name: &str, bytes: &[u8]) -> Result<Component, HostError> {
        self.load_within(name, bytes, COMPONENT_BYTES, COMPILE_TIME)
    }

    /// Checks and compiles a component, within a largest size and a longest time, or loads it from the cache. `name` is
    /// used in messages only.
    ///
    /// # Errors
    ///
    /// A [`HostError`] that explains in one line why the bytes are not a plugin, or which bound they break. A
    /// compilation that takes too long continues in its thread until it ends, because it cannot be stopped.
    pub fn load_within(
        &self,
        name: &str,
        bytes: &[u8],
        bytes_max: usize,
        time_max: Duration,
    ) -> Result<Component, HostError> {
        let plugin = || name.to_owned();
        inspection::check_form(name, bytes, bytes_max)?;
        let cached = self.cache.as_ref().map(|cache| (cache, Key::new(&self.engine, bytes)));
        let found = cached.as_ref().and_then(|(cache, key)| cache.find(name, key));
        let (component, origin) = match found {
            Some(component) => (component, Origin::Cache),
            None => (self.compile_within(name, bytes, time_max)?, Origin::Compiled),
        };
        let interface = inspection::require_plugin(&self.engine, name, &component)?;
        let mismatch = |error: wasmtime::Error| HostError::Interface {
            plugin: plugin(),
            interface: interface.name(),
            reason: one_line(&error),
        };
        let linked = self.linker.instantiate_pre(&component).map_err(mismatch)?;
        let linked = Linked::new(interface, linked).map_err(mismatch)?;
        // Only plugins are kept.
        if let Some((cache, key)) = cached.filter(|_| origin == Origin::Compiled) {
            cache.keep(&key, &component);
        }
        Ok(Component {
            inner: Arc::new(Inner {
                name: plugin(),
                engine: self.engine.clone(),
                origin,
                plugin: linked,
            }),
        })
    }

    fn compile_within(
        &self,
        name: &str,
        bytes: &[u8],
        time_max: Duration,
    ) -> Result<wasmtime::component::Component, HostError> {
        let (done, compiled) = mpsc::channel();
        let size_mb = bytes.len() as f64 / 1e6;
        let (engine, thread_name, bytes) = (self.engine.clone(), name.to_owned(), bytes.to_vec());
        std::thread::spawn(move || {
            // The receiver is gone if the compilation took too long.
            let _ = done.send(inspection::compile(&engine, &thread_name, &bytes));
        });
        let waited = wait(&compiled, time_max, SILENT, || {
            if let Some(notice) = &self.notice {
                notice(self.is_compiling(name, size_mb));
            }
        });
        match waited {
            Ok(compiled) => compiled,
            Err(mpsc::RecvTimeoutError::Timeout) => Err(HostError::TooSlow {
                plugin: name.to_owned(),
                seconds: time_max.as_secs(),
            }),
            Err(mpsc::RecvTimeoutError::Disconnected) => Err(HostError::Invalid {
                plugin: name.to_owned(),
                reason: "the compiler panicked".to_owned(),
            }),
        }
    }

    fn is_compiling(&self, name: &str, size_mb: f64) -> String {
        let next = match &self.cache {
            Some(cache) if cache.is_in_use() => "the next start takes it from the cache",
            Some(_) => "each start compiles it, because there is no cache",
            None => "neither taken from a cache nor kept in one",
        };
        format!("plugin `{name}`: compiling its {size_mb:.1} MB of WebAssembly, which may take a minute; {next}")
    }

    /// Advances the epoch by one tick, for plugins with [`Plugin::set_deadline_ticks`]. A deployed runtime's watchdog
    /// calls this from a thread of its own; a simulation never does.
    pub fn increment_epoch(&self) {
        self.engine.increment_epoch();
    }
}

impl Component {
    /// The name under which it was loaded.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Where its code comes from.
    #[must_use]
    pub fn origin(&self) -> Origin {
        self.inner.origin
    }

    /// The version of the interface that it was made for.
    #[must_use]
    pub fn interface(&self) -> Interface {
        self.inner.plugin.interface()
    }

    /// Starts a plugin: creates an instance and calls `describe` and `init`.
    ///
    /// # Errors
    ///
    /// [`HostError::Start`] if `describe` or `init` fails or exceeds its bounds, [`HostError::Description`] if the
    /// description does, [`HostError::Grants`] if the plugin needs a grant that the brief does not have,
    /// [`HostError::Interface`] if its functions have other types.
    pub fn start(&self, budget: Budget, brief: &Brief<'_>, judge: Arc<dyn Judge>) -> Result<Started, HostError> {
        Plugin::start(self.clone(), budget, brief, judge)
    }

    /// What the plugin says about itself, and the grants that it needs, without starting it: that takes no mission.
    ///
    /// # Errors
    ///
    /// As [`Component::start`], of `describe` alone.
    pub fn describe(&self, budget: &Budget) -> Result<(Description, Vec<Grant>), HostError> {
        Plugin::describe(self, budget)
    }

    pub(crate) fn engine(&self) -> &Engine {
        &self.inner.engine
    }

    pub(crate) fn linked(&self) -> &Linked {
        &self.inner.plugin
    }
}

/// Waits at most `time_max` for a result, and calls this once when `silent` has passed without one.
fn wait<T>(
    result: &mpsc::Receiver<T>,
    time_max: Duration,
    silent: Duration,
    is_slow: impl FnOnce(),
) -> Result<T, mpsc::RecvTimeoutError> {
    match result.recv_timeout(time_max.min(silent)) {
        Err(mpsc::RecvTimeoutError::Timeout) if time_max > silent => {
            is_slow();
            result.recv_timeout(time_max - silent)
        }
        waited => waited,
    }
}

fn config() -> Config {
    let mut config = Config::new();
    config.wasm_component_model(true).concurrency_support(false);
    config
        .consume_fuel(true)
        .epoch_interruption(true)
        .operator_cost(operator_cost());
    // The bits of a NaN differ between processors, and so do the results of relaxed instructions.
    config
        .cranelift_nan_canonicalization(true)
        .relaxed_simd_deterministic(true)
        .wasm_relaxed_simd(false);
    config
        .wasm_memory64(false)
        .wasm_multi_memory(false)
        .wasm_custom_page_sizes(false)
        .wasm_wide_arithmetic(false);
    config.shared_memory(false).max_wasm_stack(STACK_BYTES);
    // A fault is reported in one line, and release builds have no names for a backtrace to show.
    config.wasm_backtrace_max_frames(None).generate_address_map(false);
    config
}

/// Growing memory is charged much fuel, because each attempt calls the operating system, even one that is refused. A
/// plugin must not spend a second of the host's time on a millisecond's worth of fuel. Bulk operations already cost one
/// unit for each byte.
fn operator_cost() -> OperatorCost {
    OperatorCost {
        MemoryGrow: u8::MAX,
        TableGrow: u8::MAX,
        variable: VariableOperatorCost {
            memory_grow_per_page: u8::MAX,
            ..VariableOperatorCost::new()
        },
        ..OperatorCost::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What comes of waiting at most this long for a result, and whether it was called slow.
    fn waited(result: &mpsc::Receiver<u8>, time_max: Duration) -> (Result<u8, mpsc::RecvTimeoutError>, bool) {
        let mut slow = false;
        let waited = wait(result, time_max, Duration::from_millis(5), || slow = true);
        (waited, slow)
    }

    #[test]
    fn a_long_compilation_is_told_once_and_a_short_one_is_not() {
        let second = Duration::from_secs(1);
        let (done, compiled) = mpsc::channel();
        done.send(7).unwrap();
        assert_eq!(waited(&compiled, second), (Ok(7), false));
        let at_it = std::thread::spawn(move || {
            // Nobody sends there: it waits for the time alone.
            let (_silent, nothing) = mpsc::channel::<()>();
            let _timeout = nothing.recv_timeout(Duration::from_millis(100));
            done.send(8)
        });
        assert_eq!(waited(&compiled, 60 * second), (Ok(8), true));
        at_it.join().unwrap().unwrap();
        let timeout = Err(mpsc::RecvTimeoutError::Timeout);
        let (_pending, compiled) = mpsc::channel();
        assert_eq!(waited(&compiled, Duration::from_millis(1)), (timeout, false));
        assert_eq!(waited(&compiled, Duration::from_millis(10)), (timeout, true));
    }

    #[test]
    fn the_notice_says_what_takes_so_long_and_whether_it_will_again() {
        let host = Host::new().unwrap();
        let alone = host.is_compiling("front", 18.13);
        assert_eq!(
            alone,
            "plugin `front`: compiling its 18.1 MB of WebAssembly, which may take a minute; neither taken from a cache \
             nor kept in one"
        );
        let cached = host.with_cache(Some(Cache::new("/var/cache/backseat", |_| {})));
        assert!(
            cached
                .is_compiling("front", 18.13)
                .ends_with("the next start takes it from the cache")
        );
    }
}
