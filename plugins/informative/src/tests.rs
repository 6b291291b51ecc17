use std::time::Duration;

use backseat_sdk::testing::{Basin, Fault, Flown};
use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::exp;
use backseat_sdk::{Ctd, Event, Request};

use crate::Informative;

const CONFIG: &str = r#"{"east_m": 0, "north_m": 600, "length_m": 1200, "width_m": 900, "bearing_deg": 90, "scale_m": 100,
    "deviation_c": 0.3, "warm_c": 12.5, "search_m": 450, "line_m": 240, "way_m": 5475, "depth_m": 12, "speed_mps": 1.5}"#;

/// Two warm springs, which the seed places: where, and how much warmer.
#[derive(Clone, Copy)]
struct Sea([(EastNorth, f64); 2]);

impl Sea {
    fn drawn(seed: u64) -> Self {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut within = |least: f64, most: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            least + (most - least) * ((state >> 11) as f64 / (1u64 << 53) as f64)
        };
        Self([0, 1].map(|_| {
            (
                EastNorth::new(within(-500.0, 500.0), within(250.0, 950.0)),
                within(1.0, 2.0),
            )
        }))
    }

    fn temperature_c(&self, at: EastNorth) -> f64 {
        let spring = |(centre, warmer_c): &(EastNorth, f64)| {
            let off = at.distance_m(*centre) / 80.0;
            warmer_c * exp(-0.5 * off * off)
        };
        12.0 + self.0.iter().map(spring).sum::<f64>()
    }
}

fn flown(sea: Sea, adaptive: bool, faults: Vec<Fault>) -> (Basin<Informative>, Flown) {
    let config = CONFIG.replace('}', &format!(", \"adaptive\": {adaptive}}}"));
    let mut basin = Basin::<Informative>::new(&config).unwrap();
    basin.faults = faults;
    basin.senses = Box::new(move |place, _, _| {
        vec![Event::Ctd(Ctd {
            age_ns: 0,
            conductivity: 40_000.0,
            temperature: sea.temperature_c(place),
            pressure: 200.0,
        })]
    });
    let flight = basin.fly(Duration::from_secs(7200));
    (basin, flight)
}

/// The error of the published map where the water is warm, how much warmer than at the place that was found it is anywhere,
/// and the way.
fn judged(seed: u64, adaptive: bool) -> (f64, f64, f64) {
    let sea = Sea::drawn(seed);
    let (basin, flight) = flown(sea, adaptive, vec![]);
    let measures = |name: &str| basin.harness.measures(name).to_vec();
    let places = measures("map_east").into_iter().zip(measures("map_north"));
    let (mut squares, mut count) = (0.0, 0.0);
    for ((east, north), mean) in places.zip(measures("map_mean")) {
        let truth_c = sea.temperature_c(EastNorth::new(east, north));
        if truth_c > 12.5 {
            squares += (mean - truth_c) * (mean - truth_c);
            count += 1.0;
        }
    }
    let warmest_c = sea.0.map(|(centre, _)| sea.temperature_c(centre));
    let found = EastNorth::new(measures("found_east")[0], measures("found_north")[0]);
    let missed_c = warmest_c.into_iter().fold(f64::MIN, f64::max) - sea.temperature_c(found);
    assert!(
        matches!(flight.flown.last(), Some(Request::Trackcircle(_))),
        "seed {seed}"
    );
    (f64::sqrt(squares / count), missed_c, measures("way")[0])
}

#[test]
fn it_knows_the_warm_water_better_than_a_lawnmower_of_the_same_way() {
    let seeds = 8;
    let (mut own_c, mut lawn_c, mut missed_c, mut better) = (0.0, 0.0, 0.0, 0);
    for seed in 1..=seeds {
        let (own, lawn) = (judged(seed, true), judged(seed, false));
        assert!(
            own.2 < lawn.2 + 30.0,
            "seed {seed}: {:.0} m against {:.0} m",
            own.2,
            lawn.2
        );
        own_c += own.0 / f64::from(seeds as u32);
        lawn_c += lawn.0 / f64::from(seeds as u32);
        missed_c += own.1 / f64::from(seeds as u32);
        better += u32::from(own.0 < lawn.0);
    }
    assert!(
        own_c < 0.7 * lawn_c && better >= 6,
        "{own_c:.3} against {lawn_c:.3} C, better in {better}"
    );
    assert!(missed_c < 0.1, "{missed_c:.3} C");
}

#[test]
fn it_ends_whatever_happens() {
    for seed in 0..12 {
        let faults = Fault::draw(seed);
        let (basin, flight) = flown(Sea::drawn(seed), true, faults.clone());
        assert!(flight.failures.is_empty(), "seed {seed}: {:?}", flight.failures);
        let survey = basin.harness.plugin.survey();
        assert!(survey.is_over() && survey.marked, "seed {seed}: {faults:?}");
        assert_eq!(basin.harness.measures("way").len(), 1, "seed {seed}: {faults:?}");
    }
}
