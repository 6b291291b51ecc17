use std::sync::{Arc, OnceLock};

use backseat_core::plugin::{FaultKind, Judge, ModifyRequest, NavigationSample, Refusal, Request, Returned, StepInput};
use backseat_core::refusal::ZoneRule;
use backseat_core::refusal::{EdgePlace, ZoneBreach};
use backseat_core::{Grant, Limits};
use backseat_fence::Fence;
use backseat_plugin_host::{Brief, Budget, Cache, Component, Host, Plugin};
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};

/// The components, compiled once for all tests.
pub(crate) struct Components {
    pub(crate) host: Host,
    pub(crate) echo: Component,
    /// The same plugin, made for `wit/v0.1.0`.
    pub(crate) old_echo: Component,
    pub(crate) faulty: Component,
    pub(crate) template: Component,
    pub(crate) template_bytes: Vec<u8>,
}

/// A component that was built before `wit/v0.2.0`. It is never built again.
const OLD_ECHO: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../tests/suite/components/echo-0.1.0.wasm"
);

pub(crate) fn components() -> &'static Components {
    static COMPONENTS: OnceLock<Components> = OnceLock::new();
    COMPONENTS.get_or_init(|| {
        let read = |name: &str| std::fs::read(backseat_test_support::plugins().join(name)).unwrap();
        let cache = Cache::new(backseat_test_support::cache(), |_| {});
        let host = Host::new().unwrap().with_cache(Some(cache));
        let faulty = host.load("faulty", &read("faulty.wasm")).unwrap();
        let template_bytes = read("template.wasm");
        let template = host.load("template", &template_bytes).unwrap();
        let echo = host.load("echo", &read("echo.wasm")).unwrap();
        let old_echo = host.load("echo", &std::fs::read(OLD_ECHO).unwrap()).unwrap();
        Components {
            host,
            echo,
            old_echo,
            faulty,
            template,
            template_bytes,
        }
    })
}

/// A fence that refuses everything beyond latitude 42.01.
pub(crate) struct Latitude;

/// All that a plugin can be allowed to ask for.
pub(crate) const GRANTS: [Grant; 14] = [
    Grant::Modify,
    Grant::Insert,
    Grant::Interrupt,
    Grant::Message,
    Grant::Surface,
    Grant::Topside,
    Grant::Dvl,
    Grant::Silent,
    Grant::Trim,
    Grant::Buoyancy,
    Grant::Acoustic,
    Grant::Station,
    Grant::Devices,
    Grant::Sonar,
];

/// A bay with a hole, a wreck at all depths from 12 m down in summer, and a lane.
const FENCE: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature",
     "properties": {"name": "bay", "kind": "keep-in", "margin_m": 10, "depth_min_m": 2, "depth_max_m": 30,
                    "altitude_min_m": 3, "surfacing": true},
     "geometry": {"type": "Polygon", "coordinates": [
        [[-70.01, 41.99], [-69.99, 41.99], [-69.99, 42.01], [-70.01, 42.01], [-70.01, 41.99]],
        [[-70.004, 41.996], [-70.004, 41.998], [-70.002, 41.998], [-70.002, 41.996], [-70.004, 41.996]]]}},
    {"type": "Feature",
     "properties": {"name": "wreck", "kind": "keep-out", "margin_m": 5, "depth_min_m": 12, "radius_m": 30,
                    "valid_from": "2026-06-01T00:00:00Z", "valid_until": "2026-09-01T00:00:00Z"},
     "geometry": {"type": "Point", "coordinates": [-70.0, 42.004]}},
    {"type": "Feature",
     "properties": {"name": "lane", "kind": "keep-out", "margin_m": 0},
     "geometry": {"type": "Polygon", "coordinates": [
        [[-69.995, 42.0], [-69.994, 42.0], [-69.994, 42.001], [-69.995, 42.001], [-69.995, 42.0]]]}}
]}"#;

/// The limits of a mission that states as little as it may.
const LIMITS: &str = r#"{"speed_min_mps": 1.0, "speed_max_mps": 2.0, "turn_rate_dps": 8.0, "current_max_mps": 0.3, "water_depth_max_m": 45.0}"#;

/// A brief with all grants.
pub(crate) fn brief(config_json: &str) -> Brief<'_> {
    static MISSION: OnceLock<(Fence, Limits)> = OnceLock::new();
    let (fence, limits) = MISSION.get_or_init(|| {
        (
            Fence::from_geojson(FENCE).unwrap(),
            serde_json::from_str(LIMITS).unwrap(),
        )
    });
    Brief {
        config_json,
        grants: &GRANTS,
        fence,
        limits,
    }
}

/// A breach of a zone, at the first edge of its second hole.
pub(crate) fn breach(rule: ZoneRule, missing_m: f64) -> Refusal {
    Refusal::Zone(Box::new(ZoneBreach {
        rule,
        zone: Some("box".to_owned()),
        missing_m: Some(missing_m),
        bound_m: None,
        margin_m: 5.0,
        edge: Some(EdgePlace {
            polygon: 3,
            hole: Some(2),
            number: 1,
            latitude_deg: 42.5,
            longitude_deg: -70.25,
        }),
        valid: None,
        asked: None,
        number: None,
    }))
}

impl Judge for Latitude {
    fn judge(&self, request: &Request, input: &StepInput) -> Result<f64, Refusal> {
        assert!(input.navigation.is_some(), "the judge needs the step's navigation");
        if let Request::Trackline(line) = request
            && line.end.latitude_deg > 42.01
        {
            return Err(breach(ZoneRule::KeepIn, 12.5));
        }
        Ok(3.5)
    }
}

/// The faulty plugin with this fault after some seconds.
pub(crate) fn faulty(fault: &str, after_s: u64, budget: Budget) -> Plugin {
    let config = format!(r#"{{"fault": "{fault}", "after_s": {after_s}, "heading_deg": 45.0}}"#);
    components()
        .faulty
        .start(budget, &brief(&config), Arc::new(Latitude))
        .unwrap()
        .plugin
}

/// The template plugin, which never fails.
pub(crate) fn template() -> Plugin {
    let config = r#"{"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}"#;
    components()
        .template
        .start(Budget::default(), &brief(config), Arc::new(Latitude))
        .unwrap()
        .plugin
}

/// The input at a second, at 42 N 70 W, with control.
pub(crate) fn input(second: u64) -> StepInput {
    let now = Timestamp::from_secs(second);
    StepInput {
        now,
        utc: Utc::from_unix_nanos(1_790_000_000_000_000_000 + now.as_nanos()),
        clocks_apart: None,
        navigation: Some(NavigationSample {
            solution: now,
            position: Position::from_deg(42.0, -70.0).unwrap(),
            local: EastNorth::new(100.0, 200.0),
            depth: Depth::from_m(10.0).unwrap(),
            altitude: Some(Altitude::from_m(15.0).unwrap()),
            heading: Heading::from_deg(45.0).unwrap(),
            roll_deg: 0.5,
            pitch_deg: -1.0,
            east_mps: 1.0,
            north_mps: 1.0,
            down_mps: 0.0,
            yaw_rate_dps: 0.1,
            gps: false,
        }),
        relative: None,
        cartesian: None,
        control: true,
        events: Vec::new(),
    }
}

/// The kind of a step's fault; `None` if the step succeeded.
pub(crate) fn fault_kind(returned: &Returned) -> Option<FaultKind> {
    returned.result.as_ref().err().map(|fault| fault.kind)
}

/// The single modify that a good step requests.
pub(crate) fn only_modify(returned: &Returned) -> ModifyRequest {
    match returned.result.as_deref() {
        Ok([Request::Modify(modify)]) => *modify,
        other => panic!("expected one modify, got {other:?}"),
    }
}
