use crate::settings::ControlHook;

/// What the vehicle, the operator and the run itself say about who steers.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Control {
    /// The operator allows this process to send messages that steer.
    pub(crate) armed: bool,
    /// Whether the backseat has control, by the last word of the configured hook.
    pub(crate) handed_over: Option<bool>,
    /// BFMIS begins with `Running`.
    pub(crate) running: Option<bool>,
    /// The operator holds.
    pub(crate) held: bool,
    /// The run is ending.
    pub(crate) stopping: bool,
    /// The operator has ended the mission. Whatever comes of that order, plugins do not steer until the mission is over
    /// or the operator releases them.
    pub(crate) mission_ended: bool,
    /// The vehicle is outside the fence because of us: no plugin's request is accepted.
    pub(crate) recovering: bool,
    /// Whether control is ours, as core last reported it.
    pub(crate) granted: bool,
}

impl Control {
    /// The link is new or gone: the vehicle has said nothing about control on it.
    pub(crate) fn forget(&mut self) {
        self.handed_over = None;
        self.running = None;
    }

    /// A message of the vehicle that cannot be read may have taken control away (safety requirement 001). Returns
    /// whether this one may have.
    pub(crate) fn doubt(&mut self, hook: &ControlHook, message: &str) -> bool {
        match message {
            "BFCTL" if *hook == ControlHook::Bfctl => self.handed_over = None,
            "BFMIS" => self.running = None,
            _ => return false,
        }
        true
    }
}
