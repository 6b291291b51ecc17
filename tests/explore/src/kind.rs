use clap::ValueEnum;
use serde::Serialize;

/// What reaches core from outside. Each takes a second: it happens at its beginning, and then the vehicle, the link, the
/// plugin and core's own timers go on. What a plugin asks leaves 0.1 s before the second's end and is answered 0.25 s
/// later, so that the next input comes between the two. What begins lasts until another kind ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
pub enum Kind {
    /// Nothing happens.
    Wait,
    /// Nothing happens for ten seconds: navigation has been steady after that.
    WaitTen,
    /// The vehicle gives control (BFCTL 1).
    ControlGiven,
    /// The vehicle takes control (BFCTL 0).
    ControlTaken,
    /// The vehicle's mission runs (BFMIS).
    MissionRuns,
    /// The vehicle's mission is aborted (BFMIS `Aborting`).
    MissionAborts,
    /// Navigation comes each second, and is as old as its way.
    NavigationGood,
    /// Navigation comes, but its solution is the same.
    NavigationStale,
    /// Navigation does not come.
    NavigationMissing,
    /// Navigation jumps: to a place 6 m from the fence's margin, or from there and from outside back to where it was.
    NavigationJumps,
    /// Navigation jumps to a place outside the fence.
    NavigationOutside,
    /// From now on the vehicle accepts what it is sent.
    AnswersGood,
    /// From now on the vehicle refuses what it is sent, BPLOG and BPSTS apart.
    AnswersBad,
    /// From now on the vehicle says that it works on what it is sent, and accepts it 2.2 s after it was sent.
    AnswersPending,
    /// From now on the vehicle does what it is sent, and answers nothing.
    AnswersMissing,
    /// From now on the vehicle hears nothing.
    Deaf,
    /// The connection is lost, and cannot be made.
    LinkDown,
    /// The connection can be made.
    LinkUp,
    /// The plugin asks for a modify to the north, for 30 s.
    AsksModify,
    /// The plugin ends its modify.
    AsksEnd,
    /// The plugin asks for a trackline.
    AsksInsert,
    /// The plugin asks for a trackline that interrupts what is flown.
    AsksInterrupt,
    /// The plugin asks for a trackline outside the fence.
    AsksOutside,
    /// The plugin cancels its newest trackline that does not interrupt.
    AsksCancel,
    /// The plugin's step fails.
    PluginFails,
    /// Core is not called until 0.6 s after it had wished to be.
    WakesLate,
    /// The operator holds.
    Hold,
    /// The operator releases.
    Release,
    /// What is flown ends, and what comes next begins (BFMBE, BFMBS).
    BehaviorEnds,
    /// The vehicle flies another dive, from its first behavior (BFMIS, BFMBS).
    OtherDive,
    /// The plugin asks a hovering vehicle to keep its station, for 30 s.
    AsksStation,
}

impl Kind {
    /// All of them; the last is for vehicles that hover.
    #[must_use]
    pub fn all(hovers: bool) -> Vec<Self> {
        let all = Self::value_variants().iter().copied();
        all.filter(|kind| hovers || *kind != Self::AsksStation).collect()
    }

    /// Its name on the command line, `asks-modify`.
    #[must_use]
    pub fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(|| format!("{self:?}"), |value| value.get_name().to_owned())
    }
}
