use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse as _, Response};
use serde::Deserialize;
use tokio::sync::oneshot;
use tokio::time::{sleep, timeout};

use super::Shared;
use crate::history::Numbered;

/// Frames are at least this far apart.
const FRAME_EVERY: Duration = Duration::from_millis(100);
/// A browser that does not take a frame within this is cut off.
const TAKE_WITHIN: Duration = Duration::from_secs(10);
/// A browser says nothing; what it sends is at most this long, bytes.
const WORDS_MAX: usize = 1024;
/// When nothing happens, an empty frame says that the program lives.
const IDLE_EVERY: Duration = Duration::from_millis(900);
/// Items in a frame.
const ITEMS_MAX: usize = 2000;

/// Feeds at once. Each takes a socket of the process, which also needs some for the vehicle, its log and its state.
const FEEDS_MAX: usize = 32;

/// The feeds that are open, the oldest first.
#[derive(Default)]
pub(crate) struct Feeds(Mutex<VecDeque<oneshot::Sender<()>>>);

impl Feeds {
    /// Another one. Where there are too many, the oldest ends: sockets that nobody looks at keep nobody out, and a page that
    /// is cut off comes again. What is returned ends when it is this one's turn.
    fn open(&self) -> oneshot::Receiver<()> {
        let mut feeds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        feeds.retain(|feed| !feed.is_closed());
        while feeds.len() >= FEEDS_MAX {
            feeds.pop_front();
        }
        let (feed, ends) = oneshot::channel();
        feeds.push_back(feed);
        ends
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct After {
    #[serde(default)]
    after: u64,
}

/// The items after a number, as they come.
pub(super) async fn feed(
    State(shared): State<Arc<Shared>>,
    Query(After { after }): Query<After>,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !shared.live {
        return (StatusCode::NOT_FOUND, "a log that was read has no feed\n").into_response();
    }
    upgrade
        .max_message_size(WORDS_MAX)
        .max_frame_size(WORDS_MAX)
        .on_upgrade(move |socket| async move {
            let ends = shared.feeds.open();
            tokio::select! {
                () = show(socket, &shared, after) => {}
                _ = ends => {}
            }
        })
}

async fn show(mut socket: WebSocket, shared: &Shared, mut after: u64) {
    let mut news = shared.hub.news();
    loop {
        let frame = match shared.hub.after(after) {
            None => {
                // The browser fetches the history again, and comes back.
                let reset = Message::Text(r#"[{"kind":"reset"}]"#.into());
                drop(timeout(TAKE_WITHIN, socket.send(reset)).await);
                return;
            }
            Some(items) if items.is_empty() => None,
            Some(items) => Some(items),
        };
        if let Some(items) = frame {
            for items in items.chunks(ITEMS_MAX) {
                after = items.last().map_or(after, |item| item.n);
                match timeout(TAKE_WITHIN, socket.send(Message::Text(array(items).into()))).await {
                    Ok(Ok(())) => {}
                    Ok(Err(_)) | Err(_) => return,
                }
            }
            sleep(FRAME_EVERY).await;
        }
        tokio::select! {
            changed = news.changed() => if changed.is_err() { return },
            () = sleep(IDLE_EVERY) => {
                match timeout(TAKE_WITHIN, socket.send(Message::Text("[]".into()))).await {
                    Ok(Ok(())) => {}
                    Ok(Err(_)) | Err(_) => return,
                }
            }
            word = socket.recv() => match word {
                // Pings are answered by the library.
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return,
            },
        }
    }
}

fn array(items: &[Numbered]) -> String {
    let mut text = String::with_capacity(items.iter().map(|item| item.json.len() + 1).sum::<usize>() + 2);
    for (place, item) in items.iter().enumerate() {
        text.push(if place == 0 { '[' } else { ',' });
        text.push_str(&item.json);
    }
    text.push(']');
    text
}
