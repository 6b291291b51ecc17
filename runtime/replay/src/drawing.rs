use backseat_core::plugin::{PluginId, Request, RequestState};
use backseat_core::{Owner, RequestKind, Transition};
use backseat_units::{EastNorth, Timestamp};

/// The track has a point at most this often.
const TRACK_EVERY_NS: u64 = 1_000_000_000;
/// How many requests of each kind are kept for a picture.
const ASKED_MAX: usize = 20_000;

/// What a picture of a replay shows, in metres of the fence's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The recorded track, by navigation, oldest first.
    pub track: Vec<TrackPoint>,
    /// The inserts that plugins asked for in the recorded run, except refused ones.
    pub inserts: Vec<Request>,
    /// The refused ones, with the reason.
    pub refused: Vec<(Request, String)>,
    /// In the steps that differ: what the recorded plugin asked for.
    pub recorded: Vec<Asked>,
    /// In the steps that differ: what the plugin now asks for.
    pub now: Vec<Asked>,
}

/// A request in a step that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Where the vehicle was, if that was known.
    pub from: Option<EastNorth>,
    /// What was asked for.
    pub request: Request,
}

/// A point of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// The position.
    pub at: EastNorth,
    /// Who steered from here on.
    pub steering: Steering,
}

/// Who steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steering {
    /// The vehicle's own mission.
    FrontSeat,
    /// A plugin, by a lease.
    Lease,
    /// The vehicle, flying a plugin's insert.
    Insert,
}

/// Collects a drawing while a log is replayed.
#[derive(Debug, Default)]
pub(crate) struct Sketch {
    pub(crate) drawing: Drawing,
    next_point: u64,
    /// The inserts that are flown.
    flown: Vec<u64>,
}

impl Sketch {
    /// Notes where the vehicle is.
    pub(crate) fn at(&mut self, now: Timestamp, at: EastNorth, leased: bool) {
        if now.as_nanos() < self.next_point {
            return;
        }
        self.next_point = now.as_nanos() + TRACK_EVERY_NS;
        let steering = if leased {
            Steering::Lease
        } else if self.flown.is_empty() {
            Steering::FrontSeat
        } else {
            Steering::Insert
        };
        self.drawing.track.push(TrackPoint { at, steering });
    }

    /// Notes what becomes of a request.
    pub(crate) fn transition(&mut self, transition: &Transition) {
        let insert = matches!(
            transition.kind,
            RequestKind::Trackline | RequestKind::Trackcircle | RequestKind::GpsHit
        );
        if !insert {
            return;
        }
        match transition.state {
            RequestState::Started => self.flown.push(transition.request),
            RequestState::Ended(_)
            | RequestState::Cancelled
            | RequestState::Failed(_)
            | RequestState::TimedOut
            | RequestState::Unknown => self.flown.retain(|request| *request != transition.request),
            RequestState::Rejected(_) | RequestState::Sent | RequestState::Pending | RequestState::Accepted => {}
        }
    }

    /// Notes what a plugin asked for in the recorded run, with what core made of it at once.
    pub(crate) fn asked(&mut self, plugin: PluginId, requests: &[Request], transitions: &[Transition]) {
        for request in requests {
            let Some(tag) = insert_tag(request) else { continue };
            let refusal = transitions.iter().find_map(|transition| {
                let RequestState::Rejected(refusal) = &transition.state else {
                    return None;
                };
                let own = transition.owner == Owner::Plugin(plugin) && transition.tag == tag;
                own.then(|| refusal.summary())
            });
            let drawing = &mut self.drawing;
            if drawing.inserts.len() + drawing.refused.len() < ASKED_MAX {
                match refusal {
                    Some(reason) => drawing.refused.push((request.clone(), reason)),
                    None => drawing.inserts.push(request.clone()),
                }
            }
        }
    }

    /// Notes the requests of a step that differs.
    pub(crate) fn differs(&mut self, from: Option<EastNorth>, recorded: &[Request], now: &[Request]) {
        let Drawing {
            recorded: then,
            now: other,
            ..
        } = &mut self.drawing;
        for (requests, into) in [(recorded, then), (now, other)] {
            let room = ASKED_MAX.saturating_sub(into.len());
            into.extend(requests.iter().take(room).map(|request| Asked {
                from,
                request: request.clone(),
            }));
        }
    }
}

/// The tag of an insert.
fn insert_tag(request: &Request) -> Option<u64> {
    if let Request::Trackline(asked) = request {
        return Some(asked.tag);
    }
    if let Request::Trackcircle(asked) = request {
        return Some(asked.tag);
    }
    let Request::GpsHit(asked) = request else { return None };
    Some(asked.tag)
}
