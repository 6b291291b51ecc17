//! `backseat-componentize DIR OUT_DIR [PACKAGE…]`: builds packages of a workspace (every plugin in it, if none is
//! named) as components, `OUT_DIR/NAME.wasm`, and prints the paths. It is a program of its own, so that `cargo xtask`
//! can start without compiling the encoder.

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use backseat_componentize::{Error, build, plugins};

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let [directory, out, packages @ ..] = arguments.as_slice() else {
        eprintln!("usage: backseat-componentize DIR OUT_DIR [PACKAGE…]");
        return ExitCode::from(2);
    };
    let packages = packages
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    match build_all(Path::new(directory), Path::new(out), packages) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("backseat-componentize: {error}");
            ExitCode::FAILURE
        }
    }
}

fn build_all(directory: &Path, out: &Path, mut packages: Vec<String>) -> Result<(), Error> {
    if packages.is_empty() {
        packages = plugins(directory)?;
        if packages.is_empty() {
            return Err(Error::NoModule(format!("in {}/plugins", directory.display())));
        }
    }
    let packages: Vec<&str> = packages.iter().map(String::as_str).collect();
    for component in build(directory, &packages, out)? {
        println!("plugin {}", component.display());
    }
    Ok(())
}
