//! Each thing that can be asked of the vehicle: a type with a state of its own, and the hooks by which the rest tells it of
//! answers, time, a lost link, lost control and a failed plugin.

use crate::acoustic::Acoustic;
use crate::adjustment::Adjustments;
use crate::context::Context;
use crate::devices::Devices;
use crate::dvl::DvlTrigger;
use crate::helm::Modify;
use crate::hull::Station;
use crate::inserts::Inserts;
use crate::silent::Silent;
use crate::topside::Topside;

/// All of them.
pub(crate) struct Capabilities {
    pub(crate) modify: Modify,
    pub(crate) station: Station,
    pub(crate) inserts: Inserts,
    pub(crate) silent: Silent,
    pub(crate) adjustments: Adjustments,
    pub(crate) acoustic: Acoustic,
    pub(crate) dvl: DvlTrigger,
    pub(crate) topside: Topside,
    pub(crate) devices: Devices,
}

impl Capabilities {
    pub(crate) fn new() -> Self {
        Self {
            modify: Modify::default(),
            station: Station::new(),
            inserts: Inserts::default(),
            silent: Silent::default(),
            adjustments: Adjustments::default(),
            acoustic: Acoustic::default(),
            dvl: DvlTrigger::default(),
            topside: Topside::default(),
            devices: Devices,
        }
    }

    /// Ends what lasts only while it is refreshed: the modify, the station keeping.
    pub(crate) fn end_leases(&mut self, cx: &mut Context, reason: &str) {
        self.modify.end(cx, reason);
        self.station.end(cx, reason);
    }

    /// Ends all that needs control: the leases, and the DVL's triggering.
    pub(crate) fn end_controlled(&mut self, cx: &mut Context, reason: &str) {
        self.end_leases(cx, reason);
        self.dvl.end(cx, reason);
    }
}
