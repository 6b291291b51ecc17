//! Builds a plugin's crate into a WebAssembly component.
//!
//! A Rust plugin is compiled for `wasm32-unknown-unknown`, whose modules import nothing but what the WIT world names
//! (no WASI), and wrapped into a component here, with the encoder that the host's wasmtime itself is built with. The
//! same source gives the same bytes: the profile is fixed, and no path of the machine is in the artefact.

mod build;
mod error;

pub use build::{TARGET, build, plugins};
pub use error::Error;

use wit_component::ComponentEncoder;

/// Wraps a core module with `wit-bindgen`'s metadata into a component.
///
/// # Errors
/// [`Error::Encode`] where the bytes are no core module, have no metadata, or their imports and exports are not those of
/// the world that the metadata describes.
pub fn componentize(core_module: &[u8]) -> Result<Vec<u8>, Error> {
    ComponentEncoder::default()
        .validate(true)
        .module(core_module)
        .and_then(|mut encoder| encoder.encode())
        // The alternate form of anyhow's errors is the whole chain in one line.
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
