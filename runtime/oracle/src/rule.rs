macro_rules! rules {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $requirement:expr;)*) => {
        /// What is judged.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Rule { $($(#[$doc])* $variant,)* }

        impl Rule {
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
    NoControl = "no-control", Some(1);
    /// Anything but the few harmless sentences without control.
    NotAllowedWithoutControl = "not-allowed-without-control", Some(14);
    /// Control was lost under a lease or a hold, and neither BPEMB nor BPRES followed in time.
    EndMissing = "end-missing", Some(14);
    /// A BPEMB or BPRES without control and without anything to end.
    EndSurplus = "end-surplus", Some(14);
    /// A BPRCN for what we have not sent.
    CancelForeign = "cancel-foreign", Some(14);
    /// A live lease was not refreshed in time.
    ModifyGap = "modify-gap", Some(3);
    /// A lease stopped without BPEMB.
    ModifyAbandoned = "modify-abandoned", Some(3);
    /// BPRMB faster than allowed.
    ModifyTooFast = "modify-too-fast", Some(3);
    /// A BPRMB that leaves something to the current behavior.
    ModifyInherits = "modify-inherits", Some(3);
    /// A live hold was neither refreshed nor ended in time.
    HoldGap = "hold-gap", Some(5);
    /// A sentence that needs a suspended mission, without one.
    HoldDead = "hold-dead", Some(5);
    /// A dynamic request, or a lease that goes on, under the operator's hold.
    OperatorHold = "operator-hold", Some(15);
    /// An insert that waits was not taken back under the operator's hold.
    HoldCancelMissing = "hold-cancel-missing", Some(15);
    /// An insert while it is not known what became of one that was sent before the link was lost.
    InsertInDoubt = "insert-in-doubt", Some(9);
    /// A modify outlived its last BPRMB.
    ModifyOutlives = "modify-outlives", Some(7);
    /// A lease was refreshed or kept while navigation was stale.
    StaleNavigation = "stale-navigation", Some(8);
    /// The geometry of an insert breaks the fence.
    RequestFence = "request-fence", Some(2);
    /// A setpoint of depth or altitude is in no band that applies.
    RequestVertical = "request-vertical", Some(2);
    /// A speed is out of limits.
    RequestSpeed = "request-speed", Some(2);
    /// The vehicle was truly outside under our commands, or because of them.
    TruthFence = "truth-fence", Some(2);
    /// The vehicle was truly out of the zone's depths under our commands.
    TruthDepth = "truth-depth", Some(2);
    /// The vehicle ran aground under our commands.
    TruthGrounded = "truth-grounded", Some(2);
    /// An identifier was used twice.
    IdentifierRepeated = "identifier-repeated", Some(9);
    /// A timestamp was used twice by one name.
    StampRepeated = "stamp-repeated", Some(9);
    /// An interrupting insert while another one runs.
    InterruptOfInterrupt = "interrupt-of-interrupt", Some(10);
    /// A command that only an operator's policy may send.
    OperatorOnly = "operator-only", Some(12);
    /// A sentence that moves the vehicle's idea of where it is, or starts missions.
    MovesTruth = "moves-truth", Some(21);
    /// Too many inserts in the run.
    InsertsTotal = "inserts-total", Some(19);
    /// Too many inserts open at once.
    InsertsOpen = "inserts-open", Some(19);
    /// The open inserts fly for too long.
    InsertsDuration = "inserts-duration", Some(19);
    /// A sentence of ours that does not parse.
    Malformed = "malformed", None;
    /// Not a rule: how many violations are not listed.
    Omitted = "omitted", None;
}
