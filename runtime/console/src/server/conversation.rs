//! Which of the open connections makes room for a new one.

use std::collections::{BTreeMap, VecDeque};
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::task::AbortHandle;

/// Connections at once. A browser opens about six.
pub(super) const CONNECTIONS_MAX: usize = 96;

/// Whether a request with the right token is being answered on a connection. A clone is of the same connection.
#[derive(Clone, Default)]
pub(super) struct Trust(Arc<AtomicBool>);

/// Where a connection comes from.
#[derive(Clone, Copy)]
pub(super) struct Peer(pub(super) IpAddr);

impl Trust {
    pub(super) fn set(&self, is_trusted: bool) {
        self.0.store(is_trusted, Ordering::Relaxed);
    }

    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A connection.
struct Conversation {
    peer: IpAddr,
    trust: Trust,
    task: AbortHandle,
}

/// All connections, the oldest first.
#[derive(Default)]
pub(super) struct Conversations(VecDeque<Conversation>);

impl Conversations {
    /// Ends a connection if there are too many. `None` if there was room, `Some(false)` if nobody can go: then each of them
    /// is giving the right token.
    pub(super) fn make_room(&mut self) -> Option<bool> {
        let Self(open) = self;
        open.retain(|conversation| !conversation.task.is_finished());
        if open.len() < CONNECTIONS_MAX {
            return None;
        }
        let connections = open
            .iter()
            .map(|conversation| (conversation.peer, conversation.trust.is_set()));
        let Some(gone) = choose(connections).and_then(|place| open.remove(place)) else {
            return Some(false);
        };
        gone.task.abort();
        Some(true)
    }

    pub(super) fn add(&mut self, peer: IpAddr, trust: Trust, task: AbortHandle) {
        self.0.push_back(Conversation { peer, trust, task });
    }
}

/// Which connection makes room, of these with their computers and whether they are trusted: never one that is; of the others
/// the oldest of the computer that has the most, so that a flood from one computer keeps out no other. What a connection
/// asks for makes no difference: it may be something that never ends, and a new one has had no time to ask.
fn choose(open: impl Iterator<Item = (IpAddr, bool)> + Clone) -> Option<usize> {
    let others = open.enumerate().filter(|(_, (_, is_trusted))| !is_trusted);
    let mut of_peer: BTreeMap<IpAddr, usize> = BTreeMap::new();
    for (_, (peer, _)) in others.clone() {
        *of_peer.entry(peer).or_default() += 1;
    }
    let most = of_peer.values().max().copied()?;
    let mut of_most = others.filter(|(_, (peer, _))| of_peer.get(peer) == Some(&most));
    of_most.next().map(|(place, _)| place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUSTED: bool = true;
    const OTHER: bool = false;

    fn chosen(open: &[(u8, bool)]) -> Option<usize> {
        choose(open.iter().map(|(peer, is)| (IpAddr::from([10, 0, 0, *peer]), *is)))
    }

    #[test]
    fn the_oldest_makes_room_and_never_one_with_the_token() {
        assert_eq!(chosen(&[(1, TRUSTED), (1, OTHER), (1, OTHER)]), Some(1));
        assert_eq!(chosen(&[(1, TRUSTED), (1, TRUSTED)]), None);
    }

    #[test]
    fn the_computer_with_the_most_connections_makes_room() {
        assert_eq!(chosen(&[(1, OTHER), (2, OTHER), (2, OTHER), (1, TRUSTED)]), Some(1));
        // What has the token counts for nobody.
        assert_eq!(
            chosen(&[(1, TRUSTED), (1, TRUSTED), (1, OTHER), (2, OTHER), (2, OTHER)]),
            Some(3)
        );
    }
}
