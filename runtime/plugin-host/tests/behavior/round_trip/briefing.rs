use std::sync::Arc;

use backseat_core::Grant;
use backseat_plugin_host::{Brief, Budget, HostError, Interface};
use backseat_sdk as sdk;

use super::{echo, said_back};
use crate::fixture::{Latitude, brief, components, input};

/// The areas of a zone of the fixture's fence, which the fence has divided and oriented.
fn areas(zone: &str) -> Vec<sdk::Area> {
    let fence = brief("{}").fence;
    let zone = fence.zones().find(|known| known.name() == zone).unwrap();
    let mut rings = zone.rings().map(|ring| {
        let (first, open) = (ring.points[0], &ring.points[..ring.points.len() - 1]);
        assert_eq!(ring.points.last(), Some(&first), "the fence closes its rings");
        open.iter()
            .map(|point| sdk::Point {
                east: point.east_m,
                north: point.north_m,
            })
            .collect()
    });
    vec![sdk::Area {
        outer: rings.next().unwrap(),
        holes: rings.collect(),
    }]
}

fn zone(name: &str) -> sdk::Zone {
    sdk::Zone {
        name: name.to_owned(),
        keep_in: None,
        margin: 0.0,
        depth_min: None,
        depth_max: None,
        valid_from_ns: None,
        valid_until_ns: None,
        areas: areas(name),
    }
}

#[test]
fn a_plugin_learns_its_mission() {
    let returned = echo(&components().echo, "briefing", Arc::new(Latitude))
        .plugin
        .step(&input(0));
    let origin = brief("{}").fence.frame().origin();
    let expected = sdk::Briefing {
        config: r#"{"answer": "briefing"}"#.to_owned(),
        grants: vec![
            sdk::Grant::Modify,
            sdk::Grant::Insert,
            sdk::Grant::Interrupt,
            sdk::Grant::Message,
            sdk::Grant::Surface,
            sdk::Grant::Topside,
            sdk::Grant::Dvl,
            sdk::Grant::Silent,
            sdk::Grant::Trim,
            sdk::Grant::Buoyancy,
            sdk::Grant::Acoustic,
            sdk::Grant::Station,
            sdk::Grant::Devices,
            sdk::Grant::Sonar,
        ],
        origin: origin.into(),
        zones: vec![
            sdk::Zone {
                keep_in: Some(sdk::KeepIn {
                    altitude_min: 3.0,
                    surfacing: true,
                }),
                margin: 10.0,
                depth_min: Some(2.0),
                depth_max: Some(30.0),
                ..zone("bay")
            },
            sdk::Zone {
                margin: 5.0,
                depth_min: Some(12.0),
                valid_from_ns: Some(1_780_272_000_000_000_000),
                valid_until_ns: Some(1_788_220_800_000_000_000),
                ..zone("wreck")
            },
            zone("lane"),
        ],
        limits: sdk::Limits {
            water_depth_max: Some(45.0),
            ..sdk::Limits::default()
        },
        budget: sdk::Budget {
            fuel_per_step: 100_000_000,
            ..sdk::Budget::default()
        },
    };
    assert_eq!(said_back(returned), format!("{:?}", Some(expected)));
    assert_eq!(areas("bay")[0].holes.len(), 1, "the bay has an island");
    assert!(
        areas("wreck")[0].outer.len() > 20,
        "a circle is drawn with straight edges"
    );
}

#[test]
fn a_plugin_is_not_started_without_the_grants_that_it_needs() {
    let config = r#"{"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}"#;
    let start = |grants| {
        let brief = Brief {
            grants,
            ..brief(config)
        };
        components()
            .template
            .start(Budget::default(), &brief, Arc::new(Latitude))
    };
    let error = start(&[Grant::Insert, Grant::Message]).err().unwrap();
    assert!(matches!(error, HostError::Grants { .. }), "{error}");
    assert_eq!(
        error.to_string(),
        "template: needs the grant modify: add it to `grants` of this plugin in mission.toml"
    );
    let started = start(&[Grant::Message, Grant::Modify]).unwrap();
    assert_eq!(started.needs, [Grant::Modify]);
}

#[test]
fn a_component_knows_its_version_of_the_interface() {
    assert_eq!(components().echo.interface(), Interface::V0_2_0);
    assert_eq!(components().old_echo.interface(), Interface::V0_1_0);
    let old = echo(&components().old_echo, "input", Arc::new(Latitude));
    assert_eq!(old.needs, [], "it cannot say");
}
