//! Lines in the run's log: [`debug!`](crate::log::debug), [`info!`](crate::log::info), [`warn!`](crate::log::warn) and
//! [`error!`](crate::log::error) take what `format!` takes.
//!
//! A line is cut at 256 bytes. The log takes 32 lines a step and counts the rest. Each line costs fuel.
//!
//! ```
//! use backseat_sdk::log;
//! log::info!("turning at {:.1} m", 41.5);
//! ```

/// How much a line matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// For the plugin's author.
    Debug,
    /// For whoever reads the log.
    Info,
    /// Something is not as it should be.
    Warn,
    /// Something has failed.
    Error,
}

/// The longest line that the log takes, bytes.
const LINE_BYTES: usize = 256;

/// Writes a line. On the host it goes to standard error.
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
    eprintln!("{level:?}: {text}");
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

/// A line for the plugin's author.
pub use crate::__log_debug as debug;
/// A line that something has failed.
pub use crate::__log_error as error;
/// A line for whoever reads the log.
pub use crate::__log_info as info;
/// A line that something is not as it should be.
pub use crate::__log_warn as warn;
