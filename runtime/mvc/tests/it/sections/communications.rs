use super::Section;

pub(crate) const SECTIONS: &[Section] = &[];
