use backseat_units::Timestamp;

use super::Executive;
use crate::event::{ClientId, MODIFY_LASTS, ModifyEnd, ModifyValues, MvcEventKind};
use crate::modify::{Modify, beyond};

impl Executive {
    /// Takes a modify (SPI 7.12), or says why not.
    pub(crate) fn modify(
        &mut self,
        now: Timestamp,
        client: ClientId,
        values: ModifyValues,
    ) -> Result<(), &'static str> {
        if !self.control {
            return Err("dynamic requests are not allowed now");
        }
        if self.is_suspended() {
            return Err("the mission is suspended");
        }
        if self.modify_barred {
            return Err("this behavior has been modified for too long or too far");
        }
        if self.interpretation.modify_beyond_refused
            && let Some(why) = beyond(&values, &self.hull, self.altitude_min_m)
        {
            return Err(why);
        }
        if self
            .modify
            .is_none_or(|modify| modify.values != values || modify.client != client)
        {
            self.log.push(MvcEventKind::Modify(client, values));
        }
        self.modify = Some(Modify {
            client,
            values,
            until: now + MODIFY_LASTS,
        });
        Ok(())
    }

    /// BPEMB: whether there was a modify to end.
    pub(crate) fn end_modify_asked(&mut self) -> bool {
        let active = self.modify.is_some();
        self.end_modify(ModifyEnd::Ended);
        active
    }

    pub(super) fn modify_beyond_limits(&mut self, off_line_m: f64) -> bool {
        if self.modify.is_none() {
            return false;
        }
        self.modified += self.limits.tick;
        self.limits.modify_total.is_some_and(|limit| self.modified > limit)
            || self.limits.modify_deviation_m.is_some_and(|limit| off_line_m > limit)
    }

    /// When the modify lapses unless it is refreshed.
    fn modify_until(&self) -> Option<Timestamp> {
        self.modify.map(|modify| modify.until)
    }

    /// When the modify or the suspension lapses, whichever is first, unless it is refreshed.
    pub(crate) fn lapses_at(&self) -> Option<Timestamp> {
        self.modify_until().into_iter().chain(self.suspended_until()).min()
    }

    /// Ends a modify and a suspension whose time is over.
    pub(crate) fn lapse(&mut self, now: Timestamp) {
        self.lapse_suspension(now);
        if self.modify_until().is_some_and(|until| now >= until) {
            self.end_modify(ModifyEnd::Lapsed);
        }
    }

    pub(super) fn end_modify(&mut self, why: ModifyEnd) {
        if self.modify.take().is_some() {
            self.log.push(MvcEventKind::ModifyEnded(why));
        }
    }
}
