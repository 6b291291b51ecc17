//! Tests where the vehicle may surface.

use super::{Fence, KEEP_OUT, at, fence, rectangle, zone};
use crate::sweep::{Shape, Sweep, VerticalExtent};
use crate::verdict::{Breach, Clearance, Rule};
use crate::zone::{Band, Kind};

const fn keep_in(surfacing: bool) -> Kind {
    Kind::KeepIn {
        depth: Band {
            min_m: 5.0,
            max_m: 50.0,
        },
        altitude_min_m: 3.0,
        surfacing,
    }
}

/// A large zone in which surfacing is not allowed, and a small one in its east in which it is.
fn waters() -> Fence {
    fence(vec![
        zone(
            "lane",
            keep_in(false),
            0.0,
            &[rectangle(-1000.0, -1000.0, 1000.0, 1000.0)],
        ),
        zone(
            "harbour",
            keep_in(true),
            10.0,
            &[rectangle(500.0, -200.0, 900.0, 200.0)],
        ),
    ])
}

fn surfacing(fence: &Fence, (east_m, north_m): (f64, f64), deepest_m: f64) -> Result<Clearance, Breach> {
    let vertical = VerticalExtent {
        depth_min_m: deepest_m,
        depth_max_m: deepest_m,
        altitude_min_m: 10.0,
    };
    fence.check_surfacing(&Sweep::new(Shape::point(at(east_m, north_m)), 50.0), &vertical)
}

#[test]
fn surfacing_needs_a_zone_that_allows_it_and_ignores_its_shallowest_depth() {
    let fence = waters();
    assert_eq!(surfacing(&fence, (700.0, 0.0), 20.0).unwrap().metres, 140.0);
    let breach = surfacing(&fence, (0.0, 0.0), 20.0).unwrap_err();
    assert_eq!((breach.rule, breach.zone()), (Rule::Surfacing, Some("harbour")));
    assert_eq!(breach.metres, 560.0, "the distance, the radius and the margin");
    assert!(
        breach.to_string().starts_with(
            "outside keep-in zone 'harbour', the nearest that allows surfacing, with its margin of 10 m by 560.0 m"
        ),
        "{breach}"
    );
    // The zone's other limits do count.
    assert_eq!(surfacing(&fence, (700.0, 0.0), 51.0).unwrap_err().rule, Rule::DepthMax);
    // An ordinary question still has its shallowest depth.
    let shallow = VerticalExtent {
        depth_min_m: 0.0,
        depth_max_m: 20.0,
        altitude_min_m: 10.0,
    };
    let sweep = Sweep::new(Shape::point(at(700.0, 0.0)), 50.0);
    assert_eq!(fence.check(&sweep, &shallow).unwrap_err().rule, Rule::DepthMin);
}

#[test]
fn a_keep_out_zone_counts_at_every_depth_on_the_way_up() {
    let buoy = Kind::KeepOut {
        depth: Some(Band {
            min_m: f64::NEG_INFINITY,
            max_m: 2.0,
        }),
    };
    let waters = |kind| {
        fence(vec![
            zone(
                "harbour",
                keep_in(true),
                0.0,
                &[rectangle(-500.0, -500.0, 500.0, 500.0)],
            ),
            zone("buoy", kind, 5.0, &[rectangle(20.0, -5.0, 30.0, 5.0)]),
        ])
    };
    for kind in [buoy, KEEP_OUT] {
        let breach = surfacing(&waters(kind), (0.0, 0.0), 20.0).unwrap_err();
        assert_eq!((breach.rule, breach.zone()), (Rule::KeepOut, Some("buoy")));
    }
    let wreck = Kind::KeepOut {
        depth: Some(Band {
            min_m: 30.0,
            max_m: 60.0,
        }),
    };
    assert!(
        surfacing(&waters(wreck), (0.0, 0.0), 20.0).is_ok(),
        "the wreck lies deeper"
    );
    assert!(
        surfacing(&waters(buoy), (0.0, 0.0), -0.5).is_err(),
        "at the surface, with an error in depth"
    );
}

#[test]
fn a_fence_without_surfacing_says_so_and_unusable_numbers_never_pass() {
    let fence = fence(vec![zone(
        "lane",
        keep_in(false),
        0.0,
        &[rectangle(-1000.0, -1000.0, 1000.0, 1000.0)],
    )]);
    let breach = surfacing(&fence, (0.0, 0.0), 20.0).unwrap_err();
    assert_eq!((breach.rule, breach.zone(), breach.edge), (Rule::Surfacing, None, None));
    assert_eq!(breach.to_string(), "no keep-in zone allows surfacing");
    for (place, deepest_m) in [((f64::NAN, 0.0), 20.0), ((700.0, 0.0), f64::NAN)] {
        assert_eq!(
            surfacing(&waters(), place, deepest_m).unwrap_err().rule,
            Rule::NotFinite
        );
    }
}
