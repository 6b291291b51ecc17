//! The files of a new plugin: those of `plugins/template` or `plugins/python/template`, and of `missions/template`, with
//! its name.

use super::Language;
use crate::kit::{Content, Kit};

/// The files with their paths.
pub(super) fn files(name: &str, language: Language, kit: &Kit) -> Vec<(String, String)> {
    let content = Content::embedded();
    let own = |files: &[(&str, String)]| -> Vec<(String, String)> {
        let files = files.iter();
        files.map(|(path, text)| ((*path).to_owned(), text.clone())).collect()
    };
    let mut files = own(&[
        ("README.md", readme(name, language)),
        ("mission/mission.toml", mission(name, content)),
    ]);
    match language {
        Language::Rust => {
            files.extend(own(&[
                ("Cargo.toml", manifest(name, kit)),
                ("Cargo.lock", content.lock().of_plugin(name)),
                (".gitignore", ignored("/target")),
                ("rustfmt.toml", RUSTFMT.to_owned()),
            ]));
            for (path, _) in content.files() {
                let source = path.strip_prefix("plugins/template/");
                if let Some(source) = source.filter(|path| path.starts_with("src/")) {
                    files.push((source.to_owned(), content.text(path).to_owned()));
                }
            }
        }
        Language::Python => {
            files.extend(own(&[
                ("pyproject.toml", python_manifest(name, kit)),
                (".gitignore", ignored("__pycache__/")),
            ]));
            for (path, _) in content.files() {
                if let Some(source) = path.strip_prefix("plugins/python/template/") {
                    files.push((source.to_owned(), python_source(name, content.text(path))));
                }
            }
        }
    }
    for file in ["fence.geojson", "world.toml"] {
        let text = content.text(&format!("missions/template/{file}"));
        files.push((format!("mission/{file}"), without_schema(text)));
    }
    files
}

/// How the sources of the template are formatted.
const RUSTFMT: &str = "max_width = 120\nuse_field_init_shorthand = true\n";

fn ignored(made: &str) -> String {
    format!("{made}\n# What `backseat plugin build` makes.\n/*.wasm\n")
}

/// A source of the template with the plugin's name, and with the commands that its author has.
fn python_source(name: &str, text: &str) -> String {
    let mut text = text.to_owned();
    for (from, to) in python_replacements(name) {
        text = text.replace(from, &to);
    }
    text
}

fn python_replacements(name: &str) -> [(&'static str, String); 2] {
    [
        (
            "A template for new plugins. It keeps a heading, a depth and a speed while the backseat has control.

Copy this folder, change the name in ``describe``, and change ``step``. ``python -m pytest`` runs the tests on this
computer; ``python -m backseat_sdk.build`` makes the component for the runtime.
",
            "It keeps a heading, a depth and a speed while the backseat has control.

Change ``step``. ``backseat plugin test`` runs the tests on this computer, builds the component, and flies it.
"
            .to_owned(),
        ),
        ("Description(\"template\"", format!("Description(\"{name}\"")),
    ]
}

fn python_manifest(name: &str, kit: &Kit) -> String {
    let sdk = toml::Value::from(kit.python_sdk().display().to_string());
    format!(
        r#"[project]
name = "{name}"
version = "0.1.0"
requires-python = ">=3.11"

[tool.pytest.ini_options]
# The SDK that the program `backseat` has unpacked; for an editor too.
pythonpath = [".", {sdk}]
# A test that takes longer than this, seconds, has an endless loop: pytest says where, and goes on waiting.
faulthandler_timeout = 60
"#
    )
}

fn manifest(name: &str, kit: &Kit) -> String {
    let sdk = toml::Value::from(kit.sdk().display().to_string());
    format!(
        r#"[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
publish = false

[lib]
# cdylib is the WebAssembly module, rlib is for unit tests on this computer.
crate-type = ["cdylib", "rlib"]

[dependencies]
# The SDK that the program `backseat` has unpacked.
backseat-sdk = {{ path = {sdk} }}
serde = {{ version = "1", features = ["derive"] }}

# This folder is a workspace of its own, also if it is inside another one.
[workspace]
"#
    )
}

fn readme(name: &str, language: Language) -> String {
    let source = match language {
        Language::Rust => "src/lib.rs",
        Language::Python => "plugin.py",
    };
    format!(
        "# {name}

A plugin for Backseat, which steers a Bluefin vehicle inside a geofence.

```sh
backseat plugin test     # unit tests, build, and five simulated flights
backseat plugin build    # makes {name}.wasm, the component that goes to sea
backseat plugin check    # the report that an operator signs off
backseat sim mission --map map.svg
```

All of the behavior is in `step` in `{source}`. `mission` is the mission of the test flights: `mission.toml` has the
limits, and what the plugin may ask for (its *grants*); `fence.geojson` says where the vehicle may be; `world.toml` is
the simulation, and what it must fulfil. `backseat explain KEY` explains each key.
"
    )
}

/// The mission with the plugin's name and component.
fn mission(name: &str, content: &Content) -> String {
    let mut text = without_schema(content.text("missions/template/mission.toml"));
    for (from, to) in replacements(name) {
        text = text.replace(from, &to);
    }
    text
}

/// What differs in a new plugin's mission from `missions/template`.
fn replacements(name: &str) -> [(&'static str, String); 3] {
    [
        (
            "The start of a new mission: one plugin that holds a heading on one leg of the vehicle's plan. Copy this folder.",
            "The mission in which `backseat plugin test` flies this plugin, on one leg of the vehicle's plan."
                .to_owned(),
        ),
        (r#"name = "template""#, format!("name = \"{name}\"")),
        (r#"component = "template""#, format!("component = \"../{name}.wasm\"")),
    ]
}

/// Without the line that names a schema beside this repository's missions.
fn without_schema(text: &str) -> String {
    let lines = text.split_inclusive('\n').filter(|line| !line.starts_with("#:schema"));
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_that_names_the_template_names_the_plugin() {
        let content = Content::embedded();
        let original = content.text("missions/template/mission.toml");
        for (from, _) in replacements("drift") {
            assert_eq!(
                original.matches(from).count(),
                1,
                "missions/template/mission.toml: {from}"
            );
        }
        let place = tempfile::tempdir().unwrap();
        let kit = Kit::ready_in(place.path()).unwrap();
        for language in [Language::Rust, Language::Python] {
            for (from, _) in python_replacements("drift") {
                let original = content.text("plugins/python/template/plugin.py");
                assert_eq!(
                    original.matches(from).count(),
                    1,
                    "plugins/python/template/plugin.py: {from}"
                );
            }
            named(files("drift", language, &kit));
        }
    }

    fn named(files: Vec<(String, String)>) {
        for (path, text) in files {
            assert!(
                !text.contains("\"template\"") && !text.contains("#:schema"),
                "{path}:\n{text}"
            );
            assert!(
                !text.contains("xtask"),
                "{path}: the author has no cargo xtask:\n{text}"
            );
        }
    }
}
