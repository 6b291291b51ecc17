//! The grammar of texts: parameters separated by commas.

/// A text that does not have the form of its row.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text} parameter {field}: {fault}")]
pub struct TextError {
    /// The row: a command, status or alarm.
    pub text: &'static str,
    /// The parameter.
    pub field: &'static str,
    /// What is wrong with it.
    pub fault: TextFault,
}

/// What is wrong with a parameter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextFault {
    /// The text ends before it.
    #[error("it is missing")]
    Missing,
    /// It does not have the form that it needs, or a value cannot be written.
    #[error("expected {expected}, found {found:?}")]
    Malformed {
        /// What it needs.
        expected: &'static str,
        /// What was found, cut to [`TextFault::FOUND_CHARS`] characters.
        found: Box<str>,
    },
    /// More parameters follow the last one.
    #[error("nothing may follow, found {found:?}")]
    Extra {
        /// What follows, cut to [`TextFault::FOUND_CHARS`] characters.
        found: Box<str>,
    },
}

impl TextFault {
    /// How much of a wrong text an error keeps, characters.
    pub const FOUND_CHARS: usize = 40;

    pub(crate) fn expected(expected: &'static str, found: &str) -> Self {
        Self::Malformed {
            expected,
            found: cut(found),
        }
    }

    pub(crate) fn extra(found: &str) -> Self {
        Self::Extra { found: cut(found) }
    }
}

fn cut(text: &str) -> Box<str> {
    text.chars().take(TextFault::FOUND_CHARS).collect()
}

/// Takes parameters from the front of a text. Spaces around them do not count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader<'a> {
    rest: Option<&'a str>,
}

impl<'a> Reader<'a> {
    /// Of a text without its prefix. An empty text has no parameter.
    pub(crate) fn new(text: &'a str) -> Self {
        Self {
            rest: Some(text).filter(|text| !text.trim().is_empty()),
        }
    }

    /// The next parameter.
    pub(crate) fn next(&mut self) -> Result<&'a str, TextFault> {
        let rest = self.rest.ok_or(TextFault::Missing)?;
        let (first, behind) = match rest.split_once(',') {
            Some((first, behind)) => (first, Some(behind)),
            None => (rest, None),
        };
        self.rest = behind;
        Ok(first.trim())
    }

    /// All that is left: a last parameter may hold commas. None left is an empty text.
    pub(crate) fn rest(&mut self) -> &'a str {
        self.rest.take().unwrap_or_default().trim()
    }

    /// All but the last parameter: one that may hold commas, with one behind it.
    pub(crate) fn all_but_last(&mut self) -> Result<&'a str, TextFault> {
        let rest = self.rest.ok_or(TextFault::Missing)?;
        let (first, last) = rest.rsplit_once(',').ok_or(TextFault::Missing)?;
        self.rest = Some(last);
        Ok(first.trim())
    }

    /// What is left, without taking it.
    pub(crate) const fn left(&self) -> Option<&'a str> {
        self.rest
    }
}

/// Writes parameters with comma and space between them.
#[derive(Debug)]
pub(crate) struct Writer<'o> {
    out: &'o mut String,
    first: bool,
}

impl<'o> Writer<'o> {
    pub(crate) const fn new(out: &'o mut String) -> Self {
        Self { out, first: true }
    }

    pub(crate) fn push(&mut self, parameter: core::fmt::Arguments<'_>) {
        use core::fmt::Write as _;
        if !self.first {
            self.out.push_str(", ");
        }
        self.first = false;
        let written = self.out.write_fmt(parameter);
        debug_assert!(written.is_ok(), "writing to a String cannot fail");
    }
}

/// What follows a prefix; spaces do not count, neither in the text nor in the prefix.
pub(crate) fn without_prefix<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let mut rest = text.trim_start();
    for letter in prefix.chars().filter(|letter| *letter != ' ') {
        rest = rest.strip_prefix(letter)?.trim_start_matches(' ');
    }
    Some(rest)
}
