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
    expect(unreachable_pub, reason = "they are public where there are mutations")
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
    ControlGiven "control-given" 1 "nothing dynamic leaves once the vehicle has said that control is its own";
    ControlKnown "control-known" 1 "nothing dynamic leaves before the vehicle has said, on this connection, who has control and that its mission runs";
    MissionRuns "mission-runs" 1 "nothing dynamic leaves while the vehicle says that its mission does not run";
    InsertFence "insert-fence" 2 "an insert's geometry, the way to it and the way on from it are inside the fence";
    InsertShape "insert-shape" 2 "an insert's own geometry is inside the fence";
    InsertWayTo "insert-way-to" 2 "the way to an insert is inside the fence";
    InsertWayOn "insert-way-on" 2 "the way from an insert to what comes next is inside the fence";
    Surfacing "surfacing" 2 "a GPS hit is where the fence lets the vehicle surface, drift and all";
    ModifyFence "modify-fence" 2 "all that a modify can lead to is inside the fence, the ways back to the plan too";
    ModifyWayBack "modify-way-back" 2 "the ways back from a modify to the plan are inside the fence";
    PlanKnown "plan-known" 2 "nothing that leads away from the plan is sent while the plan is not known";
    SpeedLimits "speed-limits" 2 "a speed is within the mission's";
    BottomKnown "bottom-known" 2 "an altitude is set only where the water's depth is known";
    StationBox "station-box" 2 "a vehicle that keeps its station and its way are inside the boxes, and outside of what is to be kept out of";
    RefreshCadence "refresh-cadence" 3 "a live lease is refreshed each second; without it, each four";
    LeaseEndSaid "lease-end-said" 3 "the end of a lease is said by BPEMB";
    LateWake "late-wake" 3 "a wake-up that is late ends the leases before anything is handled, and one that has waited too long is not refreshed";
    LeaseAcknowledged "lease-acknowledged" 3 "a refresh that is not acknowledged ends its lease";
    LeaseEndsWithBehavior "lease-ends-with-behavior" 3 "a lease ends where a behavior begins or ends under it";
    RefreshJudged "refresh-judged" 4 "a lease is judged anew at each refresh and each sample of navigation";
    StationJudged "station-judged" 4 "station keeping is judged anew at each refresh and each sample of navigation";
    StationCadence "station-cadence" 5 "station keeping is refreshed each half second; without it, each one and a half";
    StationEndSaid "station-end-said" 5 "the end of station keeping is said by BPRES";
    PluginFailure "plugin-failure" 6 "a plugin's failure ends its leases";
    InheritedInserts "inherited-inserts" 7 "what a previous run has left in the vehicle's plan counts under the cap";
    #[cfg(feature = "mutations")] // The drivers of the link and the simulation make this check.
    StaleSends "stale-sends" 7 "a link whose write has waited for a second is reset, and what waited is not delivered";
    NavigationFresh "navigation-fresh" 8 "navigation that is too old is none";
    NavigationAge "navigation-age" 8 "navigation's age is counted from its solution; without it, from its arrival";
    RelativeFresh "relative-fresh" 8 "relative navigation that is too old is none";
    IdentifiersReserved "identifiers-reserved" 9 "an identifier is reserved on disk before it is sent";
    InsertInDoubt "insert-in-doubt" 9 "no insert is sent while the vehicle has not answered for an earlier one";
    InterruptOfInterrupt "interrupt-of-interrupt" 10 "nothing interrupts an insert that interrupts";
    Shutdown "shutdown" 11 "before power goes all is ended and the logs are closed";
    AbortByPolicy "abort-by-policy" 12 "a plugin's failure aborts the mission only where the operator has said so";
    ControlLossEndsLease "control-loss-ends-lease" 14 "leases end at once when control is lost";
    ListWithoutControl "list-without-control" 14 "without control nothing is said that is not on the list";
    OperatorHold "operator-hold" 15 "the operator's hold stands until it is released";
    HoldCancels "hold-cancels" 15 "the operator's hold cancels our inserts";
    ModemWindow "modem-window" 16 "an acoustic packet leaves only in a window";
    DvlLeave "dvl-leave" 17 "the DVL is triggered only by the vehicle's leave";
    DvlAnswer "dvl-answer" 17 "where a plugin does not answer for the DVL in time, the runtime does";
    SilentTerm "silent-term" 18 "silent mode is not asked for while the vehicle may be silent";
    RequestRate "request-rate" 19 "so many requests of a plugin a second, and no more";
    MessageRate "message-rate" 19 "one line a second of a plugin in the vehicle's log";
    MinuteRate "minute-rate" 19 "so many messages to the topside and packets a minute, and no more";
    ModifyRate "modify-rate" 19 "a changed modify is sent five times a second at most";
    InsertsOpen "inserts-open" 19 "so many inserts are open, and no more";
    InsertsTotal "inserts-total" 19 "so many inserts in a mission, and no more";
    InsertsDuration "inserts-duration" 19 "the open inserts fly for so long together, and no longer";
    GpsHitsTotal "gps-hits-total" 19 "so many GPS hits in a mission, and no more";
    AdjustmentsTotal "adjustments-total" 19 "so many adjustments of trim and buoyancy in a mission, and no more";
    SilencesTotal "silences-total" 19 "silent mode so often in a mission, and no more";
    CancelWay "cancel-way" 20 "the way that remains when an insert is cancelled is inside the fence";
    StationReturn "station-return" 20 "the way back to where the mission was suspended is inside the boxes";
    Jump "jump" 21 "a jump of navigation ends leases until it has been steady for ten seconds";
    RelativeJump "relative-jump" 21 "a jump of relative navigation ends station keeping until it has been steady for ten seconds";
    FrameReset "frame-reset" 21 "what moves the vehicle's frame ends leases until ten seconds have passed";
    Heard "heard" 23 "nothing dynamic leaves unless the vehicle has answered in time within the last 3 s";
    LeasePause "lease-pause" 23 "after a BPRMB that the vehicle refused or did not answer the next lease waits, and longer each time";
    IrrevocableAnswered "irrevocable-answered" 23 "what nothing takes back leaves only where the vehicle has just answered";
    ClockStep "clock-step" 23 "a clock that is set ends leases until navigation has been steady for ten seconds";
    NavigationTrue "navigation-true" 24 "navigation that cannot be true over a window steers nothing";
    VelocityPresent "velocity-present" 24 "navigation without velocities steers nothing";
    DiveIdentity "dive-identity" 25 "another dive file means another plan, and nothing steers until it is whole";
    ExternalSends "external-sends" 21 "an external source sends only what the mission lets it";
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

    const _: () = assert!(Check::ALL.len() <= 128, "a bit for each");
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
    fn each_check_has_a_name_of_its_own_and_a_requirement() {
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
    fn every_requirement_that_a_check_keeps_has_a_mutation() {
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
