use serde::Serialize;

/// The state of the controller's logging, as status 3 has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileDetails {
    /// Whether it logs.
    pub on: bool,
    /// The whole path of the file on the controller, cut to 260 characters; empty if it is not known.
    pub file: Box<str>,
    /// The file's size, megabytes; 0 if it is not known.
    pub size_mb: f64,
}

impl std::fmt::Display for FileDetails {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.on, self.file.is_empty()) {
            (false, _) => f.write_str("logging is off"),
            (true, true) => f.write_str("logging is on"),
            (true, false) => write!(f, "logging to {} ({:.3} MB)", self.file, self.size_mb),
        }
    }
}

/// What is known and what is wanted of the controller's logging.
#[derive(Debug, Default)]
pub(crate) struct Logging {
    /// What was ordered last; `None` leaves logging as it is.
    wanted: Option<bool>,
    /// What the controller said last on this connection.
    known: Option<FileDetails>,
}

impl Logging {
    pub(crate) const fn want(&mut self, on: bool) {
        self.wanted = Some(on);
    }

    /// A new connection: nothing is known.
    pub(crate) fn begin(&mut self) {
        self.known = None;
    }

    pub(crate) const fn known(&self) -> Option<&FileDetails> {
        self.known.as_ref()
    }

    /// What must be ordered anew because the controller does something else, or nobody knows what it does.
    pub(crate) fn to_restore(&self) -> Option<bool> {
        self.wanted.filter(|wanted| self.is_on() != Some(*wanted))
    }

    /// Whether logging was ordered and the controller does not say that it logs.
    pub(crate) fn is_missing(&self) -> bool {
        self.wanted == Some(true) && self.is_on() != Some(true)
    }

    pub(crate) fn is_on(&self) -> Option<bool> {
        self.known.as_ref().map(|details| details.on)
    }

    /// The controller has acknowledged on or off. Returns the new state if it is one.
    pub(crate) fn acknowledged(&mut self, on: bool) -> Option<FileDetails> {
        if self.is_on() == Some(on) {
            return None;
        }
        let details = FileDetails {
            on,
            file: Box::from(""),
            size_mb: 0.0,
        };
        self.known = Some(details.clone());
        Some(details)
    }

    /// The controller has reported. Returns the new state if it went on or off, or on with another file.
    pub(crate) fn reported(&mut self, details: FileDetails) -> Option<FileDetails> {
        let old = self.known.replace(details.clone());
        let same = old.is_some_and(|old| old.on == details.on && (!old.on || old.file == details.file));
        (!same).then_some(details)
    }
}
