use serde::Serialize;

/// A list that stops growing, and how many entries there would be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listed<T> {
    /// How many there are.
    pub count: u64,
    /// The first of them, at most [`LIST_MAX`].
    pub first: Vec<T>,
}

/// How many entries a list shows.
pub const LIST_MAX: usize = 64;

impl<T> Default for Listed<T> {
    fn default() -> Self {
        Self {
            count: 0,
            first: Vec::new(),
        }
    }
}

impl<T> Listed<T> {
    pub(crate) fn push(&mut self, entry: T) {
        self.count += 1;
        if self.first.len() < LIST_MAX {
            self.first.push(entry);
        }
    }

    /// How many entries are not in the list.
    pub(crate) fn left_out(&self) -> u64 {
        self.count - self.first.len() as u64
    }
}
