/// Escape sequences for a terminal that supports them, and empty strings otherwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint(bool);

impl Paint {
    pub(crate) const fn new(colour: bool) -> Self {
        Self(colour)
    }

    pub(crate) const fn strong(self) -> &'static str {
        if self.0 { "\x1b[1m" } else { "" }
    }

    pub(crate) const fn quiet(self) -> &'static str {
        if self.0 { "\x1b[2m" } else { "" }
    }

    pub(crate) const fn alarm(self) -> &'static str {
        if self.0 { "\x1b[31m" } else { "" }
    }

    /// Ends each of the other sequences.
    pub(crate) const fn plain(self) -> &'static str {
        if self.0 { "\x1b[0m" } else { "" }
    }
}
