use std::fs;
use std::io;
use std::path::Path;

use backseat_plugin_host::COMPONENT_BYTES;

/// Reads a component from its file.
///
/// # Errors
///
/// If the path is no regular file (opening a pipe would wait for its other end), if the file is larger than
/// [`COMPONENT_BYTES`], or if it cannot be read.
pub fn read_component(path: &Path) -> io::Result<Vec<u8>> {
    let bytes = regular_file(path)?;
    if bytes > COMPONENT_BYTES as u64 {
        let text = format!("{bytes} bytes, expected at most {COMPONENT_BYTES}");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
    }
    fs::read(path)
}

/// The size of a regular file, bytes.
///
/// # Errors
///
/// If there is none, or if the path is that of a folder, a pipe or a device.
pub fn regular_file(path: &Path) -> io::Result<u64> {
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !found.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    Ok(found.len())
}
