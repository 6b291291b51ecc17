use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::extract::Request;
use axum::http::header::{CONTENT_LENGTH, HOST, HeaderName, HeaderValue, ORIGIN};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use tokio::time::timeout;

use super::{BODY_MAX, Busy};

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
pub(super) async fn guard(request: Request, next: Next) -> Response {
    let whose = request.uri().authority().map(ToString::to_string);
    let busy = request.extensions().get::<Busy>().cloned();
    let is = |answering: bool| {
        if let Some(Busy(busy)) = &busy {
            busy.store(answering, Ordering::Relaxed);
        }
    };
    is(true);
    let mut response = if is_too_large(request.headers()) {
        (StatusCode::PAYLOAD_TOO_LARGE, "too large\n").into_response()
    } else if is_ours(request.headers(), whose.as_deref()) {
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
    is(false);
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

/// `whose` is the name in the request's address, if it has one.
fn is_ours(headers: &HeaderMap, whose: Option<&str>) -> bool {
    let text = |value: &HeaderValue| value.to_str().unwrap_or("?").to_ascii_lowercase();
    // One name, as HTTP/1.1 asks for, and no origin but ours.
    let mut hosts = headers.get_all(HOST).iter().map(text);
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return false;
    };
    let mut origins = headers.get_all(ORIGIN).iter().map(text);
    origins.all(|origin| origin.strip_prefix("http://") == Some(host.as_str()))
        && is_name(&host)
        && whose.is_none_or(|whose| whose.eq_ignore_ascii_case(&host))
}

/// Whether a name is this computer's own.
fn is_name(given: &str) -> bool {
    ["localhost", "127.0.0.1", "[::1]"]
        .iter()
        .any(|name| match given.strip_prefix(name) {
            // Through a tunnel the port is another.
            Some(rest) => rest.is_empty() || rest.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok()),
            None => false,
        })
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
            ("LOCALHOST:8480", None, true),
        ] {
            assert_eq!(is_ours(&headers(host, origin), None), ours, "{host} {origin:?}");
        }
        let mut two = headers("localhost", None);
        assert!(is_ours(&two, Some("localhost")) && !is_ours(&two, Some("evil.example")));
        two.append(HOST, HeaderValue::from_static("evil.example"));
        assert!(!is_ours(&two, None) && !is_ours(&HeaderMap::new(), None));
    }
}
