//! The detector of sonar contacts on simulated imagery: what it finds, where, and how often it is wrong.

mod sea;

use backseat_sdk::sonar::{Contact, Detector, DetectorSettings, Side, Sightings};
use backseat_sdk::units::EastNorth;
use proptest::prelude::*;

use sea::{Line, even, level, ripples};

fn objects(places: &[(f64, f64)], height_m: f64) -> String {
    let object = |(east_m, north_m): &(f64, f64)| {
        format!(
            "[[targets]]\nkind = \"box\"\neast_m = {east_m}\nnorth_m = {north_m}\nlength_m = 1.5\nwidth_m = 1\nheight_m = \
             {height_m}\nheading_deg = 30\nstrength_db = -15\n"
        )
    };
    places.iter().map(object).collect()
}

fn line(world: &backseat_world::World, pings: u32) -> Line<'_> {
    Line {
        world,
        from: EastNorth::default(),
        heading_deg: 0.0,
        pings,
        altitude_m: 9.0,
        pattern: even,
        seed: 3,
    }
}

/// The contact nearest to a place.
fn at(contacts: &[Contact], (east_m, north_m): (f64, f64)) -> Option<Contact> {
    let place = EastNorth::new(east_m, north_m);
    let near = contacts.iter().filter(|contact| contact.at.distance_m(place) < 2.0);
    near.min_by(|one, other| one.at.distance_m(place).total_cmp(&other.at.distance_m(place)))
        .copied()
}

#[test]
fn objects_are_found_with_their_place_side_range_and_height() {
    let places = [(15.0, 60.0), (-25.0, 75.0), (35.0, 90.0), (-48.0, 105.0)];
    let world = level("sand", &objects(&places, 1.0), 2);
    let contacts = line(&world, 800).contacts(DetectorSettings::default());
    assert_eq!(contacts.len(), 4, "{contacts:?}");
    for place in places {
        let contact = at(&contacts, place).unwrap();
        let side = if place.0 < 0.0 { Side::Port } else { Side::Starboard };
        assert_eq!(contact.side, side);
        assert!((contact.ground_m - place.0.abs()).abs() < 1.5, "{contact:?}");
        assert!((contact.height_m - 1.0).abs() < 0.25 && !contact.cut, "{contact:?}");
        assert!((0.3..3.0).contains(&contact.length_m), "{contact:?}");
        assert!(
            (contact.latitude_deg - 42.3 - place.1 / 111_080.0).abs() < 2e-5,
            "{contact:?}"
        );
        assert!(
            (contact.longitude_deg + 70.9 - place.0 / 82_400.0).abs() < 3e-5,
            "{contact:?}"
        );
    }
}

#[test]
fn a_quarter_of_an_hour_without_objects_has_no_contact() {
    for (bottom, pattern) in [
        ("sand", even as fn(EastNorth) -> f64),
        ("silt", even),
        ("sand", ripples),
    ] {
        let world = level(bottom, "", 4);
        let line = Line {
            pattern,
            ..line(&world, 7200)
        };
        let contacts = line.contacts(DetectorSettings::default());
        assert!(contacts.is_empty(), "{bottom}: {contacts:?}");
    }
}

#[test]
fn an_object_lower_than_its_shadow_can_show_is_missed_near_and_found_far() {
    let places = [(10.0, 60.0), (-10.0, 75.0), (45.0, 90.0), (-45.0, 105.0)];
    let world = level("sand", &objects(&places, 0.25), 2);
    let contacts = line(&world, 800).contacts(DetectorSettings::default());
    assert!(at(&contacts, places[0]).is_none() && at(&contacts, places[1]).is_none());
    assert!(at(&contacts, places[2]).is_some() && at(&contacts, places[3]).is_some());
}

#[test]
fn two_lines_show_the_same_object_from_two_sides() {
    let world = level("sand", &objects(&[(25.0, 75.0)], 1.0), 2);
    let mut sightings = Sightings::new(4.0, 50);
    for (east_m, north_m, heading_deg) in [(0.0, 0.0, 0.0), (60.0, 150.0, 180.0)] {
        let line = Line {
            from: EastNorth::new(east_m, north_m),
            heading_deg,
            ..line(&world, 800)
        };
        for contact in line.contacts(DetectorSettings::default()) {
            sightings.add(&contact);
        }
    }
    assert_eq!(sightings.objects().len(), 1);
    assert_eq!(sightings.objects()[0].lines(), 2);
}

#[test]
fn a_snapshot_goes_on_as_the_original() {
    let world = level("sand", &objects(&[(25.0, 60.0), (-30.0, 75.0)], 1.0), 2);
    let mut detector = Detector::new(DetectorSettings::default()).unwrap();
    let mut copy: Option<Detector> = None;
    let mut found = 0;
    let mut ping = 0;
    line(&world, 500).fly(|look| {
        ping += 1;
        if ping == 310 {
            let text = serde_json::to_string(&detector).unwrap();
            copy = Some(serde_json::from_str(&text).unwrap());
        }
        let contacts = detector.look(look);
        if let Some(copy) = &mut copy {
            assert_eq!(copy.look(look), contacts);
            assert_eq!(copy.hits(), detector.hits());
        }
        found += contacts.len();
    });
    assert_eq!(found, 2);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// The level of the sonar, its step and which side is which change nothing.
    #[test]
    fn the_detector_does_not_know_the_gain(gain in 1e-3..1e3_f32) {
        let world = level("sand", &objects(&[(25.0, 60.0)], 1.0), 2);
        let settings = DetectorSettings::default();
        let (mut plain, mut louder) = (Detector::new(settings).unwrap(), Detector::new(settings).unwrap());
        let mut found = (Vec::new(), Vec::new());
        line(&world, 420).fly(|look| {
            found.0.extend(plain.look(look));
            let mut loud = *look;
            for strip in loud.port.iter_mut().chain(&mut loud.starboard) {
                strip.step = gain;
            }
            found.1.extend(louder.look(&loud));
        });
        prop_assert_eq!(found.0.len(), 1);
        prop_assert_eq!(found.1.len(), 1);
        prop_assert!(found.0[0].at.distance_m(found.1[0].at) < 0.3);
    }
}
