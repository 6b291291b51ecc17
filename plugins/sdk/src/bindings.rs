//! The code that `wit-bindgen` generates from the WIT world: the types, the imports, and the export macro that
//! [`crate::export!`] wraps. Plugins use the re-exports at the crate's root instead.

#![allow(
    missing_docs,
    unreachable_pub,
    reason = "generated: the WIT file's own comments are its documentation"
)]
#![allow(
    unsafe_code,
    reason = "generated: the canonical ABI passes raw pointers between guest and host"
)]
#![allow(clippy::all, clippy::wildcard_enum_match_arm, reason = "generated")]

wit_bindgen::generate!({
    path: "../../wit/v0.2.0",
    world: "plugin",
    pub_export_macro: true,
    export_macro_name: "export_component",
    default_bindings_module: "backseat_sdk::bindings",
    additional_derives: [PartialEq],
});
