//! Errors about files: whose a file is, and what to do.

use std::fs;
use std::io::{Error, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// What to do about an error.
const TO_DO: [(ErrorKind, &str); 4] = [
    (ErrorKind::AlreadyExists, "expected a folder, and this is a file"),
    (ErrorKind::NotADirectory, "expected a folder, and this is in a file"),
    (ErrorKind::StorageFull, "make room on its disk"),
    (
        ErrorKind::ReadOnlyFilesystem,
        "choose a folder on a disk that can be written",
    ),
];

/// The error with its path, and with what to do about it. If access was denied, it also says whose the file or its
/// folder is, and who asked.
pub(crate) fn explained(path: &Path, error: Error) -> anyhow::Error {
    let place = path.display();
    let asked = rustix::process::geteuid().as_raw();
    let there = path
        .ancestors()
        .find_map(|place| Some((place, fs::metadata(place).ok()?)));
    let what = match there {
        Some((there, found)) if error.kind() == ErrorKind::PermissionDenied && found.uid() != asked => {
            let owner = user(found.uid());
            let asked = user(asked);
            if there == path {
                format!("{place} belongs to {owner}, and this program runs as {asked}: chown {asked} {place}")
            } else {
                format!(
                    "{place}: {} belongs to {owner}, and this program runs as {asked}",
                    there.display()
                )
            }
        }
        _ => {
            let to_do = TO_DO.iter().find(|(kind, _)| *kind == error.kind());
            to_do.map_or_else(|| place.to_string(), |(_, to_do)| format!("{place}: {to_do}"))
        }
    };
    anyhow::Error::new(error).context(what)
}

/// The error of a folder that is to be made, with what to do about it. The folder in which it is to be is left as it is: it
/// may be the system's.
pub(crate) fn not_made(folder: &Path, error: Error) -> anyhow::Error {
    if error.kind() != ErrorKind::PermissionDenied || folder.exists() {
        return explained(folder, error);
    }
    let asked = user(rustix::process::geteuid().as_raw());
    let place = folder.display();
    explained(folder, error).context(format!(
        "{place} cannot be made: make it as root with `install -d -o {asked} {place}`"
    ))
}

/// As whom this program runs, to follow an error in which access was denied and that does not say it.
pub(crate) fn who_asked(error: &anyhow::Error) -> String {
    let denied = error.chain().any(|cause| {
        cause
            .downcast_ref::<Error>()
            .is_some_and(|error| error.kind() == ErrorKind::PermissionDenied)
    });
    if !denied || format!("{error:#}").contains("this program runs") {
        return String::new();
    }
    format!(": this program runs as {}", user(rustix::process::geteuid().as_raw()))
}

/// A user's name, or the number of one without a name.
fn user(number: u32) -> String {
    let accounts = fs::read_to_string("/etc/passwd").unwrap_or_default();
    let name = accounts.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, _, found) = (fields.next()?, fields.next()?, fields.next()?);
        (found.parse() == Ok(number)).then_some(name)
    });
    name.map_or_else(|| format!("user {number}"), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_denied_access_names_the_owner_and_who_asks() {
        // Of process 1, which is root's.
        let error = explained(Path::new("/proc/1/mem"), Error::from(ErrorKind::PermissionDenied));
        let told = format!("{error:#}");
        let ours = rustix::process::geteuid().is_root();
        assert_eq!(told.contains("belongs to root"), !ours, "{told}");
        let missing = explained(Path::new("/nowhere/file"), Error::from(ErrorKind::NotFound));
        assert_eq!(format!("{missing:#}"), "/nowhere/file: entity not found");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_made_by_root_and_the_one_around_it_stays() {
        let told = |place: &str| {
            format!(
                "{:#}",
                not_made(Path::new(place), Error::from(ErrorKind::PermissionDenied))
            )
        };
        let missing = told("/proc/none/logs");
        assert!(
            missing.starts_with("/proc/none/logs cannot be made: make it as root with `install -d -o ")
                && !missing.contains("chown"),
            "{missing}"
        );
        assert!(!told("/proc").contains("install -d"));
    }

    #[test]
    fn a_user_has_a_name_or_a_number() {
        assert_eq!(user(0), "root");
        assert_eq!(user(3_999_999_999), "user 3999999999");
    }
}
