//! Asks the runtime's fence about a request before it is made.

use crate::{Refusal, Request};

/// Checks whether the request's geometry would pass the runtime's check with the navigation of this step. Returns the
/// clearance in metres, at most 1000.
///
/// The check does not know of control, rates, other leases or the vehicle's plan, so the runtime may still refuse a
/// request that passes here. Each call costs fuel. On the host, a test
/// answers (`testing::Harness::set_fence`); without one, the result is always a refusal by
/// [`Rule::State`](crate::Rule::State).
///
/// # Errors
/// The [`Refusal`] that the runtime would give.
#[expect(clippy::result_large_err, reason = "the interface's own type")]
pub fn check(request: &Request) -> Result<f64, Refusal> {
    #[cfg(target_arch = "wasm32")]
    {
        crate::bindings::backseat::plugin::fence::check(request)
    }
    #[cfg(not(target_arch = "wasm32"))]
    {
        crate::host::check(request)
    }
}
