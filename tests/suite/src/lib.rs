//! Behaviour tests of the whole.
