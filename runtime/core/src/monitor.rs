pub(crate) mod envelope;
pub(crate) mod gate;
pub(crate) mod limits;

use std::sync::Arc;

use crate::monitor::envelope::Envelope;
use crate::monitor::gate::Permits;
use crate::monitor::limits::Limits;

/// The safety monitor: which requests are allowed, and which messages may leave.
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Monitor {
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) envelope: Arc<Envelope>,
    pub(crate) permits: Permits,
}

impl Monitor {
    pub(crate) fn new(envelope: Arc<Envelope>) -> Self {
        Self {
            envelope,
            permits: Permits::default(),
        }
    }

    pub(crate) fn limits(&self) -> &Limits {
        self.envelope.limits()
    }
}
