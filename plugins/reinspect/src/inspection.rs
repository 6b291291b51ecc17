use backseat_sdk::sonar::{Aspects, Sighted, Verdict};
use backseat_sdk::units::EastNorth;
use backseat_sdk::{EndKind, State as Fate};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
/// The time between two requests for the same circle.
const AGAIN_NS: u64 = 5 * SECOND_NS;
/// How often a circle is requested again after the vehicle has failed it or has not flown it.
const TRIES_MAX: u32 = 3;
/// How often a circle is requested again that was refused for a reason which may pass, before the next radius is tried:
/// a minute's worth. The fence that a plugin can ask does not know the way to the circle.
const REFUSALS_MAX: u32 = 12;
/// The sectors around an object.
pub(crate) const SECTORS: usize = 8;
/// From so many pings on a sector counts.
pub(crate) const PINGS_MIN: u32 = 4;
/// A tag is the object's number times this, plus the number of the request.
const TAGS: u64 = 1_000_000;
/// After a restart requests count from this much further on: a lost instance may have made so many.
const SKIPPED: u64 = 100;

/// What has become of a circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Standing {
    /// Not requested yet, or to be requested again.
    Waiting { not_before_ns: u64 },
    /// Requested, and without a final state.
    Open { tag: u64, started_ns: Option<u64> },
    /// Flown.
    Flown,
    /// Given up.
    Dropped,
}

/// An object with its circle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Inspection {
    /// The object's number in the list of sightings.
    pub(crate) number: u32,
    pub(crate) at: EastNorth,
    pub(crate) latitude_deg: f64,
    pub(crate) longitude_deg: f64,
    pub(crate) height_m: f64,
    /// Which of the configured radii is tried.
    pub(crate) radius: usize,
    pub(crate) standing: Standing,
    pub(crate) aspects: Aspects,
    asked: u64,
    tries: u32,
    refusals: u32,
}

/// What an outcome means for a circle, for the log.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Nothing worth a line.
    Quiet,
    /// The vehicle has begun to fly it.
    Began,
    /// It has been flown, and this is what it showed.
    Flown(Verdict),
    /// It will be requested again; with the reason.
    Again(String),
    /// The next radius will be tried; with the reason.
    Radius(String),
    /// It is given up; with the reason.
    Dropped(String),
}

/// All circles, in the order in which they were first requested.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Inspections {
    pub(crate) list: Vec<Inspection>,
    /// Open tags that belong to no circle of this instance.
    pub(crate) strays: Vec<u64>,
    /// From where the requests for a new circle count.
    skipped: u64,
}

impl Inspection {
    fn new(object: &Sighted, tolerance_m: f64, asked: u64) -> Self {
        Self {
            number: object.number,
            at: object.at,
            latitude_deg: object.latitude_deg,
            longitude_deg: object.longitude_deg,
            height_m: object.height_m,
            radius: 0,
            standing: Standing::Waiting { not_before_ns: 0 },
            aspects: Aspects::new(object.at, tolerance_m + 0.5 * object.length_m, SECTORS),
            asked,
            tries: 0,
            refusals: 0,
        }
    }

    /// Makes it open, under the tag that it returns.
    pub(crate) fn ask(&mut self) -> u64 {
        self.asked = (self.asked + 1) % TAGS;
        let tag = u64::from(self.number) * TAGS + self.asked;
        self.standing = Standing::Open { tag, started_ns: None };
        tag
    }

    fn wait(&mut self, now_ns: u64) {
        self.standing = Standing::Waiting {
            not_before_ns: now_ns + AGAIN_NS,
        };
    }

    fn fail(&mut self, why: &str, now_ns: u64) -> Turn {
        self.tries += 1;
        if self.tries >= TRIES_MAX {
            return self.give_up(why);
        }
        self.wait(now_ns);
        Turn::Again(why.to_owned())
    }

    /// Goes on to the next of `radii` radii.
    pub(crate) fn next_radius(&mut self, why: &str, radii: usize) -> Turn {
        self.radius += 1;
        self.refusals = 0;
        if self.radius >= radii {
            return self.give_up(why);
        }
        self.standing = Standing::Waiting { not_before_ns: 0 };
        Turn::Radius(why.to_owned())
    }

    fn give_up(&mut self, why: &str) -> Turn {
        self.standing = Standing::Dropped;
        Turn::Dropped(why.to_owned())
    }

    /// Takes in the outcome of its request. `radii` is how many radii there are, `misfits` whether the fence refuses this
    /// one.
    fn hear(&mut self, fate: &Fate, now_ns: u64, control: bool, radii: usize, misfits: impl FnOnce() -> bool) -> Turn {
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Unknown => Turn::Quiet,
            Fate::Started => {
                if let Standing::Open { started_ns, .. } = &mut self.standing {
                    *started_ns = Some(now_ns);
                }
                Turn::Began
            }
            Fate::Ended(end) => {
                let verdict = self.aspects.verdict(PINGS_MIN);
                // An end that somebody else made may still have come after most of the circle.
                if end.kind == EndKind::Done || verdict.looked as usize * 2 >= SECTORS {
                    self.standing = Standing::Flown;
                    Turn::Flown(verdict)
                } else {
                    self.fail(&format!("ended too early: {}", end.text), now_ns)
                }
            }
            Fate::Failed(_) => self.fail(fate.reason().unwrap_or_default(), now_ns),
            Fate::TimedOut => self.fail("the vehicle did not answer", now_ns),
            Fate::Cancelled => self.fail("cancelled", now_ns),
            Fate::Rejected(why) if !control => {
                self.wait(now_ns);
                Turn::Again(why.text.clone())
            }
            Fate::Rejected(why) => {
                self.refusals += 1;
                if misfits() || self.refusals >= REFUSALS_MAX {
                    return self.next_radius(&why.text, radii);
                }
                self.wait(now_ns);
                if self.refusals == 1 {
                    Turn::Again(why.text.clone())
                } else {
                    Turn::Quiet
                }
            }
        }
    }
}

impl Inspections {
    /// Adds a circle for an object, and returns its index.
    pub(crate) fn add(&mut self, object: &Sighted, tolerance_m: f64) -> usize {
        self.list.push(Inspection::new(object, tolerance_m, self.skipped));
        self.list.len() - 1
    }

    /// Whether a place is within a distance of one that was inspected, will be, or was given up.
    pub(crate) fn near(&self, at: EastNorth, apart_m: f64) -> bool {
        self.list
            .iter()
            .any(|inspection| inspection.at.distance_m(at) < apart_m)
    }

    /// How many circles were flown, or may be.
    pub(crate) fn counted(&self) -> usize {
        let counts = |inspection: &&Inspection| inspection.standing != Standing::Dropped;
        self.list.iter().filter(counts).count() + self.strays.len()
    }

    /// Whether a circle is requested that the vehicle has not begun. One at a time.
    pub(crate) fn is_queued(&self) -> bool {
        !self.strays.is_empty()
            || self
                .list
                .iter()
                .any(|inspection| matches!(inspection.standing, Standing::Open { started_ns: None, .. }))
    }

    /// The circle that waits to be requested.
    pub(crate) fn waiting(&self) -> Option<(usize, u64)> {
        self.list
            .iter()
            .enumerate()
            .find_map(|(index, inspection)| match inspection.standing {
                Standing::Waiting { not_before_ns } => Some((index, not_before_ns)),
                Standing::Open { .. } | Standing::Flown | Standing::Dropped => None,
            })
    }

    /// The circle that the vehicle flies.
    pub(crate) fn flown_now(&mut self) -> Option<&mut Inspection> {
        self.list.iter_mut().find(|inspection| {
            matches!(
                inspection.standing,
                Standing::Open {
                    started_ns: Some(_),
                    ..
                }
            )
        })
    }

    /// The circle that is open under a tag.
    pub(crate) fn of(&self, tag: u64) -> Option<usize> {
        self.list
            .iter()
            .position(|inspection| matches!(inspection.standing, Standing::Open { tag: open, .. } if open == tag))
    }

    /// Takes in the outcome of a request. `misfits` says whether the fence refuses a circle.
    pub(crate) fn hear(
        &mut self,
        tag: u64,
        fate: &Fate,
        now_ns: u64,
        control: bool,
        radii: usize,
        misfits: impl FnOnce(&Inspection) -> bool,
    ) -> Option<(usize, Turn)> {
        let is_open = matches!(
            fate,
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown
        );
        if !is_open {
            self.strays.retain(|stray| *stray != tag);
        }
        let index = self.of(tag)?;
        let fits_not = matches!(fate, Fate::Rejected(_)) && control && misfits(&self.list[index]);
        let turn = self.list[index].hear(fate, now_ns, control, radii, || fits_not);
        Some((index, turn))
    }

    /// Compares what a new instance believes to be open with what is open: a tag says which object it is for. Open tags of
    /// objects that this instance does not know become strays, which the plugin cancels.
    pub(crate) fn restored(&mut self, open: &[u64], now_ns: u64) {
        for inspection in &mut self.list {
            if let Standing::Open { tag, started_ns } = inspection.standing
                && !open.contains(&tag)
            {
                // Its end was missed. What had begun counts as flown.
                if started_ns.is_some() {
                    inspection.standing = Standing::Flown;
                } else {
                    inspection.wait(now_ns);
                }
            }
        }
        self.strays.clear();
        for tag in open.iter().copied() {
            if self.of(tag).is_some() {
                continue;
            }
            let number = tag / TAGS;
            match self.list.iter_mut().find(|inspection| {
                u64::from(inspection.number) == number && matches!(inspection.standing, Standing::Waiting { .. })
            }) {
                Some(inspection) => {
                    inspection.asked = tag % TAGS;
                    inspection.standing = Standing::Open { tag, started_ns: None };
                }
                None => self.strays.push(tag),
            }
        }
        // Tags that were used and have ended since the snapshot must not be used again.
        self.skipped = (self.skipped + SKIPPED) % TAGS;
        for inspection in &mut self.list {
            inspection.asked = (inspection.asked + SKIPPED) % TAGS;
        }
    }
}

#[cfg(test)]
mod tests {
    use backseat_sdk::sonar::{Contact, Side, Sightings};
    use backseat_sdk::{Ended, Refusal, Rule};

    use super::*;

    fn sighted(places: &[EastNorth]) -> Inspections {
        let mut sightings = Sightings::new(4.0, 50);
        for at in places {
            sightings.add(&Contact {
                side: Side::Port,
                at: *at,
                latitude_deg: 42.0,
                longitude_deg: -70.0,
                from: *at + EastNorth::new(30.0, 0.0),
                ground_m: 30.0,
                slant_m: 31.0,
                highlight_m: 1.0,
                shadow_m: 3.0,
                height_m: 1.0,
                cut: false,
                length_m: 2.0,
                pings: 10,
                score: 30.0,
            });
        }
        let mut inspections = Inspections::default();
        for object in sightings.objects() {
            inspections.add(object, 4.0);
        }
        inspections
    }

    fn two() -> Inspections {
        sighted(&[EastNorth::new(0.0, 0.0), EastNorth::new(100.0, 0.0)])
    }

    fn hear(inspections: &mut Inspections, tag: u64, fate: &Fate, misfits: bool) -> Turn {
        inspections
            .hear(tag, fate, SECOND_NS, true, 2, |_| misfits)
            .map_or(Turn::Quiet, |(_, turn)| turn)
    }

    #[test]
    fn a_refused_circle_is_tried_with_every_radius_and_then_given_up() {
        let mut inspections = two();
        let no = Fate::Rejected(Refusal::new(Rule::KeepIn, "keep-in"));
        let tag = inspections.list[0].ask();
        assert!(matches!(hear(&mut inspections, tag, &no, true), Turn::Radius(_)));
        assert_eq!((inspections.list[0].radius, inspections.waiting()), (1, Some((0, 0))));
        let tag = inspections.list[0].ask();
        assert!(matches!(hear(&mut inspections, tag, &no, true), Turn::Dropped(_)));
        assert_eq!(inspections.waiting(), Some((1, 0)));
        assert!(
            inspections.near(EastNorth::new(5.0, 0.0), 15.0),
            "it is not tried again as another object"
        );
    }

    #[test]
    fn a_passing_refusal_is_waited_for_a_bounded_number_of_times() {
        let mut inspections = two();
        let no = Fate::Rejected(Refusal::new(Rule::Plan, "plan unknown"));
        let mut asked = 0;
        while inspections.list[0].standing != Standing::Dropped {
            let tag = inspections.list[0].ask();
            asked += 1;
            hear(&mut inspections, tag, &no, false);
            assert!(asked < 100);
        }
        assert_eq!(asked, 2 * REFUSALS_MAX);
    }

    #[test]
    fn a_circle_that_ended_too_early_is_flown_again_and_three_failures_end_it() {
        let mut inspections = two();
        for attempt in 1..=3 {
            let tag = inspections.list[0].ask();
            assert!(inspections.is_queued());
            hear(&mut inspections, tag, &Fate::Started, false);
            assert!(!inspections.is_queued() && inspections.flown_now().is_some());
            let turn = hear(
                &mut inspections,
                tag,
                &Fate::Ended(Ended::new(EndKind::Control, "lost")),
                false,
            );
            assert_eq!(matches!(turn, Turn::Dropped(_)), attempt == 3, "{turn:?}");
        }
    }

    #[test]
    fn a_new_instance_knows_circles_by_their_tags() {
        let mut inspections = two();
        let first = inspections.list[0].ask();
        hear(&mut inspections, first, &Fate::Started, false);
        // Since the snapshot the first circle has ended, the second was requested, and so was one of an object that
        // nobody here knows.
        inspections.restored(&[2_000_001, 7_000_001], SECOND_NS);
        assert_eq!(inspections.list[0].standing, Standing::Flown);
        assert_eq!(
            (inspections.of(2_000_001), inspections.strays.as_slice()),
            (Some(1), &[7_000_001][..])
        );
        hear(&mut inspections, 7_000_001, &Fate::Cancelled, false);
        hear(&mut inspections, 2_000_001, &Fate::TimedOut, false);
        assert!(inspections.strays.is_empty());
        assert!(inspections.list[1].ask() > 2_000_002);
    }
}
