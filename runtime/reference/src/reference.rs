use std::sync::LazyLock;

use serde::Deserialize;

use crate::entry::Entry;

/// The reference of one kind of file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The name of the file that users write, such as `mission.toml`.
    pub file: String,
    /// The name of its page and of its schema, such as `mission`.
    pub name: String,
    /// What the file is for, in one paragraph.
    pub meaning: String,
    /// A program prints it: no key has a default or an example.
    #[serde(default)]
    pub printed: bool,
    /// The entries are of a part of the file, which other programs know as a whole.
    #[serde(default)]
    pub part: bool,
    /// The keys, in the order of the page: a table comes before its keys.
    #[serde(rename = "entry")]
    pub entries: Vec<Entry>,
}

/// The references, in the order in which they are listed.
pub static REFERENCES: LazyLock<Vec<Reference>> = LazyLock::new(|| {
    [
        include_str!("../keys/mission.toml"),
        include_str!("../keys/world.toml"),
        include_str!("../keys/faults.toml"),
        include_str!("../keys/script.toml"),
        include_str!("../keys/fence.toml"),
        include_str!("../keys/report.toml"),
        include_str!("../keys/campaign.toml"),
    ]
    .into_iter()
    .map(|text| toml::from_str(text).expect("the tables of this crate are read by its tests"))
    .collect()
});

impl Reference {
    /// Whether there is a schema of the file for editors.
    #[must_use]
    pub const fn has_schema(&self) -> bool {
        !self.printed && !self.part
    }

    /// The reference of this file or page.
    #[must_use]
    pub fn of(name: &str) -> Option<&'static Self> {
        REFERENCES
            .iter()
            .find(|reference| reference.file == name || reference.name == name)
    }

    /// The entry of a key.
    #[must_use]
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// The entries directly in this table; the empty name is the top of the file.
    pub fn within<'a>(&'a self, table: &'a str) -> impl Iterator<Item = &'a Entry> {
        let entry = self.entry(table);
        let except = entry.map_or(&[][..], |entry| &entry.except);
        let shared = entry.and_then(|entry| entry.same_as.as_deref());
        let (reference, table) = match shared.map(|shared| shared.split_once(':').ok_or(shared)) {
            Some(Ok((file, table))) => (Self::of(file).unwrap_or(self), table),
            Some(Err(table)) => (self, table),
            None => (self, table),
        };
        let within = move |entry: &&Entry| entry.table() == table && !except.contains(&entry.key);
        reference.entries.iter().filter(within)
    }
}
