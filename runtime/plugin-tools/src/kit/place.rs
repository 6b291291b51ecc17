use std::ffi::OsString;
use std::path::PathBuf;

/// The folder with the kits of all versions, from the environment's variables that are not empty.
pub(super) fn place(environment: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(folder) = environment("BACKSEAT_KIT") {
        return Some(PathBuf::from(folder));
    }
    // A relative path counts as unset, as the XDG base directory specification demands.
    let user = environment("XDG_DATA_HOME")
        .map(PathBuf::from)
        .filter(|path| path.is_absolute());
    let home = || Some(PathBuf::from(environment("HOME")?).join(".local/share"));
    Some(user.or_else(home)?.join("backseat/kit"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_three_variables_names_the_folder() {
        let at = |set: &[(&str, &str)]| {
            place(|name| {
                let found = set.iter().find(|(known, _)| *known == name);
                found.map(|(_, value)| OsString::from(value))
            })
        };
        let all = [
            ("BACKSEAT_KIT", "/own"),
            ("XDG_DATA_HOME", "/xdg"),
            ("HOME", "/home/ann"),
        ];
        assert_eq!(at(&all), Some("/own".into()));
        assert_eq!(at(&all[1..]), Some("/xdg/backseat/kit".into()));
        assert_eq!(at(&all[2..]), Some("/home/ann/.local/share/backseat/kit".into()));
        let relative = [("XDG_DATA_HOME", "here"), all[2]];
        assert_eq!(at(&relative), Some("/home/ann/.local/share/backseat/kit".into()));
        assert_eq!(at(&[]), None);
    }
}
