//! The plugin host, with the user's cache of compiled plugins.

use backseat_plugin_host::{Cache, Host, HostError, Notice};
use tracing::{info, warn};

use crate::arguments::MissionArguments;

/// A host for the plugins of a mission. It says on standard error what is wrong with the cache, and nothing that is
/// wrong with it is an error.
///
/// # Errors
///
/// If this machine cannot run WebAssembly.
pub(crate) fn host(arguments: &MissionArguments) -> Result<Host, HostError> {
    host_with(!arguments.no_cache)
}

/// A host with the cache or without it.
///
/// # Errors
///
/// If this machine cannot run WebAssembly.
pub(crate) fn host_with(cache: bool) -> Result<Host, HostError> {
    let cache = if cache { Cache::of_user(tell) } else { None };
    Ok(Host::new()?.with_cache(cache).with_notice(|text| info!("{text}")))
}

fn tell(notice: Notice) {
    match notice {
        Notice::Unusable(text) => info!("{text}"),
        Notice::Odd(text) => warn!("{text}"),
    }
}
