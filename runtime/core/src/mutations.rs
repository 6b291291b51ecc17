//! The monitor's checks by name and, in test builds only, mutations that leave out one check at a time.
//!
//! A hunt that finds nothing proves little. With the feature `mutations`, a test leaves out a single check, and must
//! then see the hunt find what that check had prevented. Without the feature there are no mutations: every check is on,
//! at no cost, and this module is not public. No program of ours has the feature; `cargo xtask tidy` makes sure of
//! that.
#![cfg_attr(
    not(feature = "mutations"),
    doc = "
```compile_fail,E0603
backseat_core::mutations::is_on(backseat_core::mutations::Check::Shutdown);
```"
)]
#![cfg_attr(
    not(feature = "mutations"),
    expect(unreachable_pub, reason = "they are public with the feature `mutations`")
)]

macro_rules! checks {
    ($($(#[$present:meta])* $name:ident $kebab:literal $requirement:literal $what:literal;)*) => {
        /// A check of the monitor.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Check {
            $(
                #[doc = $what]
                $(#[$present])*
                $name,
            )*
        }

        #[cfg(feature = "mutations")]
        impl Check {
            /// All of them.
            pub const ALL: [Self; [$($requirement),*].len()] = [$(Self::$name),*];

            /// Its name, in kebab case.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $kebab,)*
                }
            }

            /// The number of the safety requirement that it keeps.
            #[must_use]
            pub const fn requirement(self) -> u32 {
                match self {
                    $(Self::$name => $requirement,)*
                }
            }

            /// What it checks, in one line.
            #[must_use]
            pub const fn what(self) -> &'static str {
                match self {
                    $(Self::$name => $what,)*
                }
            }
        }
    };
}

checks! {
    ControlGiven "control-given" 1 "nothing dynamic leaves while the vehicle says that it has control itself";
    ControlKnown "control-known" 1 "nothing dynamic leaves before the vehicle has said, on this connection, who has control and whether its mission runs";
    MissionRuns "mission-runs" 1 "nothing dynamic leaves while the vehicle says that its mission is not running";
    InsertFence "insert-fence" 2 "an insert, the way to it, the way on from it, and the ways back from waiting inserts onto what it interrupts are inside the fence";
    InsertShape "insert-shape" 2 "an insert's own geometry is inside the fence";
    InsertWayTo "insert-way-to" 2 "the way to an insert is inside the fence";
    InsertWayOn "insert-way-on" 2 "the way from an insert to what comes next is inside the fence";
    Surfacing "surfacing" 2 "a GPS hit with its drift is where the fence lets the vehicle surface, and nothing leads the vehicle away from a GPS hit";
    ModifyFence "modify-fence" 2 "everything to which a modify can lead is inside the fence, with the ways back to the plan";
    ModifyWayBack "modify-way-back" 2 "the ways back from a modify to the plan are inside the fence";
    PlanKnown "plan-known" 2 "no modify and no insert is sent while the vehicle's plan or its current behavior is unknown";
    SpeedLimits "speed-limits" 2 "a speed is within the mission's limits";
    BottomKnown "bottom-known" 2 "an altitude is requested only if the depth of the water is known";
    StationBox "station-box" 2 "a vehicle that keeps its station is, with its way, inside the allowed boxes, outside the forbidden ones and above the least altitude";
    RefreshCadence "refresh-cadence" 3 "a modify is refreshed every second; without it, every four";
    LeaseEndSaid "lease-end-said" 3 "BPEMB is sent at the end of a modify";
    LateWake "late-wake" 3 "a late wake-up ends the leases before anything is handled, and a lease whose refresh is too late ends";
    LeaseAcknowledged "lease-acknowledged" 3 "a BPRMB that is not acknowledged ends its modify";
    LeaseEndsWithBehavior "lease-ends-with-behavior" 3 "a modify ends when a behavior begins or ends";
    RefreshJudged "refresh-judged" 4 "a modify is judged again at each refresh and each sample of navigation";
    StationJudged "station-judged" 4 "station keeping is judged again at each refresh and each sample of navigation";
    StationCadence "station-cadence" 5 "station keeping is refreshed every 0.5 s; without it, every 1.5 s";
    StationEndSaid "station-end-said" 5 "BPRES is sent at the end of station keeping";
    PluginFailure "plugin-failure" 6 "a plugin's failure ends its leases";
    InheritedInserts "inherited-inserts" 7 "inserts that a previous run left in the vehicle's plan count under the cap";
    #[cfg(feature = "mutations")] // The drivers of the link and the simulation make this check.
    StaleSends "stale-sends" 7 "a link on which a write is not acknowledged for two seconds is reset, and what waits is not delivered";
    NavigationFresh "navigation-fresh" 8 "navigation that is too old does not count";
    NavigationAge "navigation-age" 8 "the age of navigation is counted from its solution; without it, from its arrival";
    RelativeFresh "relative-fresh" 8 "relative navigation that is too old does not count";
    IdentifiersReserved "identifiers-reserved" 9 "an identifier is reserved on disk before it is sent";
    InsertInDoubt "insert-in-doubt" 9 "no insert is sent while an earlier one is in doubt; without it, one is sent if the plan is complete but was asked for before a BPRCA, or within 4 s of the earlier one (every other doubt is settled by the plan for which plan-known waits)";
    InterruptOfInterrupt "interrupt-of-interrupt" 10 "no insert interrupts one that interrupts, or that may be one";
    Shutdown "shutdown" 11 "before the power is switched off, everything is ended and the logs are closed";
    AbortByPolicy "abort-by-policy" 12 "a plugin's failure aborts the mission only if the mission says so (on_failure)";
    ControlLossEndsLease "control-loss-ends-lease" 14 "leases end at once when control is lost";
    ListWithoutControl "list-without-control" 14 "only the messages that SR-014 lists leave without control; without the check, also requests of plugins that do not steer";
    OperatorHold "operator-hold" 15 "after the operator's hold nothing steers until the release; without it, the hold ends and cancels what is open, but plugins may ask again at once";
    HoldCancels "hold-cancels" 15 "the operator's hold cancels our inserts";
    ModemWindow "modem-window" 16 "an acoustic packet leaves only in a window";
    DvlLeave "dvl-leave" 17 "a plugin triggers the DVL only while the vehicle allows it";
    DvlAnswer "dvl-answer" 17 "if a step of the DVL's handshake does not come in time, the runtime ends the handshake";
    SilentTerm "silent-term" 18 "silent mode is not requested while the vehicle may be silent";
    RequestRate "request-rate" 19 "a plugin sends no more requests a second than allowed";
    MessageRate "message-rate" 19 "a plugin writes at most one line a second to the vehicle's log";
    MinuteRate "minute-rate" 19 "no more messages to the topside, and no more packets, are sent in a minute than allowed";
    ModifyRate "modify-rate" 19 "a changed modify is sent at most five times a second";
    InsertsOpen "inserts-open" 19 "no more inserts are open than allowed";
    InsertsTotal "inserts-total" 19 "no more inserts are sent in a mission than allowed";
    InsertsDuration "inserts-duration" 19 "the open inserts together fly no longer than allowed";
    GpsHitsTotal "gps-hits-total" 19 "no more GPS hits are sent in a mission than allowed";
    AdjustmentsTotal "adjustments-total" 19 "no more adjustments of trim and buoyancy are sent in a mission than allowed";
    SilencesTotal "silences-total" 19 "silent mode is requested no more often in a mission than allowed";
    CancelWay "cancel-way" 20 "the way that remains after the cancel of an insert is inside the fence";
    StationReturn "station-return" 20 "the way back to where the mission was suspended is inside the boxes";
    Jump "jump" 21 "after a jump of navigation there is no lease until navigation has been steady for ten seconds";
    RelativeJump "relative-jump" 21 "after a jump of relative navigation there is no station keeping until that navigation has been steady for ten seconds";
    FrameReset "frame-reset" 21 "after an external source moves the vehicle's frame there is no lease in that frame for ten seconds";
    Heard "heard" 23 "nothing dynamic leaves unless the vehicle has answered, in time, a command of the last 3 s";
    LeasePause "lease-pause" 23 "after a BPRMB that the vehicle refused or did not answer, the next modify waits, longer each time";
    IrrevocableAnswered "irrevocable-answered" 23 "a request that nothing can take back leaves only if the vehicle has just answered";
    ClockStep "clock-step" 23 "after a step of the vehicle's clock there is no lease until navigation has been steady for ten seconds";
    NavigationTrue "navigation-true" 24 "nothing steers by navigation that cannot be true over a window of time";
    VelocityPresent "velocity-present" 24 "nothing steers by navigation without velocities";
    DiveIdentity "dive-identity" 25 "when the vehicle names another dive file its plan is forgotten, and nothing steers until the new one is complete";
    ExternalSends "external-sends" 21 "an external source sends only what the mission lets it send";
}

/// Whether a check is made.
#[cfg(not(feature = "mutations"))]
pub(crate) const fn is_on(_: Check) -> bool {
    true
}

/// Computes an answer to a plugin with every check on.
#[cfg(not(feature = "mutations"))]
pub(crate) fn with_every_check<T>(answer: impl FnOnce() -> T) -> T {
    answer()
}

#[cfg(feature = "mutations")]
mod mutation {
    use std::cell::Cell;
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::Check;

    const _: () = assert!(Check::ALL.len() <= 128, "one bit for each check");
    /// One bit for each check that is off.
    static OFF: [AtomicU64; 2] = [AtomicU64::new(0), AtomicU64::new(0)];

    const fn bit(check: Check) -> (usize, u64) {
        (check as usize / 64, 1 << (check as u32 % 64))
    }

    thread_local! {
        /// Whether this thread is computing an answer to a plugin.
        static ANSWERS: Cell<bool> = const { Cell::new(false) };
    }

    /// Whether a check is made.
    #[must_use]
    pub fn is_on(check: Check) -> bool {
        let (word, bit) = bit(check);
        OFF[word].load(Ordering::Relaxed) & bit == 0 || ANSWERS.get()
    }

    /// Computes an answer to a plugin with every check on: a mutation changes what the monitor checks, and not what the
    /// plugin knows.
    pub fn with_every_check<T>(answer: impl FnOnce() -> T) -> T {
        let before = ANSWERS.replace(true);
        let answer = answer();
        ANSWERS.set(before);
        answer
    }

    /// Leaves a check out, in the whole process.
    pub fn leave_out(check: Check) {
        let (word, bit) = bit(check);
        OFF[word].fetch_or(bit, Ordering::Relaxed);
    }

    /// Puts all checks on again.
    pub fn leave_none_out() {
        for word in &OFF {
            word.store(0, Ordering::Relaxed);
        }
    }
}

#[cfg(feature = "mutations")]
pub use mutation::{is_on, leave_none_out, leave_out, with_every_check};

#[cfg(all(test, feature = "mutations"))]
mod tests {
    use std::collections::BTreeSet;

    use super::Check;

    #[test]
    fn each_check_has_its_own_name_and_a_requirement() {
        let names: BTreeSet<&str> = Check::ALL.iter().map(|check| check.name()).collect();
        assert_eq!(names.len(), Check::ALL.len());
        for check in Check::ALL {
            let camel: String = check.name().split('-').map(capitalised).collect();
            assert_eq!(camel, format!("{check:?}"));
            assert!((1..=25).contains(&check.requirement()), "{check:?}");
        }
    }

    /// The parser keeps SR-013, before there is anything to check.
    #[test]
    fn all_requirements_to_023_but_013_and_022_have_a_check() {
        let with: BTreeSet<u32> = Check::ALL.iter().map(|check| check.requirement()).collect();
        let without: Vec<u32> = (1..=23).filter(|requirement| !with.contains(requirement)).collect();
        // The loop around core keeps SR-022.
        assert_eq!(without, [13, 22]);
    }

    fn capitalised(word: &str) -> String {
        let (first, rest) = word.split_at(1);
        format!("{}{rest}", first.to_uppercase())
    }
}
