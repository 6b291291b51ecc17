//! The identifiers of inserts and packets. Each is reserved on disk before it is sent, so the next process uses none of
//! them again and knows how many inserts were sent (safety requirements 009 and 019).

use std::collections::BTreeSet;
use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::Timestamp;

use crate::io::{Identifiers as Reserved, Reservation};
use crate::mutations::{Check, is_on};
use crate::plugin::Refusal;
use crate::refusal::Reason;

/// How many identifiers are reserved on disk at a time.
const RESERVE: u32 = 32;
/// When only this many are left, more are reserved.
const RESERVE_LOW: u32 = 8;
/// How long after an unanswered reservation core asks for it again.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// What is used of the reservations, and what is left.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Identifiers {
    /// `None` if the state on disk is missing.
    reserved: Option<Reserved>,
    inserts_sent: u32,
    gps_hits_sent: u32,
    /// The inserts of this process; the mission caps their number.
    sent: BTreeSet<BehaviorId>,
    /// When the last unanswered reservation was asked for.
    asked: Option<Timestamp>,
}

impl Identifiers {
    pub(crate) fn new(reserved: Option<Reserved>) -> Self {
        Self {
            reserved,
            inserts_sent: reserved.map_or(0, |reserved| reserved.inserts),
            gps_hits_sent: reserved.map_or(0, |reserved| reserved.gps_hits),
            sent: BTreeSet::new(),
            asked: None,
        }
    }

    /// Whether this process has sent an insert under an identifier.
    pub(crate) fn is_ours(&self, identifier: BehaviorId) -> bool {
        self.sent.contains(&identifier)
    }

    /// Whether an identifier is below the next one, so that this process or one before it has used it.
    pub(crate) fn is_used(&self, identifier: BehaviorId) -> bool {
        self.reserved.is_some_and(|reserved| identifier.get() < reserved.next)
    }

    /// How many tracklines and trackcircles were sent in the vehicle's mission.
    pub(crate) const fn inserts_sent(&self) -> u32 {
        self.inserts_sent
    }

    /// How many GPS hits were sent in the vehicle's mission.
    pub(crate) const fn gps_hits_sent(&self) -> u32 {
        self.gps_hits_sent
    }

    /// What is used of the reservations; `None` if the state on disk is missing.
    pub(crate) fn used(&self) -> Option<Reservation> {
        self.reserved.map(|reserved| Reservation {
            below: reserved.next,
            inserts: self.inserts_sent,
            gps_hits: self.gps_hits_sent,
        })
    }

    /// The next identifier, if it is reserved on disk.
    ///
    /// # Errors
    /// If it is not.
    pub(crate) fn next(&self) -> Result<u32, Refusal> {
        match self.reserved {
            None => Err(Reason::StateMissing.into()),
            Some(reserved) if reserved.next >= reserved.reserved && is_on(Check::IdentifiersReserved) => {
                Err(Reason::IdentifierNotReserved.into())
            }
            Some(reserved) => Ok(reserved.next),
        }
    }

    /// The next identifier for an insert. The insert itself must be reserved on disk too, because a process that
    /// follows must know how many were sent. Leaves out identifiers that are in the vehicle's plan: the record may be
    /// older than the vehicle's mission, and another payload may count as we do.
    ///
    /// # Errors
    /// If the identifier or the insert is not reserved on disk.
    pub(crate) fn next_insert(&mut self, surfaces: bool, in_plan: impl Fn(BehaviorId) -> bool) -> Result<u32, Refusal> {
        if let Some(reserved) = &mut self.reserved {
            while in_plan(BehaviorId::new(reserved.next)) && reserved.next < u32::MAX {
                reserved.next += 1;
            }
        }
        let next = self.next()?;
        let (sent, reserved) = if surfaces {
            (
                self.gps_hits_sent,
                self.reserved.map_or(0, |reserved| reserved.gps_hits),
            )
        } else {
            (self.inserts_sent, self.reserved.map_or(0, |reserved| reserved.inserts))
        };
        if sent >= reserved && is_on(Check::IdentifiersReserved) {
            return Err(Reason::InsertNotReserved.into());
        }
        Ok(next)
    }

    /// Takes the next identifier; `None` if the state on disk is missing.
    pub(crate) fn take(&mut self) -> Option<u32> {
        let reserved = self.reserved.as_mut()?;
        let next = reserved.next;
        reserved.next += 1;
        Some(next)
    }

    /// An insert was sent.
    pub(crate) fn sent(&mut self, identifier: BehaviorId, surfaces: bool) {
        if surfaces {
            self.gps_hits_sent += 1;
        } else {
            self.inserts_sent += 1;
        }
        self.sent.insert(identifier);
    }

    /// What to reserve, if few identifiers are left, or fewer inserts or GPS hits than these, which may be open at once.
    /// Both are 0 if no plugin may ask for them, because the next process must assume that they were sent.
    pub(crate) fn reserve(&mut self, now: Timestamp, [inserts, gps_hits]: [u32; 2]) -> Option<Reservation> {
        let reserved = self.reserved?;
        // A driver that cannot write does not answer. Core asks it again, because the disk may have room again.
        let waits = self.asked.is_some_and(|asked| now.since(asked) < ASK_AGAIN);
        if waits || !is_on(Check::IdentifiersReserved) {
            return None;
        }
        let low = reserved.reserved.saturating_sub(reserved.next) < RESERVE_LOW;
        let inserts = self.inserts_sent.saturating_add(inserts);
        let gps_hits = self.gps_hits_sent.saturating_add(gps_hits);
        if !low && inserts <= reserved.inserts && gps_hits <= reserved.gps_hits {
            return None;
        }
        self.asked = Some(now);
        Some(Reservation {
            below: if low {
                reserved.next.saturating_add(RESERVE)
            } else {
                reserved.reserved
            },
            inserts,
            gps_hits,
        })
    }

    /// A reservation is on disk.
    pub(crate) fn reserved(&mut self, reservation: Reservation) {
        self.asked = None;
        if let Some(reserved) = &mut self.reserved {
            reserved.reserved = reserved.reserved.max(reservation.below);
            reserved.inserts = reserved.inserts.max(reservation.inserts);
            reserved.gps_hits = reserved.gps_hits.max(reservation.gps_hits);
        }
    }
}
