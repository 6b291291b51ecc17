//! Builds a plugin's crate into a WebAssembly component.
//!
//! A Rust plugin is compiled for `wasm32-unknown-unknown`, so that its module imports only what the WIT world names (no
//! WASI). This crate wraps the module into a component, with the same encoder as the host's wasmtime. The same source
//! gives the same bytes: the profile is fixed, and the artefact contains no path of the machine.

mod build;
mod error;

pub use build::{TARGET, build, plugins};
pub use error::Error;

use wit_component::ComponentEncoder;

/// Wraps a core module with `wit-bindgen`'s metadata into a component.
///
/// # Errors
///
/// [`Error::Encode`] if the bytes are not a core module, have no metadata, or have imports and exports other than those
/// of the world in the metadata.
pub fn componentize(core_module: &[u8]) -> Result<Vec<u8>, Error> {
    ComponentEncoder::default()
        .validate(true)
        .module(core_module)
        .and_then(|mut encoder| encoder.encode())
        // The alternate format of anyhow's errors has the whole chain in one line.
        .map_err(|error| Error::Encode(format!("{error:#}").replace('\n', " ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_module_is_refused_in_one_line() {
        for bytes in [&b""[..], b"hello", b"\0asm", b"\0asm\x0d\0\x01\0"] {
            let error = componentize(bytes).unwrap_err().to_string();
            assert!(
                error.starts_with("the module cannot be made a component: ") && error.lines().count() == 1,
                "{error}"
            );
        }
    }
}
