//! Which files make room for a new one.

/// The room of a cache by default, bytes: a hundred plugins in Rust, or ten in Python.
pub const ROOM_BYTES: u64 = 1 << 30;

/// How the name of a file begins that is still being written.
pub(super) const DRAFT: &str = "backseat-draft-";
/// A draft of this age was left by a process that ended, seconds: a process waits for its draft for some seconds.
const DRAFT_AGE_S: i64 = 3600;

/// A file in the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) bytes: u64,
    /// When it was last read or written, seconds since 1970 by the disk's clock.
    pub(super) used_s: i64,
}

/// In the order in which they are removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Of a version of the format that is not read.
    OtherVersion,
    Current,
    Draft,
}

/// What a file is, by its name. `None` if this program gives no such name: such a file is neither counted nor removed.
pub(super) fn kind(name: &str) -> Option<Kind> {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let hex = |text: &str| text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    if let Some(draft) = name.strip_prefix(DRAFT) {
        let (process, number) = draft.split_once('-')?;
        return (digits(process) && digits(number)).then_some(Kind::Draft);
    }
    let (key, version) = name.strip_prefix("backseat-")?.split_once(".v")?;
    let (component, settings) = key.split_once('-')?;
    let ours = component.len() == 64 && settings.len() == 16 && hex(component) && hex(settings) && digits(version);
    let current = version == super::key::VERSION.to_string();
    ours.then_some(if current { Kind::Current } else { Kind::OtherVersion })
}

/// The files to remove so that there is room for `needed` more bytes. `None` if that does not suffice.
pub(super) fn removed(mut kept: Vec<Kept>, needed: u64, room: u64, now_s: i64) -> Option<Vec<String>> {
    kept.sort_by(|one, other| (one.kind, one.used_s, &one.name).cmp(&(other.kind, other.used_s, &other.name)));
    let is_dead = |file: &Kept| file.kind == Kind::Draft && file.used_s < now_s.saturating_sub(DRAFT_AGE_S);
    let (dead, kept): (Vec<Kept>, Vec<Kept>) = kept.into_iter().partition(is_dead);
    let mut names: Vec<String> = dead.into_iter().map(|file| file.name).collect();
    let mut used: u64 = kept.iter().map(|file| file.bytes).sum();
    for file in kept {
        // A draft that another process is writing counts, and stays.
        if used.saturating_add(needed) > room && file.kind != Kind::Draft {
            used -= file.bytes;
            names.push(file.name);
        }
    }
    (used.saturating_add(needed) <= room).then_some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAME: &str = "backseat-e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855-0123456789abcdef";

    fn file(name: &str, kind: Kind, bytes: u64, used_s: i64) -> Kept {
        Kept {
            name: name.to_owned(),
            kind,
            bytes,
            used_s,
        }
    }

    #[test]
    fn only_names_that_this_program_gives_are_its_own() {
        assert_eq!(kind(&format!("{NAME}.v2")), Some(Kind::Current));
        assert_eq!(kind(&format!("{NAME}.v1")), Some(Kind::OtherVersion));
        assert_eq!(kind(&format!("{NAME}.v01")), Some(Kind::OtherVersion));
        assert_eq!(kind("backseat-draft-17-0"), Some(Kind::Draft));
        for other in [
            NAME,
            &format!("{NAME}.v"),
            &format!("{NAME}.v2.txt"),
            &format!("{NAME}.v2~"),
            &NAME.to_uppercase(),
            "backseat-e3b0-0123.v2",
            "backseat-draft-",
            "backseat-draft-17",
            "backseat-draft-a-b",
            "backseat.toml",
            "backseat-notes.v2",
            "thesis.tex",
            "..",
        ] {
            assert_eq!(kind(other), None, "{other}");
        }
    }

    #[test]
    fn the_least_recently_used_makes_room_after_what_nobody_reads() {
        let kept = vec![
            file("new", Kind::Current, 40, 900),
            file("old", Kind::Current, 40, 100),
            file("other version", Kind::OtherVersion, 40, 950),
        ];
        let names = |needed, room| removed(kept.clone(), needed, room, 1000);
        assert_eq!(names(10, 130), Some(vec![]));
        assert_eq!(names(11, 130), Some(vec!["other version".to_owned()]));
        let two = vec!["other version".to_owned(), "old".to_owned()];
        assert_eq!(names(60, 130), Some(two));
        assert_eq!(names(130, 130).map(|names| names.len()), Some(3));
        assert_eq!(names(131, 130), None);
        assert_eq!(names(u64::MAX, 130), None);
    }

    #[test]
    fn a_draft_goes_when_its_process_must_have_ended() {
        let kept = vec![
            file("live", Kind::Draft, 40, 6400),
            file("dead", Kind::Draft, 40, 6399),
            file("ready", Kind::Current, 40, 100),
        ];
        assert_eq!(removed(kept.clone(), 1, 1000, 10_000), Some(vec!["dead".to_owned()]));
        // It goes first, and what another process is writing stays.
        assert_eq!(removed(kept.clone(), 20, 100, 10_000), Some(vec!["dead".to_owned()]));
        let two = vec!["dead".to_owned(), "ready".to_owned()];
        assert_eq!(removed(kept.clone(), 21, 100, 10_000), Some(two));
        assert_eq!(removed(kept, 61, 100, 10_000), None);
    }
}
