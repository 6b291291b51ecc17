use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::header::{CONTENT_LENGTH, HOST, HeaderName, HeaderValue, ORIGIN};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use tokio::time::timeout;

use super::{BODY_MAX, Shared};

/// A request has its answer within this.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);
/// What every answer says to the browser. The socket is named, because some browsers do not count it as our own.
const HEADERS: [(&str, &str); 6] = [
    (
        "content-security-policy",
        "default-src 'self'; img-src 'self' data:; connect-src 'self' ws://127.0.0.1:* ws://localhost:*; \
         frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// Answers only what was asked of this computer's own name, from our own page: another site's page, or a name that was
/// made to point here, gets nothing.
pub(super) async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = if is_too_large(request.headers()) {
        (StatusCode::PAYLOAD_TOO_LARGE, "too large\n").into_response()
    } else if is_ours(request.headers(), shared.port) {
        // A body that never comes is not waited for.
        let answer = timeout(ANSWER_WITHIN, next.run(request)).await;
        answer.unwrap_or_else(|_| (StatusCode::REQUEST_TIMEOUT, "too slow\n").into_response())
    } else {
        (
            StatusCode::FORBIDDEN,
            "the console answers only its own page, at 127.0.0.1 or localhost\n",
        )
            .into_response()
    };
    for (name, value) in HEADERS {
        response
            .headers_mut()
            .insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

fn is_too_large(headers: &HeaderMap) -> bool {
    let length = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok());
    length
        .and_then(|length| length.parse::<u64>().ok())
        .is_some_and(|length| length > BODY_MAX as u64)
}

fn is_ours(headers: &HeaderMap, port: u16) -> bool {
    let text = |name| {
        headers
            .get(name)
            .map(|value: &HeaderValue| value.to_str().unwrap_or("?"))
    };
    let names = ["localhost", "127.0.0.1", "[::1]"];
    let ours = |given: &str| {
        names.iter().any(|name| match given.strip_prefix(name) {
            // Through a tunnel the port is another.
            Some(rest) => rest.is_empty() || rest.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok()),
            None => false,
        })
    };
    let host = text(HOST);
    match (host, text(ORIGIN)) {
        (Some(host), None) => ours(host),
        (Some(host), Some(origin)) => ours(host) && origin.strip_prefix("http://") == Some(host),
        // HTTP/1.0 without a name.
        (None, origin) => origin.is_none() && port > 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_our_own_page_is_answered() {
        let headers = |host: &'static str, origin: Option<&'static str>| {
            let mut headers = HeaderMap::new();
            headers.insert(HOST, HeaderValue::from_static(host));
            if let Some(origin) = origin {
                headers.insert(ORIGIN, HeaderValue::from_static(origin));
            }
            headers
        };
        for (host, origin, ours) in [
            ("127.0.0.1:8480", None, true),
            ("localhost:9000", Some("http://localhost:9000"), true),
            ("[::1]:8480", Some("http://[::1]:8480"), true),
            ("localhost:8480", Some("http://evil.example"), false),
            ("localhost:8480", Some("http://localhost:9999"), false),
            ("localhost:8480", Some("null"), false),
            ("evil.example:8480", None, false),
            ("127.0.0.1.evil.example", None, false),
            ("localhostevil", None, false),
        ] {
            assert_eq!(is_ours(&headers(host, origin), 8480), ours, "{host} {origin:?}");
        }
    }
}
