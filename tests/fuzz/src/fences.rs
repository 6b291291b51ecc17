use backseat_fence::{Fence, FenceError, Terms};

/// The values that `fence.plan` does not hold.
const TERMS: Terms = Terms {
    margin_m: 10.0,
    depth_min_m: 0.0,
    depth_max_m: 50.0,
    altitude_min_m: 2.0,
    surfacing: false,
};

/// Reads a text in each of the three fence formats. The result must be a fence, or an error of one line. A fence that
/// was read must have zones with finite vertices, and when it is written as GeoJSON and read again, it must have as
/// many zones.
pub fn fence(data: &[u8]) {
    let Ok(text) = core::str::from_utf8(data) else {
        return;
    };
    for read in [
        Fence::from_geojson(text),
        Fence::from_plan(text, &TERMS),
        Fence::from_kml(text, &TERMS),
    ] {
        match read {
            Ok(fence) => whole(&fence),
            Err(error) => one_line(&error),
        }
    }
}

fn one_line(error: &FenceError) {
    let said = error.to_string();
    assert!(
        !said.is_empty() && !said.contains(['\n', '\r']),
        "not one line: {said:?}"
    );
}

fn whole(fence: &Fence) {
    let mut zones = 0;
    for zone in fence.zones() {
        zones += 1;
        for ring in zone.rings() {
            assert!(
                ring.points.len() >= 3,
                "{} has a ring that encloses nothing",
                zone.name()
            );
            let finite = |point: &backseat_units::EastNorth| point.east_m.is_finite() && point.north_m.is_finite();
            assert!(ring.points.iter().all(finite), "{} has no place", zone.name());
        }
    }
    assert!(zones > 0, "a fence of nothing");
    let again = Fence::from_geojson(&fence.to_geojson()).expect("what was written out is a fence");
    assert_eq!(again.zones().count(), zones);
}
