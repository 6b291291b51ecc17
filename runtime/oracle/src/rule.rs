use crate::judged::Side;

macro_rules! rules {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $requirement:expr, $side:ident;)*) => {
        /// What the oracle judges.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Rule { $($(#[$doc])* $variant,)* }

        impl Rule {
            /// All rules, in the order of their numbers.
            pub(crate) const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// What the rule is judged by.
            pub(crate) const fn side(self) -> Side {
                match self { $(Self::$variant => Side::$side,)* }
            }

            /// The rule's name in reports.
            pub(crate) const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The safety requirement behind it.
            pub(crate) const fn requirement(self) -> Option<u32> {
                match self { $(Self::$variant => $requirement,)* }
            }
        }
    };
}

rules! {
    /// A dynamic request without control.
    NoControl = "no-control", Some(1), Heard;
    /// A sentence without control that is not one of the few that need no control.
    NotAllowedWithoutControl = "not-allowed-without-control", Some(14), Heard;
    /// Control was lost under a lease or station keeping, and neither BPEMB nor BPRES followed in time.
    EndMissing = "end-missing", Some(14), Heard;
    /// A BPEMB or BPRES without control and without anything to end.
    EndSurplus = "end-surplus", Some(14), Heard;
    /// A BPRCN for an insert that we did not send.
    CancelForeign = "cancel-foreign", Some(14), Sent;
    /// A live lease was not refreshed in time.
    ModifyGap = "modify-gap", Some(3), Sent;
    /// The BPRMB of a lease stopped without a BPEMB.
    ModifyAbandoned = "modify-abandoned", Some(3), Sent;
    /// BPRMB faster than allowed.
    ModifyTooFast = "modify-too-fast", Some(3), Sent;
    /// A BPRMB with an empty field, which leaves that value to the current behavior.
    ModifyInherits = "modify-inherits", Some(3), Sent;
    /// A lease continues although the vehicle does not answer.
    ModifyUnanswered = "modify-unanswered", Some(3), Heard;
    /// A lease continued after a behavior began or ended under it, or after the vehicle refused it.
    LeaseOutlives = "lease-outlives", Some(3), Heard;
    /// A lease continued after the runtime had been stopped.
    LeaseAfterStop = "lease-after-stop", Some(3), Heard;
    /// A modify that certainly leads out of the fence.
    ModifyFence = "modify-fence", Some(2), Heard;
    /// A refresh of a modify that certainly leads out of the fence.
    RefreshFence = "refresh-fence", Some(4), Heard;
    /// A modify, or its refresh, while the vehicle estimates that it is in a zone's margin, or if it certainly leads
    /// into one.
    ///
    /// The runtime promises to keep the margin, and more, from every reported position: the sweep that it judges starts
    /// there and is widened by turns, the current and the error of navigation. So this rule uses the positions that the
    /// link reports. The true position may be in the margin, because the margin exists for errors of navigation and
    /// tracking: `truth-fence` judges by the edges without the margin.
    ModifyMargin = "modify-margin", Some(4), Heard;
    /// While the vehicle flies an insert, its estimated position is in a zone's margin.
    ///
    /// The runtime judges a line, and the ways to it and on from it, with the margin, and widens them by the errors of
    /// tracking and navigation. So every position that the vehicle estimates while it flies them keeps the margin. The
    /// only excuse is a correction of navigation, which moves the estimate at once and which nobody can know in
    /// advance.
    InsertMargin = "insert-margin", Some(2), Truth;
    /// An insert although the vehicle has reported no part of its plan to this process.
    PlanUnknown = "plan-unknown", Some(2), Heard;
    /// An insert although the vehicle has reported no begin of a behavior on this connection: nobody knows what the
    /// insert would come after.
    BeginUnheard = "begin-unheard", Some(2), Heard;
    /// A lease continues or begins within 10 s of a jump of navigation, or of a sentence that moves the vehicle's
    /// frame.
    JumpIgnored = "jump-ignored", Some(21), Heard;
    /// A BPRMB reached the vehicle long after it was sent.
    StaleDelivery = "stale-delivery", Some(7), Arrived;
    /// A suspension continued for too long after the last sentence that refreshes it.
    StationOutlives = "station-outlives", Some(7), Truth;
    /// A new request after BFSHT, which announces that power will go, or any sentence more than 10 s after it.
    AfterShutdown = "after-shutdown", Some(11), Heard;
    /// A packet outside the windows that the vehicle gave.
    PacketWindow = "packet-window", Some(16), Heard;
    /// The DVL is triggered without the vehicle's permission.
    TriggerWithoutLeave = "trigger-without-leave", Some(17), Heard;
    /// The vehicle told the payload to stop triggering, and the payload did not answer.
    TriggerNotCeased = "trigger-not-ceased", Some(17), Heard;
    /// Silent mode was requested while it was already on.
    SilenceRepeated = "silence-repeated", Some(18), Heard;
    /// More requests of one kind than the mission allows, in total or by rate.
    RequestsTotal = "requests-total", Some(19), Heard;
    /// Live station keeping was neither refreshed nor ended in time.
    StationGap = "station-gap", Some(5), Sent;
    /// A sentence that needs a suspended mission was sent without a suspension.
    StationDead = "station-dead", Some(5), Sent;
    /// A dynamic request, or a lease that continues, under the operator's hold.
    OperatorHold = "operator-hold", Some(15), Operator;
    /// A waiting insert was not cancelled under the operator's hold.
    HoldCancelMissing = "hold-cancel-missing", Some(15), Operator;
    /// An insert while the fate of an insert that was sent before a loss of the link is unknown.
    InsertInDoubt = "insert-in-doubt", Some(9), Heard;
    /// A modify continued for too long after its last BPRMB.
    ModifyOutlives = "modify-outlives", Some(7), Truth;
    /// A lease was refreshed or kept while navigation was stale.
    StaleNavigation = "stale-navigation", Some(8), Heard;
    /// The geometry of an insert breaks the fence.
    RequestFence = "request-fence", Some(2), Sent;
    /// A setpoint of depth or altitude that no zone allows.
    RequestVertical = "request-vertical", Some(2), Sent;
    /// An altitude was requested without bottom lock and without a known depth of the water.
    BottomUnknown = "bottom-unknown", Some(2), Heard;
    /// A hovering vehicle was sent to a place outside the mission's box.
    RequestBox = "request-box", Some(2), Sent;
    /// A GPS hit at a place where no zone allows surfacing.
    RequestSurfacing = "request-surfacing", Some(2), Sent;
    /// A speed is outside the limits.
    RequestSpeed = "request-speed", Some(2), Sent;
    /// The vehicle was truly outside the fence under our commands, or as a consequence of them.
    TruthFence = "truth-fence", Some(2), Truth;
    /// The vehicle was truly outside the zone's depths under our commands.
    TruthDepth = "truth-depth", Some(2), Truth;
    /// The vehicle was truly outside the fence after a cancel of ours, on its way to what came next.
    TruthCancel = "truth-cancel", Some(20), Truth;
    /// The vehicle ran aground under our commands.
    TruthGrounded = "truth-grounded", Some(2), Truth;
    /// An identifier was used twice.
    IdentifierRepeated = "identifier-repeated", Some(9), Sent;
    /// Two sentences of the same name had the same timestamp.
    StampRepeated = "stamp-repeated", Some(9), Sent;
    /// An interrupting insert was sent while another one was still open.
    InterruptOfInterrupt = "interrupt-of-interrupt", Some(10), Heard;
    /// A command that only an operator's policy may send.
    OperatorOnly = "operator-only", Some(12), Sent;
    /// A sentence that moves the vehicle's estimate of its position, or that starts missions.
    MovesTruth = "moves-truth", Some(21), Sent;
    /// Too many inserts in the run.
    InsertsTotal = "inserts-total", Some(19), Heard;
    /// Too many inserts open at once.
    InsertsOpen = "inserts-open", Some(19), Heard;
    /// The open inserts together take too long to fly.
    InsertsDuration = "inserts-duration", Some(19), Heard;
    /// A request that steers was sent without proof that the vehicle hears us. The proof is an acknowledgement on this
    /// connection, within the mission's time, of a command that left less than 3 s ago. For a request that cannot be
    /// taken back, the acknowledgement must have come within the last second, for a command that left at most 2 s ago,
    /// and no BPSTS that left later may wait for its answer if the vehicle answers BPSTS.
    Unheard = "unheard", Some(23), Heard;
    /// A lease began too soon after the vehicle had refused one.
    PauseIgnored = "pause-ignored", Some(23), Heard;
    /// A request that steers was sent within 10 s of an acknowledgement which shows that the vehicle's clock was set.
    ClockSet = "clock-set", Some(23), Heard;
    /// A request that steers was sent although navigation was untrue within the last 10 s: over a window of at most 9.5
    /// s, the reported position moved away from the truth by more than the reported velocities and the mission's limits
    /// explain.
    NavigationUntrue = "navigation-untrue", Some(24), Truth;
    /// A request that steers was sent within 10 s of navigation that had come without velocities for longer than the
    /// mission allows.
    VelocityMissing = "velocity-missing", Some(24), Heard;
    /// A request that steers was sent although the vehicle has named another dive file and has not reported the plan of
    /// that dive.
    AnotherDive = "another-dive", Some(25), Heard;
    /// A sentence of ours that the reader cannot parse.
    Malformed = "malformed", None, Sent;
    /// Not a rule: the number of violations that the list omits.
    Omitted = "omitted", None, Sent;
}
