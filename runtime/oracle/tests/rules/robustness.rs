//! Malformed input from either side, and bounds.

use backseat_oracle::{Activity, Limits, Oracle, OracleError, Truth};
use proptest::prelude::*;

use crate::scenario::{FENCE, Scenario, position, sentence};

#[test]
fn a_malformed_sentence_of_ours_is_a_violation() {
    for bytes in [
        "$BPMSG,000001.000,x*00\r\n",
        "$BPMSG,000001.000,x\r\n",
        &sentence("BPMSG,000001.000,x").replace('\r', ""),
        &sentence("BPMSG,000001.000,x").to_lowercase(),
        &format!("noise{}", sentence("BPMSG,000001.000,x")),
        &sentence("BPMSG,nonsense,x"),
        &sentence("BPRTK,000001.000,7,4200.3,N"),
        &sentence("BFCTL,000001.000,1"),
        "\r\n",
        &"x".repeat(5000),
        "$BPMSG,000001.000,no end",
    ] {
        Scenario::with_control()
            .bytes(2000, bytes.as_bytes())
            .finds(&["malformed"]);
    }
    let two = sentence("BPMSG,000001.000,x") + &sentence("BPMSG,000001.001,x");
    let (first, second) = two.as_bytes().split_at(30);
    Scenario::with_control()
        .bytes(2000, first)
        .bytes(2001, second)
        .finds_nothing();
    // A sentence that a lost link cuts off is no violation.
    Scenario::with_control()
        .bytes(2000, first)
        .link(2001, false)
        .finds_nothing();
}

#[test]
fn sentences_of_the_vehicle_with_wrong_checksums_do_not_count() {
    let oracle = |grant: &str| {
        let mut oracle = Oracle::new(FENCE, Limits::default()).unwrap();
        oracle.link(0, true);
        oracle.from_vehicle(0, sentence("BFMIS,000000.000,a,Running,").as_bytes());
        oracle.from_vehicle(0, grant.as_bytes());
        oracle.statistics().control_spans
    };
    let good = sentence("BFCTL,000000.000,1");
    assert_eq!(oracle(&good), 1);
    assert_eq!(oracle(&format!("noise$BFCT{good}")), 1);
    assert_eq!(oracle(&good.replace(",1*", ",1 *")), 0);
}

#[test]
fn the_list_of_violations_is_bounded() {
    let mut oracle = Oracle::new(FENCE, Limits::default()).unwrap();
    for index in 0..250 {
        oracle.to_vehicle(index * 1_000_000, b"junk\n");
    }
    assert_eq!(oracle.statistics().violations, 250);
    let violations = oracle.finish(1_000_000_000);
    assert_eq!(violations.len(), 101);
    let last = violations.last().unwrap();
    assert_eq!((last.rule, last.text.as_str()), ("omitted", "150 more violations"));
}

#[test]
fn a_violation_has_a_readable_text() {
    let outcome = Scenario::without_control()
        .ours(2000, "BPRTK,{t},7,4200.3,N,07000.9,W,4200.3,N,07000.8,W,0,10,1.5,0,0")
        .finds(&["no-control"]);
    assert_eq!(
        outcome.violations[0].to_string(),
        "2.000 s no-control (requirement 001): BPRTK without control since 0.000 s"
    );
    let json = serde_json::to_string(&outcome.violations[0]).unwrap();
    assert!(json.contains(r#""rule":"no-control","requirement":1"#), "{json}");
}

#[test]
fn an_invalid_fence_is_refused() {
    let refused = |fence: &str| Oracle::new(fence, Limits::default()).unwrap_err();
    assert!(matches!(refused(""), OracleError::Json(_)));
    assert!(matches!(refused("[]"), OracleError::Document { .. }));
    assert!(matches!(
        refused(r#"{"type":"FeatureCollection"}"#),
        OracleError::Document { .. }
    ));
    assert!(matches!(
        refused(r#"{"type":"FeatureCollection","features":[]}"#),
        OracleError::Document { .. }
    ));
    for (good, bad) in [
        (r#""name": "site","#, ""),
        (r#""kind": "keep-in""#, r#""kind": "outclusion""#),
        (r#""kind": "keep-in","#, ""),
        (r#""margin_m": 20"#, r#""margin_m": "wide""#),
        (r#""depth_max_m": 40"#, r#""depth_max_m": 1"#),
        (r#""type": "Polygon""#, r#""type": "Point""#),
        ("[-70.02, 42.0]", "[-270.02, 42.0]"),
        ("[-70.02, 42.0]", "[-70.02, 89.0]"),
        ("[-70.02, 42.0]", "[-70.02]"),
        ("[-70.02, 42.0], [-70.0, 42.0]", "[-70.0, 42.0]"),
        ("[-70.0, 42.0], [-70.0, 42.02], ", ""),
    ] {
        let broken = FENCE.replacen(good, bad, 1);
        assert_ne!(broken, FENCE, "{good}");
        let error = refused(&broken);
        assert!(matches!(error, OracleError::Feature { index: 0, .. }), "{bad}: {error}");
    }
    let limits = Limits {
        link_delay_s: f64::NAN,
        ..Limits::default()
    };
    assert!(matches!(
        Oracle::new(FENCE, limits),
        Err(OracleError::Limit {
            what: "link_delay_s",
            ..
        })
    ));
}

#[test]
fn a_fence_may_lie_across_the_date_line() {
    let fence = r#"{ "type": "FeatureCollection", "features": [ { "type": "Feature",
        "properties": { "name": "site", "kind": "keep-in", "margin_m": 20 },
        "geometry": { "type": "MultiPolygon", "coordinates": [[[
            [179.99, 10.0], [-179.99, 10.0], [-179.99, 10.02], [179.99, 10.02], [179.99, 10.0]]]] } } ] }"#;
    let rules = |longitude: f64| {
        let mut oracle = Oracle::new(fence, Limits::default()).unwrap();
        oracle.truth(&Truth {
            at_ns: 0,
            position: position(10.01, longitude),
            depth_m: 5.0,
            altitude_m: 5.0,
            activity: Activity::Insert(7),
        });
        oracle
            .finish(0)
            .iter()
            .map(|violation| violation.rule)
            .collect::<Vec<_>>()
    };
    for inside in [179.995, 180.0, -180.0, -179.995] {
        assert!(rules(inside).is_empty(), "{inside}");
    }
    for outside in [179.98, -179.98, 0.0] {
        assert_eq!(rules(outside), ["truth-fence"], "{outside}");
    }
}

/// Sentences of both sides with something wrong here and there, and pure noise.
fn garbage() -> impl Strategy<Value = Vec<u8>> {
    let names = proptest::sample::select(vec![
        "BFNVG", "BFCTL", "BFMIS", "BFMSC", "BFMBS", "BFMBE", "BFACK", "BFPLN", "BPRMB", "BPEMB", "BPRTK", "BPRTC",
        "BPRGP", "BPRCN", "BPRMP", "BPVER", "BPXYZ", "BFSHT", "BFDVT", "BFCMA", "BPDVR", "BPSIL", "BPCPD", "BPTOP",
        "BPSUS", "BPCON", "BPRES", "BPRNS",
    ]);
    let fields = proptest::sample::select(vec![
        "",
        "0",
        "1",
        "4",
        "7",
        "-1",
        "1e9",
        "999999999",
        "000001.000",
        "235960.5",
        "4200.3",
        "9000",
        "N",
        "S",
        "07000.9",
        "17959.999999",
        "W",
        "E",
        "Running",
        "RTK",
        "RCN",
        "trackline",
        "nan",
        "$",
        "90",
    ]);
    let body = (names, proptest::collection::vec(fields, 0..18))
        .prop_map(|(name, fields)| sentence(&format!("{name},{}", fields.join(","))).into_bytes());
    let noise = proptest::collection::vec(
        prop_oneof![any::<u8>(), proptest::sample::select(b"$,*\r\nBPRF0123".to_vec())],
        0..200,
    );
    prop_oneof![4 => body, 1 => noise]
}

proptest! {
    #[test]
    fn no_input_from_either_side_panics(
        writes in proptest::collection::vec((0..9u8, garbage(), 0..u64::MAX / 2), 0..60), sorted: bool,
    ) {
        let mut oracle = Oracle::new(FENCE, Limits::default()).unwrap();
        for (index, (side, bytes, at)) in writes.iter().enumerate() {
            let at = if sorted { index as u64 * 70_000_000 } else { *at };
            match side {
                0 | 1 => oracle.from_vehicle(at, bytes),
                2 | 3 => oracle.to_vehicle(at, bytes),
                4 => oracle.link(at, bytes.len() % 3 > 0),
                5 => oracle.arrived(at, bytes),
                6 if bytes.len() % 4 == 3 => oracle.gap(at / 2, at),
                6 => oracle.operator(at, bytes.len() % 2 > 0),
                7 => match bytes.len() % 3 {
                    0 => oracle.runtime_stopped(at),
                    1 => oracle.runtime_continued(at),
                    _ => oracle.runtime_started(at),
                },
                _ => {
                    let latitude = bytes.first().map_or(0.0, |byte| f64::from(*byte) / 128.0 * 90.0 - 90.0);
                    oracle.believed(latitude, latitude / 10.0);
                    oracle.truth(&Truth {
                        at_ns: at,
                        position: position(latitude, latitude * 2.0),
                        depth_m: latitude,
                        altitude_m: if bytes.len() % 2 == 0 { f64::NAN } else { latitude },
                        activity: match bytes.len() % 5 {
                            0 => Activity::Plan,
                            1 => Activity::Insert(7),
                            2 => Activity::Modified,
                            3 => Activity::Suspended,
                            _ => Activity::Other,
                        },
                    });
                }
            }
        }
        let statistics = oracle.statistics();
        prop_assert!(oracle.rules().iter().all(|rule| rule.broken <= rule.judged));
        let violations = oracle.finish(u64::MAX);
        prop_assert!(violations.len() <= 101 && statistics.violations >= violations.len() as u64 / 2);
    }

    #[test]
    fn a_write_may_arrive_in_any_pieces(cuts in proptest::collection::vec(1..60usize, 0..10)) {
        let text = sentence("BFMIS,000000.000,a,Running,") + &sentence("BFCTL,000000.000,1") + "\n";
        let mut oracle = Oracle::new(FENCE, Limits::default()).unwrap();
        oracle.link(0, true);
        let mut rest = text.as_bytes();
        for cut in cuts {
            let (now, later) = rest.split_at(cut.min(rest.len()));
            oracle.from_vehicle(0, now);
            rest = later;
        }
        oracle.from_vehicle(0, rest);
        prop_assert_eq!(oracle.statistics().control_spans, 1);
    }
}
