//! The exploration: every short sequence of inputs to the real core, from ten prepared states, against the safety
//! requirements.
//!
//! A hunt draws what happens. Here nothing is drawn: from each [`Prepared`] state all sequences of all [`Kind`]s are
//! tried, breadth first, so that the first one that breaks a requirement is a shortest one. Core is the one that goes to
//! sea; its feature `explore` lets it be copied, so that a state is gone on from and not led up to anew each time. Around
//! it are a small model vehicle, which does what SPI says and no more, a plugin that asks when it is told to, and a judge.
//!
//! What was met before is cut. Two states are the same where their [`fingerprint`](World::fingerprint) is: 128 bits over
//! all of core, the vehicle, what is under way and the judge, in which times count relative to now. What it leaves out or
//! makes coarse is a table with a reason for each ([`RULES`]).
//!
//! The judge reads sentences as bytes and asks core nothing. From the inputs and outputs of core alone it judges:
//!
//! | requirement | judged |
//! |---|---|
//! | SR-001 | nothing leaves without control but what SR-014 lists |
//! | SR-002 | both ends of a trackline are inside the fence; a modify leads out of it within 5 s in no case. Ways are not judged: that takes geometry, and is the hunt's |
//! | SR-003 | a modify stands for 2.5 s after its last BPRMB at most, no longer than its term, and not after a late wake-up or over a behavior's begin or end; BPEMB ends something |
//! | SR-004 | through SR-002 and SR-008, which hold for each refresh |
//! | SR-005 | the same for station keeping, within 1 s; BPRES ends something; one helm at a time |
//! | SR-006 | the plugin's failure ends its modify; there is one plugin, so siblings are not judged |
//! | SR-007 | not judged: what the vehicle does by itself is the vehicle's. After a kill nothing that the other rules forbid leaves |
//! | SR-008 | nothing that steers leaves, and no lease stands, on navigation older than the limit |
//! | SR-009 | no identifier twice nor unreserved; no insert leaves twice, nor while another is in doubt; a request has one end |
//! | SR-010 | nothing interrupts while an insert that interrupts is open |
//! | SR-012 | BPABT and BPKIL never leave |
//! | SR-013 | no panic; at most 64 outputs of an input; each is a sentence |
//! | SR-014 | no lease stands without control; BPRCN names our own inserts |
//! | SR-015 | nothing that steers leaves under the hold, and no lease stands; BPRCN leaves for each insert that waits |
//! | SR-019 | BPRMB at most each 0.2 s; no more open inserts than allowed |
//! | SR-021 | nothing that steers leaves within 10 s of a jump, and no lease stands |
//! | SR-022 | core's next wish is never over, and time goes on |
//! | SR-023 | nothing that steers leaves without a good round trip of the last 3 s, and no lease stands |
//! | SR-025 | nothing that steers leaves before the plan of this dive has come on this connection |
//!
//! Not judged: SR-011, 016, 017, 018 (no kind leads there), SR-020 (geometry), SR-024 (windows of navigation: the hunt's).

mod course;
mod fingerprint;
mod front;
mod judge;
mod kind;
mod prepared;
mod search;
mod wire;
mod world;

pub use fingerprint::{Fingerprint, RULES, Rule, Treatment};
pub use judge::Broken;
pub use kind::Kind;
pub use prepared::Prepared;
pub use search::{Bounds, DEPTH_MAX, Found, Level, Searched, search};
pub use world::{Planted, SENTENCES, World};
