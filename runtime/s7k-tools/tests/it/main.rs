//! The tools over a composed survey.

#[cfg(test)]
#[path = "../../examples/survey/compose.rs"]
mod compose;
#[cfg(test)]
mod exports;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod inputs;
#[cfg(test)]
mod reader;
#[cfg(test)]
mod tools;
