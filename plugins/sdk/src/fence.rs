//! Asking the runtime's fence before asking for a request.

#[cfg(not(target_arch = "wasm32"))]
use crate::Rule;
use crate::{Refusal, Request};

/// Whether the request's geometry would pass the runtime's check with this step's navigation: by how many metres it
/// holds, 1000 where it is more.
///
/// It knows nothing of control, rates, other leases or the vehicle's plan, so its yes is no promise. Each question
/// costs fuel. On the host, where there is no fence, the answer is always a refusal by the rule `state`.
///
/// # Errors
/// The [`Refusal`].
#[expect(clippy::result_large_err, reason = "the interface's own type")]
pub fn check(request: &Request) -> Result<f64, Refusal> {
    #[cfg(target_arch = "wasm32")]
    {
        crate::bindings::backseat::plugin::fence::check(request)
    }
    #[cfg(not(target_arch = "wasm32"))]
    {
        let _ = request;
        Err(Refusal::new(Rule::State, "no fence outside the runtime"))
    }
}
