//! Runtime, plugins and mock vehicle on a virtual clock.
