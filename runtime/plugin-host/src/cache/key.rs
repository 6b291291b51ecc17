use std::hash::{Hash, Hasher};

use wasmtime::Engine;

/// The version of the file that [`super::entry`] describes. A new one leaves the files of the old one unread.
pub(super) const VERSION: u32 = 2;

/// A BLAKE3. It is as strong as SHA-256 and several times as fast, and most of the time of loading a plugin in Python is hashing.
pub(super) type Hash256 = [u8; 32];

/// What a compiled component depends on: the component, and the engine that compiles and runs it.
///
/// The engine's part covers its version to the last digit, the processor with its extensions, the compiler's settings
/// (fuel and its costs, epochs, NaN, stack checks, inlining) and the proposals that are turned on. The engine itself,
/// when it loads a file, compares of its version only the first number; so a release that corrects its compiler would
/// load what the incorrect one has compiled. This key does not.
#[derive(Clone)]
pub(crate) struct Key {
    pub(super) engine: Engine,
    pub(super) component: Hash256,
    pub(super) settings: Hash256,
}

impl Key {
    /// The key of a component, in bytes, on this engine.
    pub(crate) fn new(engine: &Engine, bytes: &[u8]) -> Self {
        let mut settings = Settings(blake3::Hasher::new());
        engine.precompile_compatibility_hash().hash(&mut settings);
        Self {
            engine: engine.clone(),
            component: blake3::hash(bytes).into(),
            settings: settings.0.finalize().into(),
        }
    }

    /// The name of its file: `backseat-`, the component's BLAKE3 as `b3sum` prints it, the beginning of the engine's, and
    /// the version of the format.
    pub(super) fn file_name(&self) -> String {
        format!(
            "backseat-{}-{}.v{VERSION}",
            hex(&self.component),
            hex(&self.settings[..8])
        )
    }
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Hashes what the engine says of itself with BLAKE3, which is the same in each process.
struct Settings(blake3::Hasher);

impl Hasher for Settings {
    fn write(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    fn finish(&self) -> u64 {
        let whole: Hash256 = self.0.finalize().into();
        whole.iter().take(8).fold(0, |sum, byte| sum << 8 | u64::from(*byte))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wasmtime::{Config, OptLevel};

    fn of(config: &Config, bytes: &[u8]) -> String {
        Key::new(&Engine::new(config).unwrap(), bytes).file_name()
    }

    #[test]
    fn a_key_changes_with_the_component_and_with_the_engines_settings() {
        let plain = of(&Config::new(), b"one");
        assert_eq!(plain, of(&Config::new(), b"one"));
        assert_ne!(plain, of(&Config::new(), b"two"));
        let mut settings = [const { None }; 4];
        settings[0] = Some(Config::new().consume_fuel(true).clone());
        settings[1] = Some(Config::new().epoch_interruption(true).clone());
        settings[2] = Some(Config::new().cranelift_opt_level(OptLevel::None).clone());
        settings[3] = Some(Config::new().cranelift_nan_canonicalization(true).clone());
        for config in settings.iter().flatten() {
            assert_ne!(plain, of(config, b"one"));
        }
    }

    #[test]
    fn a_file_begins_with_what_b3sum_prints() {
        let name = of(&Config::new(), b"");
        let empty = "backseat-af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262-";
        assert!(name.starts_with(empty) && name.ends_with(".v2"), "{name}");
        assert_eq!(name.len(), empty.len() + 16 + 3);
    }
}
