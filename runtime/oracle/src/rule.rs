use crate::judged::Side;

macro_rules! rules {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $requirement:expr, $side:ident;)*) => {
        /// What is judged.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Rule { $($(#[$doc])* $variant,)* }

        impl Rule {
            /// All of them, in the order of their numbers.
            pub(crate) const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// What it is judged by.
            pub(crate) const fn side(self) -> Side {
                match self { $(Self::$variant => Side::$side,)* }
            }

            /// Its name in reports.
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
    /// Anything but the few harmless sentences without control.
    NotAllowedWithoutControl = "not-allowed-without-control", Some(14), Heard;
    /// Control was lost under a lease or station keeping, and neither BPEMB nor BPRES followed in time.
    EndMissing = "end-missing", Some(14), Heard;
    /// A BPEMB or BPRES without control and without anything to end.
    EndSurplus = "end-surplus", Some(14), Heard;
    /// A BPRCN for what we have not sent.
    CancelForeign = "cancel-foreign", Some(14), Sent;
    /// A live lease was not refreshed in time.
    ModifyGap = "modify-gap", Some(3), Sent;
    /// A lease stopped without BPEMB.
    ModifyAbandoned = "modify-abandoned", Some(3), Sent;
    /// BPRMB faster than allowed.
    ModifyTooFast = "modify-too-fast", Some(3), Sent;
    /// A BPRMB that leaves something to the current behavior.
    ModifyInherits = "modify-inherits", Some(3), Sent;
    /// A lease goes on though the vehicle does not answer.
    ModifyUnanswered = "modify-unanswered", Some(3), Heard;
    /// A lease outlived its cause: a behavior began or ended under it, or the vehicle refused it.
    LeaseOutlives = "lease-outlives", Some(3), Heard;
    /// A lease that goes on after the runtime had stood still.
    LeaseAfterStop = "lease-after-stop", Some(3), Heard;
    /// A modify whose certain consequence leaves the fence.
    ModifyFence = "modify-fence", Some(2), Heard;
    /// A refresh whose certain consequence leaves the fence.
    RefreshFence = "refresh-fence", Some(4), Heard;
    /// A modify or its refresh from where the vehicle believes to be in a zone's margin, or comes into one for certain.
    ///
    /// The runtime promises the margin and more of each sample of navigation: what it judges begins where the vehicle says
    /// that it is, and is widened by turns, current and navigation's error. So what is judged is what the link says. The truth
    /// may be in the margin, which is there for navigation's error and tracking: `truth-fence` judges bare edges.
    ModifyMargin = "modify-margin", Some(4), Heard;
    /// Under an insert the vehicle believes to be in a zone's margin.
    ///
    /// A line, the ways to it and on, are judged with the margin and widened by tracking and navigation's error, so that
    /// wherever the vehicle believes to be under them is within. Only what a correction of navigation explains is excused: it
    /// puts the vehicle elsewhere at once, and nobody can know before.
    InsertMargin = "insert-margin", Some(2), Truth;
    /// An insert though no plan was ever told.
    PlanUnknown = "plan-unknown", Some(2), Heard;
    /// An insert though on this connection no behavior was ever told to begin: nobody knows what it would come after.
    BeginUnheard = "begin-unheard", Some(2), Heard;
    /// A lease goes on, or begins, within 10 s of a jump of navigation, or of what moves the vehicle's frame.
    JumpIgnored = "jump-ignored", Some(21), Heard;
    /// A BPRMB came to the vehicle long after it was sent.
    StaleDelivery = "stale-delivery", Some(7), Arrived;
    /// A suspension outlived the last sentence that keeps it.
    StationOutlives = "station-outlives", Some(7), Truth;
    /// A new request after the word that power will go, or anything at all 10 s after.
    AfterShutdown = "after-shutdown", Some(11), Heard;
    /// A packet outside of the windows that the vehicle gave.
    PacketWindow = "packet-window", Some(16), Heard;
    /// The DVL is triggered without leave.
    TriggerWithoutLeave = "trigger-without-leave", Some(17), Heard;
    /// The vehicle's word to cease triggering was not answered.
    TriggerNotCeased = "trigger-not-ceased", Some(17), Heard;
    /// Silent mode was asked for anew while it stands.
    SilenceRepeated = "silence-repeated", Some(18), Heard;
    /// More of one kind than the mission allows, in all or in a minute.
    RequestsTotal = "requests-total", Some(19), Heard;
    /// Station keeping that was alive was neither refreshed nor ended in time.
    StationGap = "station-gap", Some(5), Sent;
    /// A sentence that needs a suspended mission, without one.
    StationDead = "station-dead", Some(5), Sent;
    /// A dynamic request, or a lease that goes on, under the operator's hold.
    OperatorHold = "operator-hold", Some(15), Operator;
    /// An insert that waits was not taken back under the operator's hold.
    HoldCancelMissing = "hold-cancel-missing", Some(15), Operator;
    /// An insert while it is not known what became of one that was sent before the link was lost.
    InsertInDoubt = "insert-in-doubt", Some(9), Heard;
    /// A modify outlived its last BPRMB.
    ModifyOutlives = "modify-outlives", Some(7), Truth;
    /// A lease was refreshed or kept while navigation was stale.
    StaleNavigation = "stale-navigation", Some(8), Heard;
    /// The geometry of an insert breaks the fence.
    RequestFence = "request-fence", Some(2), Sent;
    /// A setpoint of depth or altitude is in no band that applies.
    RequestVertical = "request-vertical", Some(2), Sent;
    /// A height above the seabed was asked for without bottom lock and without a known depth of the water.
    BottomUnknown = "bottom-unknown", Some(2), Heard;
    /// A hovering vehicle was told to move out of the mission's box.
    RequestBox = "request-box", Some(2), Sent;
    /// A GPS hit where no zone lets the vehicle surface.
    RequestSurfacing = "request-surfacing", Some(2), Sent;
    /// A speed is out of limits.
    RequestSpeed = "request-speed", Some(2), Sent;
    /// The vehicle was truly outside under our commands, or because of them.
    TruthFence = "truth-fence", Some(2), Truth;
    /// The vehicle was truly out of the zone's depths under our commands.
    TruthDepth = "truth-depth", Some(2), Truth;
    /// The vehicle was truly outside after a cancel of ours, on its way to what came next.
    TruthCancel = "truth-cancel", Some(20), Truth;
    /// The vehicle ran aground under our commands.
    TruthGrounded = "truth-grounded", Some(2), Truth;
    /// An identifier was used twice.
    IdentifierRepeated = "identifier-repeated", Some(9), Sent;
    /// A timestamp was used twice by one name.
    StampRepeated = "stamp-repeated", Some(9), Sent;
    /// An interrupting insert while another one runs.
    InterruptOfInterrupt = "interrupt-of-interrupt", Some(10), Heard;
    /// A command that only an operator's policy may send.
    OperatorOnly = "operator-only", Some(12), Sent;
    /// A sentence that moves the vehicle's idea of where it is, or starts missions.
    MovesTruth = "moves-truth", Some(21), Sent;
    /// Too many inserts in the run.
    InsertsTotal = "inserts-total", Some(19), Heard;
    /// Too many inserts open at once.
    InsertsOpen = "inserts-open", Some(19), Heard;
    /// The open inserts fly for too long.
    InsertsDuration = "inserts-duration", Some(19), Heard;
    /// What steers left though the vehicle was not heard to have heard us: no acknowledgement in the mission's time, on this
    /// connection, of a command that left under 3 s ago; for what nothing takes back, none within the last second of one
    /// that left at most 2 s ago.
    Unheard = "unheard", Some(23), Heard;
    /// A lease began too soon after one that the vehicle had refused.
    PauseIgnored = "pause-ignored", Some(23), Heard;
    /// What steers left within 10 s of an answer that shows that the vehicle's clock was set.
    ClockSet = "clock-set", Some(23), Heard;
    /// What steers left though, over a window of at most 9.5 s within the last 10 s, navigation's place has left the truth by
    /// more than its own velocities and the mission's limits explain.
    NavigationUntrue = "navigation-untrue", Some(24), Truth;
    /// What steers left within 10 s of navigation that came without velocities for longer than the mission lets it.
    VelocityMissing = "velocity-missing", Some(24), Heard;
    /// What steers left though the vehicle has named another dive file and has not told the plan of it.
    AnotherDive = "another-dive", Some(25), Heard;
    /// A sentence of ours that does not parse.
    Malformed = "malformed", None, Sent;
    /// Not a rule: how many violations are not listed.
    Omitted = "omitted", None, Sent;
}
