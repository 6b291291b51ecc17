use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::header::{AUTHORIZATION, CONTENT_LENGTH, HOST, HeaderName, HeaderValue, ORIGIN, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use tokio::time::{sleep, timeout};

use super::api::SLOWED;
use super::conversation::{Peer, Trust};
use super::{BODY_MAX, Shared};

/// A request has its answer within this.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);
/// What every answer says to the browser. The socket is named, because some browsers do not count it as our own.
const HEADERS: [(&str, &str); 5] = [
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// What a page may load and reach, before and after the names of its socket.
const POLICY: [&str; 2] = [
    "default-src 'self'; img-src 'self' data:; connect-src 'self' ",
    "; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
];

/// Answers only what was asked of this computer's own name, from our own page: another site's page, or a name that was
/// made to point here, gets nothing. Where other computers reach the console, any name is one of its own, and whoever asks
/// needs the token.
pub(super) async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let whose = request.uri().authority().map(ToString::to_string);
    let trust = request.extensions().get::<Trust>().cloned().unwrap_or_default();
    let peer = request.extensions().get::<Peer>().copied();
    trust.set(has_token(&shared, request.headers()));
    let socket = socket(request.headers(), shared.is_open);
    let mut response = if is_too_large(request.headers()) {
        (StatusCode::PAYLOAD_TOO_LARGE, "too large\n").into_response()
    } else if is_ours(request.headers(), whose.as_deref(), shared.is_open) {
        if shared.is_open
            && let Err(refusal) = known(&shared, request.headers(), peer).await
        {
            refusal
        } else {
            // A body that never comes is not waited for.
            let answer = timeout(ANSWER_WITHIN, next.run(request)).await;
            answer.unwrap_or_else(|_| (StatusCode::REQUEST_TIMEOUT, "too slow\n").into_response())
        }
    } else {
        let text = if shared.is_open {
            "the console answers only its own page, not that of another site\n"
        } else {
            "the console answers only its own page, at 127.0.0.1 or localhost\n"
        };
        (StatusCode::FORBIDDEN, text).into_response()
    };
    trust.set(false);
    if let Ok(policy) = HeaderValue::from_str(&[POLICY[0], &socket, POLICY[1]].concat()) {
        response
            .headers_mut()
            .insert(HeaderName::from_static("content-security-policy"), policy);
    }
    for (name, value) in HEADERS {
        response
            .headers_mut()
            .insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

/// What is given as a token: the password of basic authentication, or a bearer token.
fn given(headers: &HeaderMap) -> Option<String> {
    let given = headers.get(AUTHORIZATION)?.to_str().unwrap_or_default();
    let (scheme, secret) = given.split_once(' ').unwrap_or_default();
    let given = if is_basic(headers) {
        STANDARD
            .decode(secret.trim())
            .ok()
            .and_then(|pair| String::from_utf8(pair).ok())
            .and_then(|pair| pair.split_once(':').map(|(_, password)| password.to_owned()))
            .unwrap_or_default()
    } else if scheme.eq_ignore_ascii_case("bearer") {
        secret.to_owned()
    } else {
        String::new()
    };
    Some(given)
}

/// Whether it is the name and password that a browser has asked for, which it then gives with each request.
pub(super) fn is_basic(headers: &HeaderMap) -> bool {
    let given = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
    let scheme = given.and_then(|given| given.split_once(' ')).map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| scheme.eq_ignore_ascii_case("basic"))
}

/// Whether the right token is given.
pub(super) fn has_token(shared: &Shared, headers: &HeaderMap) -> bool {
    let right = |given: &String| shared.token.as_ref().is_some_and(|token| token.is(given));
    given(headers).as_ref().is_some_and(right)
}

/// Whether whoever asks gives the token; if not, the answer.
async fn known(shared: &Shared, headers: &HeaderMap, peer: Option<Peer>) -> Result<(), Response> {
    if has_token(shared, headers) {
        return Ok(());
    }
    // A browser asks first without one.
    let is_given = headers.contains_key(AUTHORIZATION);
    if is_given {
        shared.tried_wrong(peer);
        sleep(SLOWED).await;
    }
    let mut refusal = (
        StatusCode::UNAUTHORIZED,
        "{\"error\":\"wrong token: the file console.token of the state folder has it\"}\n",
    )
        .into_response();
    // The page asks for a token by itself.
    if !is_given || is_basic(headers) {
        let challenge = HeaderValue::from_static("Basic realm=\"console: any name, and the token as the password\"");
        refusal.headers_mut().insert(WWW_AUTHENTICATE, challenge);
    }
    Err(refusal)
}

/// The names of the page's socket. Some browsers do not count it as our own.
fn socket(headers: &HeaderMap, is_open: bool) -> String {
    let host = headers
        .get(HOST)
        .and_then(|host| host.to_str().ok())
        .unwrap_or_default();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || ".-:[]".contains(letter);
    if is_open && host.chars().all(is_plain) {
        format!("wss://{host}")
    } else {
        "ws://127.0.0.1:* ws://localhost:*".to_owned()
    }
}

fn is_too_large(headers: &HeaderMap) -> bool {
    let length = headers.get(CONTENT_LENGTH).and_then(|value| value.to_str().ok());
    length
        .and_then(|length| length.parse::<u64>().ok())
        .is_some_and(|length| length > BODY_MAX as u64)
}

/// `whose` is the name in the request's address, if it has one.
fn is_ours(headers: &HeaderMap, whose: Option<&str>, is_open: bool) -> bool {
    let text = |value: &HeaderValue| value.to_str().unwrap_or("?").to_ascii_lowercase();
    // What another site's page loads as a picture or a script has no origin, but browsers say whose it is. A link may lead here.
    let says = |name: &str, what: &[&str]| {
        headers
            .get_all(name)
            .iter()
            .map(text)
            .any(|value| what.contains(&value.as_str()))
    };
    if says("sec-fetch-site", &["cross-site", "same-site"]) && !says("sec-fetch-mode", &["navigate"]) {
        return false;
    }
    // One name, as HTTP/1.1 asks for, and no origin but ours.
    let mut hosts = headers.get_all(HOST).iter().map(text);
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return false;
    };
    let mut origins = headers.get_all(ORIGIN).iter().map(text);
    let scheme = if is_open { "https://" } else { "http://" };
    origins.all(|origin| origin.strip_prefix(scheme) == Some(host.as_str()))
        && (is_open || is_name(&host))
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
            assert_eq!(is_ours(&headers(host, origin), None, false), ours, "{host} {origin:?}");
        }
        // Where other computers reach it, any name is its own, but no other page asks.
        for (host, origin, ours) in [
            ("vehicle.example:8480", Some("https://vehicle.example:8480"), true),
            ("10.0.0.7:8480", None, true),
            ("vehicle.example:8480", Some("http://vehicle.example:8480"), false),
            ("vehicle.example:8480", Some("https://evil.example"), false),
        ] {
            assert_eq!(is_ours(&headers(host, origin), None, true), ours, "{host} {origin:?}");
        }
        assert_eq!(socket(&headers("10.0.0.7:8480", None), true), "wss://10.0.0.7:8480");
        assert!(!socket(&headers("a; script-src *", None), true).contains("script"));
        for (mode, ours) in [("no-cors", false), ("navigate", true)] {
            let mut picture = headers("localhost", None);
            picture.insert("sec-fetch-mode", HeaderValue::from_static(mode));
            assert!(is_ours(&picture, None, false));
            picture.insert("sec-fetch-site", HeaderValue::from_static("cross-site"));
            assert_eq!(is_ours(&picture, None, false), ours, "{mode}");
        }
        let mut two = headers("localhost", None);
        assert!(is_ours(&two, Some("localhost"), false) && !is_ours(&two, Some("evil.example"), false));
        two.append(HOST, HeaderValue::from_static("evil.example"));
        assert!(!is_ours(&two, None, false) && !is_ours(&HeaderMap::new(), None, false));
    }
}
