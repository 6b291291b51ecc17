use wasmtime::Engine;
use wasmtime::component::Component;
use wasmtime::component::types::ComponentItem;

use crate::error::{HostError, one_line};
use crate::interface::{EXPORTS, IMPORTS_TEXT, Interface};

/// Refuses bytes that are not a component, or are too many, by their first bytes alone.
///
/// # Errors
///
/// [`HostError::Empty`], [`HostError::TooLarge`], [`HostError::NotWasm`] or [`HostError::CoreModule`].
pub fn check_form(name: &str, bytes: &[u8], bytes_max: usize) -> Result<(), HostError> {
    /// The magic number, version and layer of a core module.
    const CORE: &[u8] = b"\0asm\x01\0\0\0";
    let plugin = || name.to_owned();
    if bytes.is_empty() {
        return Err(HostError::Empty { plugin: plugin() });
    }
    if bytes.len() > bytes_max {
        return Err(HostError::TooLarge {
            plugin: plugin(),
            bytes: bytes.len(),
            bytes_max,
        });
    }
    if !bytes.starts_with(&CORE[..4]) {
        return Err(HostError::NotWasm { plugin: plugin() });
    }
    if bytes.starts_with(CORE) {
        return Err(HostError::CoreModule { plugin: plugin() });
    }
    Ok(())
}

/// Compiles a component.
pub(crate) fn compile(engine: &Engine, name: &str, bytes: &[u8]) -> Result<Component, HostError> {
    Component::new(engine, bytes).map_err(|error| HostError::Invalid {
        plugin: name.to_owned(),
        reason: one_line(&error),
    })
}

/// Checks that a component imports no more and exports no less than a plugin of one version of the interface does, and
/// returns the version. A component without imports counts as one of the newest.
pub(crate) fn require_plugin(engine: &Engine, name: &str, component: &Component) -> Result<Interface, HostError> {
    let ty = component.component_type();
    let mut found: Option<Interface> = None;
    for (import, _) in ty.imports(engine) {
        let interface =
            Interface::of_import(import).filter(|interface| found.is_none_or(|before| before == *interface));
        if interface.is_none() {
            let (plugin, import) = (name.to_owned(), import.to_owned());
            return Err(HostError::Import {
                plugin,
                import,
                allowed: IMPORTS_TEXT,
            });
        }
        found = interface;
    }
    let missing: Vec<&str> = EXPORTS
        .into_iter()
        .filter(|function| {
            !ty.get_export(engine, function)
                .is_some_and(|export| matches!(export.ty, ComponentItem::ComponentFunc(_)))
        })
        .collect();
    if missing.is_empty() {
        Ok(found.unwrap_or(Interface::V0_2_0))
    } else {
        Err(HostError::Exports {
            plugin: name.to_owned(),
            missing: missing.join(", "),
        })
    }
}
