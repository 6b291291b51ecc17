use std::path::{Path, PathBuf};

use crate::error::MissionError;

/// Finds a plugin's component. A path (with a separator or an extension) is relative to the mission's folder. A bare
/// name is looked up as `NAME.wasm` in the given folder, in `$BACKSEAT_PLUGINS`, then in `target/plugins`.
///
/// # Errors
///
/// [`MissionError::NoComponent`] with the places that were tried.
pub fn find_component(
    mission: &Path,
    plugin: &str,
    component: &str,
    folder: Option<&Path>,
) -> Result<PathBuf, MissionError> {
    let is_path = component.contains(['/', '\\']) || component.ends_with(".wasm");
    let places: Vec<PathBuf> = if is_path {
        vec![mission.join(component)]
    } else {
        let file = format!("{component}.wasm");
        let environment = std::env::var_os("BACKSEAT_PLUGINS").map(PathBuf::from);
        let built = PathBuf::from("target/plugins");
        folder
            .map(Path::to_path_buf)
            .into_iter()
            .chain(environment)
            .chain([built])
            .map(|folder| folder.join(&file))
            .collect()
    };
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Ok(found.clone());
    }
    let mut looked = places
        .iter()
        .map(|place| match place.exists() {
            true => format!("{} (which is not a regular file)", place.display()),
            false => place.display().to_string(),
        })
        .collect::<Vec<_>>()
        .join(", ");
    if !is_path {
        looked.push_str(
            "; --plugins DIR or the environment's BACKSEAT_PLUGINS names another folder. In a clone of the project, \
             `cargo xtask plugins` builds its own, and `cargo xtask python` those in Python",
        );
    }
    Err(MissionError::NoComponent {
        plugin: plugin.to_owned(),
        component: component.to_owned(),
        looked,
    })
}
