use crate::settings::ControlHook;

/// What the vehicle, the operator and the run itself say of who steers.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Control {
    /// The operator lets this process send what steers.
    pub(crate) armed: bool,
    /// Backseat control as the configured hook last said.
    pub(crate) handed_over: Option<bool>,
    /// BFMIS begins with `Running`.
    pub(crate) running: Option<bool>,
    /// The operator holds.
    pub(crate) held: bool,
    /// The run is ending.
    pub(crate) stopping: bool,
    /// The operator has ended the mission: whatever comes of the order, plugins steer no more until the mission is over or
    /// the operator releases them.
    pub(crate) mission_ended: bool,
    /// The vehicle is outside the fence because of us: no plugin's request is accepted.
    pub(crate) recovering: bool,
    /// Control as it was last told of.
    pub(crate) granted: bool,
}

impl Control {
    /// The link is new or gone: the vehicle has said nothing of it.
    pub(crate) fn forget(&mut self) {
        self.handed_over = None;
        self.running = None;
    }

    /// A message of the vehicle's that cannot be read may have taken control (safety requirement 001); whether this one may.
    pub(crate) fn doubt(&mut self, hook: &ControlHook, message: &str) -> bool {
        match message {
            "BFCTL" if *hook == ControlHook::Bfctl => self.handed_over = None,
            "BFMIS" => self.running = None,
            _ => return false,
        }
        true
    }
}
