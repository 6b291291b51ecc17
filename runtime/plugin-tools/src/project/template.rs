//! The files of a new plugin: those of `plugins/template` and `missions/template`, with its name.

use crate::kit::{Content, Kit};

/// The files with their paths.
pub(super) fn files(name: &str, kit: &Kit) -> Vec<(String, String)> {
    let content = Content::embedded();
    let mut files: Vec<(String, String)> = [
        ("Cargo.toml", manifest(name, kit)),
        ("Cargo.lock", content.lock().of_plugin(name)),
        (
            ".gitignore",
            "/target\n# What `backseat plugin build` makes.\n/*.wasm\n".to_owned(),
        ),
        ("README.md", readme(name)),
        ("mission/mission.toml", mission(name, content)),
    ]
    .map(|(path, text)| (path.to_owned(), text))
    .into();
    for (path, _) in content.files() {
        if let Some(source) = path
            .strip_prefix("plugins/template/")
            .filter(|path| path.starts_with("src/"))
        {
            files.push((source.to_owned(), content.text(path).to_owned()));
        }
    }
    for file in ["fence.geojson", "world.toml"] {
        let text = content.text(&format!("missions/template/{file}"));
        files.push((format!("mission/{file}"), without_schema(text)));
    }
    files
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

fn readme(name: &str) -> String {
    format!(
        "# {name}

A plugin for Backseat, which steers a Bluefin vehicle inside a geofence.

```sh
backseat plugin test     # unit tests, build, and five simulated flights
backseat plugin build    # makes {name}.wasm, the component that goes to sea
backseat plugin check    # the report that an operator signs off
backseat sim mission --map map.svg
```

All of the behavior is in `step` in `src/lib.rs`. `mission` is the mission of the test flights: `mission.toml` has the
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
        for (path, text) in files("drift", &kit) {
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
