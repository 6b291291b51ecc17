//! What the Python package offers, without Python: flights, logs and sentences. `cargo xtask python` tests the package.

use std::path::Path;

use backseat_python::{Error, Flight, catalogue, decode, describe, encode, simulate, table, trajectory};
use backseat_test_support::{mission, plugins};
use serde_json::json;

fn flight(mission: &Path) -> Flight<'_> {
    Flight {
        mission,
        seed: 1,
        set: Vec::new(),
        faults: None,
        draw_faults: None,
        plugins: Some(plugins()),
        log: None,
    }
}

#[test]
fn a_flight_gives_the_same_digest_each_time_and_with_a_log() {
    let (isobath, folder) = (mission("isobath"), tempfile::tempdir().unwrap());
    let log = folder.path().join("isobath.mcap");
    let one = simulate(&flight(&isobath), || false).unwrap();
    let other = simulate(
        &Flight {
            log: Some(&log),
            ..flight(&isobath)
        },
        || false,
    )
    .unwrap();
    assert_eq!((one.outcome, one.digest.as_str()), ("completed", other.digest.as_str()));
    let description = describe(&log).unwrap();
    assert_eq!(
        (&description["run"]["mission"], &description["complete"]),
        (&json!("isobath"), &json!(true))
    );
    let topics = description["tables"].as_array().unwrap();
    assert!(
        topics
            .iter()
            .any(|table| table["topic"] == "/navigation" && table["file"].is_null())
    );
    let [parquet, netcdf] = ["navigation.parquet", "track.nc"].map(|name| folder.path().join(name));
    assert!(table(&log, "/navigation", &parquet).unwrap().is_empty());
    assert!(trajectory(&log, &netcdf).unwrap().is_empty());
    assert!(std::fs::read(parquet).unwrap().starts_with(b"PAR1"));
    assert!(std::fs::read(netcdf).unwrap().starts_with(b"CDF"));
}

#[test]
fn a_setting_changes_the_flight_and_a_wrong_one_is_the_missions_fault_in_one_line() {
    let isobath = mission("isobath");
    let with = |set: &str| {
        let set = vec![set.to_owned()];
        simulate(
            &Flight {
                set,
                ..flight(&isobath)
            },
            || false,
        )
    };
    let slow = with("plugin.isobath.config.speed_mps=1.2").unwrap();
    assert_ne!(slow.digest, simulate(&flight(&isobath), || false).unwrap().digest);
    let calm = with("world.current.speed_mps=0.0").unwrap();
    assert_ne!(calm.digest, with("world.current.speed_mps=0.25").unwrap().digest);
    let error = with("limits.speed_max_mps=fast").unwrap_err();
    assert!(error.is_of_mission() && !error.to_string().contains('\n'), "{error}");
    let error = simulate(&flight(Path::new("nowhere")), || false).unwrap_err();
    assert!(matches!(error, Error::Mission(_)), "{error}");
}

#[test]
fn the_caller_can_end_a_flight() {
    let mut asked = 0;
    let ended = simulate(&flight(&mission("isobath")), || {
        asked += 1;
        asked == 2
    });
    assert!(matches!(ended, Err(Error::Interrupted)));
}

#[test]
fn sentences_are_decoded_encoded_and_explained() {
    let sentence = "$BFCTL,081025.987,1*78\r\n";
    let decoded = decode(sentence.as_bytes(), false).unwrap();
    let [control] = &decoded[..] else {
        panic!("expected one sentence: {decoded:?}")
    };
    assert_eq!(control["message"], json!({"created": "08:10:25.987", "granted": true}));
    assert_eq!(encode("BFCTL", &control["message"]).unwrap(), sentence);
    let error = encode("BFCTL", &json!({"created": "08:10:25.987", "granted": 7})).unwrap_err();
    assert!(!error.to_string().contains("line 1"), "{error}");
    assert_eq!(catalogue(&["CTL".to_owned()]).unwrap()[0]["name"], "BFCTL");
    assert_eq!(catalogue(&[]).unwrap().len(), 71);
}
