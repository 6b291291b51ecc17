//! Asking the runtime's fence before asking for a request.

pub use crate::bindings::backseat::plugin::fence::Breach;

use crate::Request;

/// Whether the request's geometry would pass the runtime's check with this step's navigation: by how many metres it
/// holds, 1000 where it is more.
///
/// It knows nothing of control, rates, other leases or the vehicle's plan, so its yes is no promise. Each question
/// costs fuel. On the host, where there is no fence, the answer is always a breach of the rule `limit`.
///
/// # Errors
/// The [`Breach`]: rule, metres that are missing, and a line of text.
pub fn check(request: &Request) -> Result<f64, Breach> {
    #[cfg(target_arch = "wasm32")]
    {
        crate::bindings::backseat::plugin::fence::check(request)
    }
    #[cfg(not(target_arch = "wasm32"))]
    {
        let _ = request;
        Err(Breach {
            rule: "limit".into(),
            metres: 0.0,
            text: "no fence outside the runtime".into(),
        })
    }
}
