mod content;
mod lock;
mod manifest;
mod place;
mod unpacked;

use std::io;
use std::path::{Path, PathBuf};

pub(crate) use content::Content;

use crate::error::ToolError;

/// The SDK with everything that it needs, unpacked in a folder of this version and content:
/// `FOLDER/VERSION-HASH/plugins/sdk` and so on.
///
/// FOLDER is `$BACKSEAT_KIT`, else `$XDG_DATA_HOME/backseat/kit`, else `~/.local/share/backseat/kit`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kit {
    folder: PathBuf,
}

impl Kit {
    /// Unpacks the kit if it is not there, and makes it anew if it is damaged. Another process may do the same at the
    /// same time.
    ///
    /// # Errors
    ///
    /// [`ToolError::NoPlace`] if the environment names no folder, [`ToolError::Kit`] if it cannot be written.
    pub fn ready() -> Result<Self, ToolError> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let place = place::place(variable).ok_or(ToolError::NoPlace)?;
        Self::ready_in(&std::path::absolute(&place).unwrap_or(place))
    }

    /// The same in this folder.
    ///
    /// # Errors
    ///
    /// [`ToolError::Kit`] if it cannot be written.
    pub fn ready_in(place: &Path) -> Result<Self, ToolError> {
        if place.to_str().is_none() {
            return Err(ToolError::Kit {
                path: place.to_path_buf(),
                source: io::Error::other("the path is not UTF-8, so no Cargo.toml can name it"),
            });
        }
        let folder = unpacked::ready(place, Content::embedded())?;
        Ok(Self { folder })
    }

    /// `…/VERSION-HASH`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The folder that Python looks into for the package `backseat_sdk`.
    #[must_use]
    pub fn python_sdk(&self) -> PathBuf {
        self.folder.join("plugins/python")
    }

    /// A folder beside those of the kits.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.folder.with_file_name(name)
    }

    /// The crate that a plugin depends on.
    #[must_use]
    pub fn sdk(&self) -> PathBuf {
        self.folder.join("plugins/sdk")
    }
}
