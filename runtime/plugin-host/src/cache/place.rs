use std::ffi::OsString;
use std::path::PathBuf;

use crate::cache::ROOM_BYTES;

/// Where the user's cache is.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Place {
    Folder(PathBuf),
    /// The user wants none.
    Off,
    /// The environment names no folder.
    Nowhere,
}

/// The place, from the environment's variables that are not empty.
pub(super) fn place(environment: impl Fn(&str) -> Option<OsString>) -> Place {
    match environment("BACKSEAT_CACHE") {
        Some(off) if off == "off" => return Place::Off,
        Some(folder) => return Place::Folder(PathBuf::from(folder)),
        None => {}
    }
    // A relative path counts as unset, as the XDG base directory specification demands.
    let user = environment("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .filter(|path| path.is_absolute());
    let home = || Some(PathBuf::from(environment("HOME")?).join(".cache"));
    match user.or_else(home) {
        Some(folder) => Place::Folder(folder.join("backseat")),
        None => Place::Nowhere,
    }
}

/// The room, bytes.
///
/// # Errors
///
/// In one line, if the variable is not a number of MiB.
pub(super) fn room(environment: impl Fn(&str) -> Option<OsString>) -> Result<u64, String> {
    let Some(text) = environment("BACKSEAT_CACHE_MAX_MIB") else {
        return Ok(ROOM_BYTES);
    };
    let text = text.to_string_lossy();
    let bytes = text.parse().ok().and_then(|mib: u64| mib.checked_mul(1 << 20));
    bytes.ok_or_else(|| {
        format!(
            "cache: BACKSEAT_CACHE_MAX_MIB is {text:?}, expected a number of MiB: {} are used",
            ROOM_BYTES >> 20
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(set: &[(&str, &str)]) -> impl Fn(&str) -> Option<OsString> {
        let set: Vec<_> = set
            .iter()
            .map(|(name, value)| ((*name).to_owned(), OsString::from(value)))
            .collect();
        move |name| {
            set.iter()
                .find(|(known, _)| known == name)
                .map(|(_, value)| value.clone())
        }
    }

    fn at(set: &[(&str, &str)]) -> Place {
        place(given(set))
    }

    #[test]
    fn the_first_of_three_variables_names_the_folder() {
        let folder = |path: &str| Place::Folder(PathBuf::from(path));
        let all = [
            ("BACKSEAT_CACHE", "/own"),
            ("XDG_CACHE_HOME", "/xdg"),
            ("HOME", "/home/ann"),
        ];
        assert_eq!(at(&all), folder("/own"));
        assert_eq!(at(&all[1..]), folder("/xdg/backseat"));
        assert_eq!(at(&all[2..]), folder("/home/ann/.cache/backseat"));
        assert_eq!(at(&[]), Place::Nowhere);
        assert_eq!(
            at(&[("XDG_CACHE_HOME", "here"), all[2]]),
            folder("/home/ann/.cache/backseat")
        );
        assert_eq!(at(&[("BACKSEAT_CACHE", "off"), all[2]]), Place::Off);
        assert_eq!(at(&[("BACKSEAT_CACHE", "./off"), all[2]]), folder("./off"));
    }

    #[test]
    fn the_room_is_a_number_of_mib() {
        let room = |text| room(given(&[("BACKSEAT_CACHE_MAX_MIB", text)]));
        assert_eq!(room("3"), Ok(3 << 20));
        assert_eq!(super::room(given(&[])), Ok(1 << 30));
        for text in ["much", "-1", "1.5", "99999999999999999999"] {
            assert!(
                room(text)
                    .unwrap_err()
                    .contains("expected a number of MiB: 1024 are used")
            );
        }
    }
}
