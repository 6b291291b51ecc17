use backseat_spi::BehaviorId;

/// The insert that the newest BFMBS named, until its BFMBE.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct NamedInsert {
    current: Option<BehaviorId>,
    /// What was the current one when something was not heard, and may be still.
    before: Option<BehaviorId>,
}

impl NamedInsert {
    /// A behavior has begun: an insert's, or another.
    pub(crate) fn began(&mut self, identifier: Option<BehaviorId>) {
        self.current = identifier;
        self.before = None;
    }

    /// The insert that the newest behavior to begin is.
    pub(crate) const fn current(&self) -> Option<BehaviorId> {
        self.current
    }

    /// The same, or what it was before something was not heard.
    pub(crate) fn may_be_current(&self) -> Option<BehaviorId> {
        self.current.or(self.before)
    }

    /// Something was not heard, which may have been a begin: what is flown may be another's.
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

    /// None of the mission's is flown any more.
    pub(crate) const fn forget(&mut self) {
        self.current = None;
        self.before = None;
    }
}
