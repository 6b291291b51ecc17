//! States that refuse a request.

use serde::{Deserialize, Serialize};

use super::Rule;

/// A row for each reason: its name in logs, its rule, its text.
macro_rules! reasons {
    ($(#[$doc_of_all:meta])* $all:ident; $($reason:ident $name:literal $rule:ident $text:literal;)*) => {
        $(#[$doc_of_all])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $all {
            $(#[doc = $text] $reason,)*
        }

        impl $all {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$reason),*];

            /// Its name in logs and for plugins, in lower case with hyphens.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$reason => $name,)* }
            }

            /// The rule that refuses a request for this reason.
            #[must_use]
            pub const fn rule(self) -> Rule {
                match self { $(Self::$reason => Rule::$rule,)* }
            }

            /// The reason in one line.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self { $(Self::$reason => $text,)* }
            }
        }
    };
}

reasons! {
    /// Why requests cannot be sent.
    Uncontrolled;
    LinkDown "link-down" Control "the link is down";
    RunEnding "run-ending" Control "the run is ending";
    OperatorHolds "operator-holds" Control "the operator's hold is set";
    OperatorEnded "operator-ended" Control "the operator has ended the mission";
    ControlUnknown "control-unknown" Control "the vehicle has not said who has control";
    VehicleHasControl "vehicle-has-control" Control "the vehicle has control";
    MissionUnknown "mission-unknown" Control "the vehicle has not said whether its mission runs";
    MissionNotRunning "mission-not-running" Control "the mission is not running";
    PlanNotCompared "plan-not-compared" Control "the vehicle's plan has not been compared with the one that was checked";
    PlanDiffers "plan-differs" Control "the vehicle's plan is not the one that was checked";
    DivePlanUnknown "dive-plan-unknown" Control "the plan of this dive is not known yet";
    NotAnsweredYet "not-answered-yet" Control "the vehicle has not answered yet";
    NotAnsweredInTime "not-answered-in-time" Control "the vehicle does not answer in time";
    NavigationStale "navigation-stale" Control "navigation is stale";
    NavigationUnsteady "navigation-unsteady" Control "navigation has not been steady for long enough";
    NotArmed "not-armed" Control "the runtime is not armed";
    NotSent "not-sent" Control "it could not be sent";
    LinkDownTooLong "link-down-too-long" Control "the link was down for too long: give the order again";
}

reasons! {
    /// A state of the vehicle, of the runtime or of an earlier request that refuses a request.
    Reason;
    OutsideFence "outside-fence" Recovery "the vehicle is outside the fence";
    NavigationIsStale "navigation-is-stale" Navigation "navigation is stale";
    NavigationMissing "navigation-missing" Navigation "no navigation";
    RelativeStale "relative-stale" Navigation "relative navigation is stale";
    BoxesUnknown "boxes-unknown" Navigation "neither BFRNV with a hull_box nor BFCNV with a bottom_box is fresh and steady";
    HullPlaceUnknown "hull-place-unknown" Navigation "a move on the hull needs fresh BFRNV";
    BottomPlaceUnknown "bottom-place-unknown" Navigation "a move over the bottom needs fresh BFCNV";
    HullStopUnknown "hull-stop-unknown" Navigation "a stop on the hull needs fresh BFRNV";
    BottomStopUnknown "bottom-stop-unknown" Navigation "a stop over the bottom needs fresh BFCNV";
    BottomUnknown "bottom-unknown" Station "height above the bottom unknown: expected bottom lock or water_depth_min_m";
    WaterDepthUnknown "water-depth-unknown" Altitude "an altitude needs bottom lock or the mission's water_depth_max_m";
    SuspensionUnknown "suspension-unknown" Station "the place where the mission was suspended, to which BPRES may lead back, is unknown in this frame";
    NoStationLimits "no-station-limits" Limit "the mission has no [limits.station]";
    NoHullBox "no-hull-box" Station "the mission has no [limits.station.hull_box]";
    NoBottomBox "no-bottom-box" Station "the mission has no [limits.station.bottom_box]";
    NoSonarAngle "no-sonar-angle" Limit "[limits.station] has no sonar_angle_min_deg and sonar_angle_max_deg";
    PlanUnknown "plan-unknown" Plan "plan unknown: cannot check the return path";
    PlanUnknownForInsert "plan-unknown-for-insert" Plan "plan unknown: cannot check the way to the insert";
    PlanUnknownNext "plan-unknown-next" Plan "plan unknown: cannot check the way to what comes next";
    FlownUnheard "flown-unheard" Plan "current behavior unknown: no begin was heard, nor has the vehicle followed a line of its plan for 10 s with no insert open";
    FlownNotPlanned "flown-not-planned" Plan "the current behavior is neither in the plan nor an open insert of this run: cannot check the return path";
    BeginUnheard "begin-unheard" Plan "current behavior unknown: cannot check the way to the insert";
    TakenUpUnheard "taken-up-unheard" Plan "it is unknown where the planned behavior began that the vehicle may resume: cannot check the return path";
    TakenUpForeign "taken-up-foreign" Plan "the vehicle may resume another payload's insert: cannot check the return path";
    OtherSteers "other-steers" Priority "a plugin of higher priority steers";
    OtherKeepsStation "other-keeps-station" Priority "a plugin of higher priority keeps the vehicle at its station";
    OtherSilences "other-silences" Priority "another plugin has asked for the silence";
    OtherTriggers "other-triggers" Priority "another plugin has asked for the DVL's trigger";
    TagOpen "tag-open" Tag "an insert with this tag is still open";
    TagUnknown "tag-unknown" Tag "no insert with this tag is open";
    TagBegun "tag-begun" Tag "the insert has begun and can no longer be cancelled (SPI 7.8)";
    TagIsGpsHit "tag-is-gps-hit" Tag "a GPS hit cannot be cancelled: BPRCN covers tracklines and trackcircles only (SPI 7.8)";
    TriggerOpen "trigger-open" Tag "this plugin's request for the trigger is still open";
    InterruptOpen "interrupt-open" Interrupt "an insert that interrupts is open, and no other may interrupt it (SPI 7.5)";
    InterruptPreviousRun "interrupt-previous-run" Interrupt "an insert of a previous run may be in progress, and may be one that no other may interrupt (SPI 7.5)";
    InterruptForeign "interrupt-foreign" Interrupt "an insert that is not ours is in progress, and may be one that no other may interrupt (SPI 7.5)";
    InsertInDoubt "insert-in-doubt" Doubt "it is unknown whether the vehicle has an earlier insert";
    GpsHitFlown "gps-hit-flown" GpsHit "a GPS hit may be in progress, and the vehicle would surface wherever this request leads it";
    StateMissing "state-missing" Identifier "the identifiers' state on disk is missing";
    IdentifierNotReserved "identifier-not-reserved" Identifier "no identifier is reserved on disk yet";
    InsertNotReserved "insert-not-reserved" Identifier "no insert is reserved on disk yet";
    EntryAngleUnread "entry-angle-unread" Layout "the mission does not say that the vehicle reads a circle's entry angle (vehicle.trackcircle_entry_angle)";
    InterruptCodeUnplaced "interrupt-code-unplaced" Layout "the mission does not say where the vehicle reads a circle's interrupt code (vehicle.trackcircle_entry_angle)";
    ModifyPause "modify-pause" Pause "the vehicle refused or did not answer the last BPRMB: no modify is sent";
    NotAnswered "not-answered" Heard "the vehicle did not answer within 1 s, and nothing can take this request back once it is sent (SPI 7.8)";
    PluginFailed "plugin-failed" Plugin "its plugin failed before it was sent";
    NoWindow "no-window" Window "no acoustic window is open, or it ends too soon (SPI 9.1)";
    WindowsUnsubscribed "windows-unsubscribed" Window "the vehicle has not acknowledged the subscription to BFCMA";
    ReportsUnsubscribed "reports-unsubscribed" Window "the vehicle has not acknowledged the subscription to BFCPS";
    TextEmpty "text-empty" Text "the text is empty";
    TextHoldsSentence "text-holds-sentence" Text "the text contains $BP: a vehicle that searches for sentences could take what follows for a command";
    VehicleSilent "vehicle-silent" State "the vehicle is in silent mode (SPI 7.22)";
    VehicleNotSilent "vehicle-not-silent" State "the vehicle is not silent";
    AlreadySilent "already-silent" State "the vehicle may be silent, and a new request would not extend that (SPI 7.22)";
    SilenceUnanswered "silence-unanswered" State "the vehicle has not answered the last BPSIL";
    AcknowledgementsOff "acknowledgements-off" State "the vehicle's acknowledgements are not on (SPI 7.22)";
    TrimUnsubscribed "trim-unsubscribed" State "the vehicle has not confirmed the subscription to BFTRM";
    BuoyancyUnsubscribed "buoyancy-unsubscribed" State "the vehicle has not confirmed the subscription to BFBOY";
    AdjustmentUnderWay "adjustment-under-way" State "an adjustment of this kind is under way";
    TriggeringNotAllowed "triggering-not-allowed" State "the vehicle does not allow triggering now (BFDVT, SPI 7.4)";
    TriggerEnding "trigger-ending" State "the plugin is already ending the triggering";
    NothingToEnd "nothing-to-end" State "there is no open request to end";
    NotOfItsOwn "not-of-its-own" State "it is not a request with an outcome of its own";
    CurrentUnknown "current-unknown" State "the current behavior is not known to be an insert of ours";
    CurrentForeign "current-foreign" State "the current behavior is an insert that is not ours";
    MissionRunning "mission-running" State "a mission is running";
    MissionEnding "mission-ending" State "a mission is ending";
    NoMission "no-mission" State "no mission is running";
    MissionStateUnknown "mission-state-unknown" State "the vehicle has not said whether a mission runs";
    EmptyMissionStarting "empty-mission-starting" State "an empty mission is already being started";
    EndingUnderWay "ending-under-way" State "an order of this kind is already under way";
    FixForced "fix-forced" Limit "the mission does not let this external source force a fix";
    NoSonar "no-sonar" State "the mission has no [sonar]";
    SensorUnknown "sensor-unknown" Limit "the mission has no [[sonar.sensor]] of this index";
    SonarNotReady "sonar-not-ready" State "the payload controller is not connected, or not set up yet";
    SonarBusy "sonar-busy" Cap "too many requests to the payload controller wait for their outcome";
    PowerGoing "power-going" State "the power is being switched off";
    NotInStep "not-in-step" State "the fence answers only within a step";
    Undecided "undecided" State "nothing has been decided yet";
    NotExternal "not-external" Limit "an external source may not send this sentence";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_the_same_in_the_log() {
        for reason in Reason::ALL {
            assert_eq!(serde_json::to_value(reason).unwrap(), reason.name());
        }
        for reason in Uncontrolled::ALL {
            assert_eq!(serde_json::to_value(reason).unwrap(), reason.name());
        }
        let names = Reason::ALL.iter().map(|reason| reason.name());
        let mut names: Vec<_> = names
            .chain(Uncontrolled::ALL.iter().map(|reason| reason.name()))
            .collect();
        names.sort_unstable();
        let all = names.len();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}
