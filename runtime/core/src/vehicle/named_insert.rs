use backseat_spi::BehaviorId;

/// The insert that the newest BFMBS named, until its BFMBE.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct NamedInsert {
    current: Option<BehaviorId>,
    /// The insert that was current when a message or the link was lost. It may still be.
    before: Option<BehaviorId>,
}

impl NamedInsert {
    /// A behavior has begun: an insert, or with `None` another behavior.
    pub(crate) fn began(&mut self, identifier: Option<BehaviorId>) {
        self.current = identifier;
        self.before = None;
    }

    /// The insert that has begun last, if no other behavior has begun since.
    pub(crate) const fn current(&self) -> Option<BehaviorId> {
        self.current
    }

    /// The same, or the insert that was current before a message or the link was lost.
    pub(crate) fn may_be_current(&self) -> Option<BehaviorId> {
        self.current.or(self.before)
    }

    /// A message or the link was lost. A begin may have been lost with it, so another behavior may be flown now.
    pub(crate) fn invalidate_after_loss(&mut self) {
        self.before = self.current.take().or(self.before);
    }

    /// A behavior has ended.
    pub(crate) fn finished(&mut self, identifier: Option<BehaviorId>) {
        if self.before == identifier {
            self.before = None;
        }
        if self.current == identifier {
            self.current = None;
        }
    }

    /// The mission is ending or over: none of its inserts is flown any more.
    pub(crate) const fn forget(&mut self) {
        self.current = None;
        self.before = None;
    }
}
