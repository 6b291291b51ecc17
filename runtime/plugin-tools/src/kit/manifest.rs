use toml::{Table, Value};

/// The tables of a manifest that only the repository needs: tests and examples are not in the kit, and neither is the
/// workspace whose lints the crate takes.
const LEFT_OUT: [&str; 6] = ["dev-dependencies", "lints", "bench", "example", "test", "bin"];

/// A crate's manifest that needs no workspace: what it inherits is written into it. `folder` is the crate's, from the
/// workspace's folder, and paths stay relative to it.
///
/// # Errors
///
/// What it inherits and the workspace does not have, or what is not TOML.
pub(super) fn stand_alone(manifest: &str, workspace: &str, folder: &str) -> Result<String, String> {
    let parse = |text: &str| text.parse::<Table>().map_err(|error| error.message().to_owned());
    let (mut manifest, workspace) = (parse(manifest)?, parse(workspace)?);
    let of_workspace = |key: &str| workspace.get("workspace").and_then(|table| table.get(key)?.as_table());
    for left_out in LEFT_OUT {
        manifest.remove(left_out);
    }
    if let Some(package) = manifest.get_mut("package").and_then(Value::as_table_mut) {
        for (key, value) in package.iter_mut().filter(|(_, value)| inherits(value)) {
            let inherited = of_workspace("package").and_then(|package| package.get(key));
            *value = inherited.ok_or_else(|| format!("package.{key}"))?.clone();
        }
    }
    let up = "../".repeat(folder.split('/').count());
    for kind in ["dependencies", "build-dependencies"] {
        let Some(dependencies) = manifest.get_mut(kind).and_then(Value::as_table_mut) else {
            continue;
        };
        for (name, dependency) in dependencies.iter_mut().filter(|(_, dependency)| inherits(dependency)) {
            let inherited = of_workspace("dependencies").and_then(|all| all.get(name));
            let inherited = inherited.ok_or_else(|| format!("{kind}.{name}"))?;
            *dependency = Value::Table(merged(inherited, dependency, &up));
        }
    }
    Ok(manifest.to_string())
}

/// Whether a value is `{ workspace = true }`, possibly with more.
fn inherits(value: &Value) -> bool {
    value.get("workspace").and_then(Value::as_bool) == Some(true)
}

/// The workspace's dependency with what the crate adds to it, as Cargo merges them.
fn merged(inherited: &Value, own: &Value, up: &str) -> Table {
    let mut merged = match inherited.as_table() {
        Some(table) => table.clone(),
        None => Table::from_iter([("version".to_owned(), inherited.clone())]),
    };
    if let Some(path) = merged.get("path").and_then(Value::as_str) {
        let path = format!("{up}{path}");
        merged.insert("path".to_owned(), Value::String(path));
    }
    for (key, value) in own
        .as_table()
        .into_iter()
        .flatten()
        .filter(|(key, _)| *key != "workspace")
    {
        if let (Some(Value::Array(features)), Value::Array(more)) = (merged.get_mut(key), value) {
            features.extend(more.clone());
        } else {
            merged.insert(key.clone(), value.clone());
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORKSPACE: &str = r#"
        [workspace.package]
        version = "0.1.0"
        edition = "2024"
        [workspace.dependencies]
        near = { path = "runtime/near" }
        far = "1.2"
        rich = { version = "3", default-features = false, features = ["a"] }
    "#;

    #[test]
    fn what_is_inherited_is_written_out() {
        let manifest = r#"
            [package]
            name = "x"
            version.workspace = true
            edition.workspace = true
            [lib]
            crate-type = ["cdylib", "rlib"]
            [dependencies]
            near.workspace = true
            far.workspace = true
            rich = { workspace = true, features = ["b"], optional = true }
            own = { version = "=0.60.0", features = ["macros"] }
            [dev-dependencies]
            proptest.workspace = true
            [lints]
            workspace = true
        "#;
        let expected = r#"
            [package]
            name = "x"
            version = "0.1.0"
            edition = "2024"
            [lib]
            crate-type = ["cdylib", "rlib"]
            [dependencies]
            near = { path = "../../runtime/near" }
            far = { version = "1.2" }
            rich = { version = "3", default-features = false, features = ["a", "b"], optional = true }
            own = { version = "=0.60.0", features = ["macros"] }
        "#;
        let written = stand_alone(manifest, WORKSPACE, "plugins/x").unwrap();
        assert_eq!(
            written.parse::<Table>().unwrap(),
            expected.parse::<Table>().unwrap(),
            "{written}"
        );
    }

    #[test]
    fn what_the_workspace_does_not_have_is_an_error() {
        let of = |manifest: &str| stand_alone(manifest, WORKSPACE, "x").unwrap_err();
        assert_eq!(of("[package]\nlicense.workspace = true"), "package.license");
        assert_eq!(of("[dependencies]\nnone.workspace = true"), "dependencies.none");
    }
}
