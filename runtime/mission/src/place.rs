//! Where a `mission.toml` has what a plugin refuses.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What [`Mission::config_line`](crate::Mission::config_line) tells of the text of a `mission.toml`.
pub(crate) fn config_line(text: &str, plugin: &str, key: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let (_, plugins) = entry(document.get_ref(), "plugin")?;
    let DeValue::Array(plugins) = plugins else { return None };
    let plugin = plugins
        .iter()
        .filter_map(|element| table(element.get_ref()))
        .find(|table| matches!(entry(table, "name"), Some((_, DeValue::String(name))) if name == plugin))?;
    let (mut begin, mut value) = entry(plugin, "config")?;
    for name in key.split('.') {
        let Some((at, inner)) = table(value).and_then(|table| entry(table, name)) else {
            break;
        };
        (begin, value) = (at, inner);
    }
    Some(text.get(..begin)?.matches('\n').count() + 1)
}

/// Where a table has a key, in bytes, and its value.
fn entry<'a, 'i>(table: &'a DeTable<'i>, name: &str) -> Option<(usize, &'a DeValue<'i>)> {
    table
        .iter()
        .find(|(key, _)| key.get_ref() == name)
        .map(|(key, value): (&Spanned<_>, _)| (key.span().start, value.get_ref()))
}

fn table<'a, 'i>(value: &'a DeValue<'i>) -> Option<&'a DeTable<'i>> {
    if let DeValue::Table(table) = value {
        Some(table)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::config_line;

    const TEXT: &str = "[[plugin]]\nname = \"first\"\n[plugin.config]\ndepth_m = 3\n\n[[plugin]]\nname = \"second\"\n\n\
                        [plugin.config]\n# a remark\ndepth_m = 4\narea.east_m = 5\n[plugin.config.way]\nspeed_mps = 1\n\
                        [[plugin]]\nname = \"third\"\nconfig = { depth_m = 1,\n  speed_mps = 2 }\n[[plugin]]\nname = \"fourth\"\n";

    #[test]
    fn a_key_is_found_in_the_config_of_its_own_plugin() {
        assert_eq!(config_line(TEXT, "first", "depth_m"), Some(4));
        assert_eq!(config_line(TEXT, "second", "depth_m"), Some(11));
        assert_eq!(config_line(TEXT, "second", "area.east_m"), Some(12));
        assert_eq!(config_line(TEXT, "second", "way.speed_mps"), Some(14));
        assert_eq!(config_line(TEXT, "third", "speed_mps"), Some(18));
    }

    #[test]
    fn a_key_that_is_missing_is_told_by_the_table_that_lacks_it() {
        assert_eq!(config_line(TEXT, "first", "speed_mps"), Some(3));
        assert_eq!(config_line(TEXT, "second", "way.depth_m"), Some(13));
        assert_eq!(config_line(TEXT, "third", "contour_m"), Some(17));
    }

    #[test]
    fn without_a_config_nothing_is_told() {
        assert_eq!(config_line(TEXT, "fourth", "depth_m"), None);
        assert_eq!(config_line(TEXT, "fifth", "depth_m"), None);
        assert_eq!(config_line("no TOML", "first", "depth_m"), None);
    }
}
