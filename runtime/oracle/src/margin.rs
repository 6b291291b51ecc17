use serde::Serialize;
use serde::ser::SerializeMap as _;

/// Which side of what is allowed is the safe one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// The figure must not be above what is allowed.
    Most,
    /// The figure must not be below what is allowed.
    Least,
}

macro_rules! margins {
    ($($(#[$doc:meta])* $Variant:ident = $name:literal, $title:literal, $requirement:literal, $unit:literal, $bound:ident;)*) => {
        /// A figure that shows how near a run came to what a safety requirement forbids.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Margin { $($(#[$doc])* $Variant,)* }

        impl Margin {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$Variant),*];

            /// Its name in reports.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$Variant => $name,)* }
            }

            /// What it is.
            #[must_use]
            pub const fn title(self) -> &'static str {
                match self { $(Self::$Variant => $title,)* }
            }

            /// The safety requirement that it belongs to.
            #[must_use]
            pub const fn requirement(self) -> u32 {
                match self { $(Self::$Variant => $requirement,)* }
            }

            /// Its unit.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$Variant => $unit,)* }
            }

            /// Which side of what is allowed is the safe one.
            #[must_use]
            pub const fn bound(self) -> Bound {
                match self { $(Self::$Variant => Bound::$bound,)* }
            }
        }
    };
}

margins! {
    /// From the vehicle's true position, while it flies an insert or is under a modify, to the nearest border that it must
    /// not cross: out of the keep-in zone that holds it with the most room, or into a keep-out zone at its depth.
    Clearance = "clearance", "true distance to the fence under our requests", 2, "m", Least;
    /// From the vehicle's true depth under our requests to the deepest that a keep-in zone around it allows.
    DepthRoom = "depth-room", "true depth to the greatest depth allowed", 2, "m", Least;
    /// The vehicle's true altitude under our requests.
    Altitude = "altitude", "true altitude under our requests", 2, "m", Least;
    /// Between two BPRMB of a lease.
    ModifyGap = "modify-gap", "time between two BPRMB of a lease", 3, "s", Most;
    /// From the BPEMB to the time by which it was due, after something ended the lease.
    ModifyEnd = "modify-end", "time left when the BPEMB that was due left", 14, "s", Least;
    /// Between two sentences that refresh station keeping.
    StationGap = "station-gap", "time between two refreshes of station keeping", 5, "s", Most;
    /// From the BPRES to the time by which it was due, after something ended station keeping.
    StationEnd = "station-end", "time left when the BPRES that was due left", 14, "s", Least;
    /// From a BPRMB to its arrival at a vehicle that hears.
    Delivery = "delivery", "age of a BPRMB when the vehicle read it", 7, "s", Most;
    /// From the last BPRMB that arrived, while the vehicle is truly under a modify.
    ModifyLasts = "modify-lasts", "time that a modify was in force after its last BPRMB", 7, "s", Most;
    /// From the last refresh that arrived, while the vehicle is truly suspended.
    StationLasts = "station-lasts", "time that a suspension was in force after its last refresh", 7, "s", Most;
    /// The age of the newest navigation at a BPRMB.
    NavigationAge = "navigation-age", "age of navigation at a BPRMB", 8, "s", Most;
    /// Inserts that are open at once.
    InsertsOpen = "inserts-open", "inserts open at once", 19, "inserts", Most;
    /// From the newest command that was answered in time to what steers.
    RoundTrip = "round-trip", "age of the newest round trip when something that steers left", 23, "s", Most;
}

/// The figure of a run that came nearest to what is forbidden.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// The figure, in the margin's unit.
    pub value: f64,
    /// What was allowed at that moment, in the same unit.
    pub allowed: f64,
}

impl Nearest {
    /// How much of what is allowed was used, or how much was left: for [`Bound::Most`] the share of the value in what is
    /// allowed, for [`Bound::Least`] the value less what is allowed.
    #[must_use]
    pub fn measure(&self, bound: Bound) -> f64 {
        match bound {
            Bound::Most => self.value / self.allowed,
            Bound::Least => self.value - self.allowed,
        }
    }

    /// Whether this came nearer to what is forbidden than the other.
    #[must_use]
    pub fn is_nearer(&self, other: &Self, bound: Bound) -> bool {
        match bound {
            Bound::Most => self.measure(bound) > other.measure(bound),
            Bound::Least => self.measure(bound) < other.measure(bound),
        }
    }
}

/// The nearest figures of a run. A margin of which no case occurred has none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins([Option<Nearest>; Margin::ALL.len()]);

impl Margins {
    /// The figure that came nearest; `None` if no case occurred.
    #[must_use]
    pub const fn nearest(&self, margin: Margin) -> Option<Nearest> {
        self.0[margin as usize]
    }

    /// Notes one case.
    pub(crate) fn note(&mut self, margin: Margin, value: f64, allowed: f64) {
        let case = Nearest { value, allowed };
        let slot = &mut self.0[margin as usize];
        if slot.is_none_or(|known| case.is_nearer(&known, margin.bound())) {
            *slot = Some(case);
        }
    }
}

impl Serialize for Margins {
    /// As a map from the margins' names; those without a case are left out.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let noted = || {
            Margin::ALL
                .into_iter()
                .filter_map(|margin| Some((margin.name(), self.nearest(margin)?)))
        };
        let mut map = serializer.serialize_map(Some(noted().count()))?;
        for (name, nearest) in noted() {
            map.serialize_entry(name, &nearest)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_case_is_kept() {
        let mut margins = Margins::default();
        assert_eq!(margins.nearest(Margin::ModifyGap), None);
        for (value, allowed) in [(1.0, 2.5), (2.0, 10.0), (1.1, 2.5), (0.2, 2.5)] {
            margins.note(Margin::ModifyGap, value, allowed);
        }
        for metres in [12.0, 3.5, 40.0] {
            margins.note(Margin::Clearance, metres, 0.0);
        }
        let nearest = |margin| margins.nearest(margin).map(|nearest| (nearest.value, nearest.allowed));
        assert_eq!(nearest(Margin::ModifyGap), Some((1.1, 2.5)));
        assert_eq!(nearest(Margin::Clearance), Some((3.5, 0.0)));
        let shown = serde_json::to_string(&margins).unwrap();
        assert_eq!(
            shown,
            r#"{"clearance":{"value":3.5,"allowed":0.0},"modify-gap":{"value":1.1,"allowed":2.5}}"#
        );
    }
}
