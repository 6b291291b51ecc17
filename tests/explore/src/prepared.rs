use std::time::Duration;

use backseat_units::Timestamp;
use clap::ValueEnum;
use serde::Serialize;

use crate::front::Answers;
use crate::kind::Kind;
use crate::world::World;

/// So long after the plugin was called a kind happens: what it has asked for has left, and is not answered.
const BEHIND_PLUGIN: Duration = Duration::from_millis(100);

/// A state from which all sequences are tried. Each is reached from the start, by inputs alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Prepared {
    /// The plugin steers by a modify.
    Lease,
    /// A trackline has left and is not answered.
    InsertSent,
    /// The vehicle says that it works on a trackline.
    InsertPending,
    /// The vehicle flies our trackline.
    InsertFlown,
    /// The vehicle flies our trackline that has interrupted its plan.
    Interrupting,
    /// The vehicle flies another dive, whose plan has been asked for.
    PlanAsked,
    /// The operator holds, and has ended a modify.
    Held,
    /// The link is lost, and whether a trackline was accepted is not known.
    InsertUnknown,
    /// The process before was killed while a trackline of its waited.
    AfterKill,
    /// The plugin has a hovering vehicle keep its station.
    Hovering,
}

impl Prepared {
    /// All of them.
    #[must_use]
    pub fn all() -> &'static [Self] {
        Self::value_variants()
    }

    /// Its name on the command line, `insert-sent`.
    #[must_use]
    pub fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(|| format!("{self:?}"), |value| value.get_name().to_owned())
    }

    /// What leads to it once the vehicle is under way.
    const fn script(self) -> &'static [Kind] {
        use Kind as K;
        match self {
            Self::Lease => &[K::AsksModify, K::Wait, K::Wait],
            Self::InsertSent => &[K::AsksInsert],
            Self::InsertPending => &[K::AnswersPending, K::AsksInsert, K::Wait],
            Self::InsertFlown => &[K::AsksInsert, K::Wait, K::BehaviorEnds, K::Wait],
            Self::Interrupting => &[K::AsksInterrupt, K::Wait, K::Wait],
            Self::PlanAsked => &[K::AnswersPending, K::OtherDive],
            Self::Held => &[K::AsksModify, K::Wait, K::Hold],
            Self::InsertUnknown => &[K::AsksInsert, K::LinkDown],
            Self::AfterKill => &[K::AsksInsert, K::Wait],
            Self::Hovering => &[K::AsksStation, K::Wait, K::Wait],
        }
    }

    /// The state.
    ///
    /// # Panics
    /// Where a requirement is broken on the way to it.
    #[must_use]
    pub fn world(self) -> World {
        self.world_after(Duration::ZERO)
    }

    /// The same state so much later: a time of day and all numbers apart, nothing tells it from the other.
    ///
    /// # Panics
    /// As [`Prepared::world`].
    #[must_use]
    pub fn world_after(self, later: Duration) -> World {
        let mut world = World::new(self == Self::Hovering);
        world.run_until(Timestamp::from_secs(5));
        world.front.behavior_ends(world.now);
        // Over a minute later nothing of the start counts any more.
        world.run_until(Timestamp::from_secs(75) + later);
        align(&mut world);
        for kind in self.script() {
            world
                .step(*kind)
                .unwrap_or_else(|broken| panic!("{}: {broken}", self.name()));
        }
        // What is asked for from now on is answered at once again.
        world.front.answers = Answers::Good;
        if self == Self::AfterKill {
            world.kill(1);
            world.run_until(world.now + Duration::from_secs(3));
            align(&mut world);
        }
        world
    }
}

/// To just behind a step of the plugin's.
fn align(world: &mut World) {
    let before = world.invoked;
    while world.invoked == before {
        world.run_until(world.now + Duration::from_millis(10));
    }
    world.run_until(world.invoked + BEHIND_PLUGIN);
}
