use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest as _, State};
use axum::http::StatusCode;
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE};
use axum::response::{IntoResponse as _, Response};
use futures_util::stream;
use serde::Deserialize;
use serde_json::json;
use tokio::time::{Instant, sleep};
use tracing::warn;

use super::Shared;
use super::conversation::Peer;
use super::guard::{has_token, is_basic};
use crate::item::Item;
use crate::operator::{Act, Asked, NotAsked};

/// After a wrong token the answer waits for this. The right one never waits: there are too many to guess it.
pub(super) const SLOWED: Duration = Duration::from_secs(1);
/// After so many wrong tokens people are told, and again each time that they are twice as many.
const TOLD_AT: u32 = 5;
/// Items in one piece of the history.
const PIECE: usize = 512;
/// A name that is longer is no name.
const NAME_MAX: usize = 64;

pub(super) async fn about(State(shared): State<Arc<Shared>>) -> Response {
    (
        [(CONTENT_TYPE, "application/json")],
        shared.hub.about(shared.pace.as_ref()),
    )
        .into_response()
}

/// Figures for Prometheus.
pub(super) async fn metrics(State(shared): State<Arc<Shared>>) -> Response {
    let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(CONTENT_TYPE, kind)], shared.hub.metrics()).into_response()
}

/// Everything that is kept, an item a line, in pieces, so that a browser shows the first while the last are on their way.
pub(super) async fn history(State(shared): State<Arc<Shared>>) -> Response {
    let items = shared.hub.history();
    // A piece is made when the browser has taken the one before: a browser that does not read costs no memory.
    let pieces = (0..items.len().div_ceil(PIECE)).map(move |place| {
        let items = &items[place * PIECE..items.len().min((place + 1) * PIECE)];
        let mut piece = Vec::with_capacity(items.iter().map(|item| item.json.len() + 1).sum());
        for item in items {
            piece.extend_from_slice(item.json.as_bytes());
            piece.push(b'\n');
        }
        Ok::<_, Infallible>(Bytes::from(piece))
    });
    let body = Body::from_stream(stream::iter(pieces));
    ([(CONTENT_TYPE, "application/x-ndjson")], body).into_response()
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Wish {
    Hold,
    Release,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    act: Wish,
    who: String,
}

pub(super) async fn operator(State(shared): State<Arc<Shared>>, request: axum::extract::Request) -> Response {
    if shared.token.is_none() || !shared.live {
        return refused(
            StatusCode::CONFLICT,
            "this console only shows: nothing can be held or released here",
        );
    }
    // The body of whoever has no token is not waited for.
    let headers = request.headers();
    if !headers.contains_key(AUTHORIZATION) {
        return refused(
            StatusCode::UNAUTHORIZED,
            "no token: give it as `Authorization: Bearer TOKEN`; the file console.token of the state folder has it",
        );
    }
    if is_basic(headers) || !has_token(&shared, headers) {
        shared.tried_wrong(request.extensions().get::<Peer>().copied());
        sleep(SLOWED).await;
        return refused(
            StatusCode::UNAUTHORIZED,
            "wrong token: the file console.token of the state folder has it",
        );
    }
    let request = match Json::<Request>::from_request(request, &()).await {
        Ok(Json(request)) => request,
        Err(error) => {
            let expected = "expected {\"act\": \"hold\", \"who\": \"NAME\"}, or \"release\"";
            return refused(StatusCode::BAD_REQUEST, &format!("{expected}: {}", error.body_text()));
        }
    };
    let who = request.who.trim().to_owned();
    if who.is_empty() || who.chars().count() > NAME_MAX || who.chars().any(char::is_control) {
        return refused(StatusCode::BAD_REQUEST, "who: expected a name of 1 to 64 characters");
    }
    let act = match request.act {
        Wish::Hold => Act::Hold,
        Wish::Release => Act::Release,
    };
    match shared.desk.ask(Asked { act, who }, Instant::now()) {
        Ok(()) => (StatusCode::ACCEPTED, Json(json!({}))).into_response(),
        Err(refusal) => {
            let status = match refusal {
                NotAsked::Soon => StatusCode::TOO_MANY_REQUESTS,
                NotAsked::Full => StatusCode::SERVICE_UNAVAILABLE,
                NotAsked::Ended => StatusCode::CONFLICT,
            };
            refused(status, &refusal.to_string())
        }
    }
}

/// How fast a simulation shall go.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Times {
    times: f64,
}

pub(super) async fn pace(State(shared): State<Arc<Shared>>, wish: Result<Json<Times>, JsonRejection>) -> Response {
    let Some(pace) = &shared.pace else {
        return refused(StatusCode::CONFLICT, "only a simulation has a pace");
    };
    if shared.hub.is_over() {
        return refused(StatusCode::CONFLICT, "the simulation is over");
    }
    let Json(Times { times }) = match wish {
        Ok(wish) => wish,
        Err(error) => return refused(StatusCode::BAD_REQUEST, &error.body_text()),
    };
    if !pace.set(times) {
        return refused(StatusCode::BAD_REQUEST, "times: expected 0 or more");
    }
    shared.hub.happened(&Item::Pace { times: pace.told() });
    (StatusCode::ACCEPTED, Json(json!({}))).into_response()
}

fn refused(status: StatusCode, error: &str) -> Response {
    (status, Json(json!({ "error": error }))).into_response()
}

impl Shared {
    /// Says from time to time that somebody gives wrong tokens.
    pub(super) fn tried_wrong(&self, peer: Option<Peer>) {
        let wrong = self.wrong.fetch_add(1, Ordering::Relaxed) + 1;
        if wrong.is_multiple_of(TOLD_AT) && (wrong / TOLD_AT).is_power_of_two() {
            let from = peer.map_or_else(String::new, |Peer(from)| format!(", the last from {from}"));
            let text = format!("{wrong} wrong tokens so far{from}");
            warn!("console: {text}");
            self.hub.say("warn", "console", &text);
        }
    }
}
