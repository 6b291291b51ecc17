//! Writing to the run's log. [`debug!`](crate::log::debug), [`info!`](crate::log::info), [`warn!`](crate::log::warn)
//! and [`error!`](crate::log::error) take the arguments of `format!`.
//!
//! A line is cut at 256 bytes. The log keeps 32 lines a step and only counts further ones. Each line costs fuel.
//!
//! ```
//! use backseat_sdk::log;
//! log::info!("turning at {:.1} m", 41.5);
//! ```

/// The importance of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Details for the plugin's author.
    Debug,
    /// Information for every reader of the log.
    Info,
    /// Something is unexpected.
    Warn,
    /// Something has failed.
    Error,
}

/// The length at which a line is cut, bytes.
const LINE_BYTES: usize = 256;

/// Writes a line to the run's log; on the host, to the log of a `testing::Harness`, or to standard error.
pub fn write(level: Level, text: &str) {
    let text = &text[..text.floor_char_boundary(LINE_BYTES)];
    #[cfg(target_arch = "wasm32")]
    {
        use crate::bindings::backseat::plugin::log;
        let level = match level {
            Level::Debug => log::Level::Debug,
            Level::Info => log::Level::Info,
            Level::Warn => log::Level::Warn,
            Level::Error => log::Level::Error,
        };
        log::write(level, text);
    }
    #[cfg(not(target_arch = "wasm32"))]
    crate::host::write(level, text);
}

#[doc(hidden)]
#[macro_export]
macro_rules! __log_debug {
    ($($text:tt)*) => { $crate::log::write($crate::log::Level::Debug, &::std::format!($($text)*)) };
}
#[doc(hidden)]
#[macro_export]
macro_rules! __log_info {
    ($($text:tt)*) => { $crate::log::write($crate::log::Level::Info, &::std::format!($($text)*)) };
}
#[doc(hidden)]
#[macro_export]
macro_rules! __log_warn {
    ($($text:tt)*) => { $crate::log::write($crate::log::Level::Warn, &::std::format!($($text)*)) };
}
#[doc(hidden)]
#[macro_export]
macro_rules! __log_error {
    ($($text:tt)*) => { $crate::log::write($crate::log::Level::Error, &::std::format!($($text)*)) };
}

/// Logs details for the plugin's author.
pub use crate::__log_debug as debug;
/// Logs that something has failed.
pub use crate::__log_error as error;
/// Logs information for every reader of the log.
pub use crate::__log_info as info;
/// Logs that something is unexpected.
pub use crate::__log_warn as warn;
