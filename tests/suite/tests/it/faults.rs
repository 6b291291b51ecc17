//! A faulty plugin beside a good one, which is not affected (safety requirement 006). Each fault of `faulty` has its
//! test here; `backseat-soak beside` runs each in real time.

use std::path::Path;
use std::sync::OnceLock;

use backseat_recorder::{Log, read};
use backseat_suite::{Backseat, Mission};

/// A live modify is sent again each second; a longer gap means that another plugin has delayed it.
const GAP_MAX_S: f64 = 1.05;

/// All the grants of a plugin.
const EVERY_GRANT: &str = r#"["modify", "insert", "interrupt", "message", "surface", "topside", "dvl", "silent", "trim", "buoyancy",
    "acoustic", "station", "devices"]"#;

/// Isobath, first in priority, beside `faulty`, whose fault begins a minute after control is gained, that is after
/// about 150 s, and lasts for five minutes. The target across the fence is in the north.
fn beside_isobath(fault: &str) -> Mission {
    Mission::copy("isobath")
        .edit("mission.toml", "inserts_open_max = 0", "inserts_open_max = 2")
        .edit("mission.toml", "inserts_total_max = 0", "inserts_total_max = 10")
        .append(
            "mission.toml",
            &format!(
                "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = {EVERY_GRANT}\n\
                 [plugin.config]\nfault = \"{fault}\"\nafter_s = 210.0\n\
                 target_north_m = 3000.0\ntarget_east_m = 0.0"
            ),
        )
        .edit("world.toml", "timeout_s = 3600", "timeout_s = 300")
        // Other tests check how well isobath follows the contour in a whole mission.
        .cut("world.toml", "[expect.contour]")
}

/// The sentences that were sent, with their times in seconds.
fn sent(log: &Log) -> Vec<(f64, String)> {
    let mut sentences = Vec::new();
    for (at, from_vehicle, bytes) in log.link() {
        if !from_vehicle {
            let text = String::from_utf8_lossy(bytes);
            sentences.extend(text.lines().map(|line| (at.as_secs_f64(), line.to_owned())));
        }
    }
    sentences
}

/// How many times the log reports this failure of the faulty plugin.
fn failures(log: &Log, kind: &str) -> usize {
    let begin = format!("plugin 1 failed ({kind})");
    log.notes().filter(|(_, note)| note.starts_with(&begin)).count()
}

#[track_caller]
fn flies(mission: &Mission, path: &Path) -> Log {
    let report = Backseat::new()
        .args(["sim", "--json", "--seed", "7", "--log"])
        .arg(path)
        .mission(mission)
        .run();
    let told = report.json();
    // A plugin that cannot be started again fails the run, and nothing else does.
    let quarantined = told["plugin_quarantines"]
        .as_object()
        .is_some_and(|some| !some.is_empty());
    let report = report.exit(i32::from(quarantined)).json();
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
    assert_eq!(report["outcome"], "completed", "{report}");
    read(path).expect("the log can be read")
}

/// The faulty plugin may steer until its fault begins: after control is gained, the plugin that is stepped first steers
/// until the other, which has priority, makes a request.
const SIBLINGS: &str = ",0,10,0,1.5,1,0*";

/// The sentences by which isobath steers, with the times when they were sent.
fn steering(log: &Log) -> Vec<(f64, String)> {
    let mut sentences = sent(log);
    sentences.retain(|(_, sentence)| {
        !sentence.starts_with("$BPSTS,") && !sentence.starts_with("$BPMSG,") && !sentence.contains(SIBLINGS)
    });
    sentences
}

/// The sentences of isobath beside a plugin that behaves well.
fn undisturbed() -> &'static Vec<(f64, String)> {
    static STEERING: OnceLock<Vec<(f64, String)>> = OnceLock::new();
    STEERING.get_or_init(|| {
        let mission = beside_isobath("none");
        steering(&flies(&mission, &mission.beside("run.mcap")))
    })
}

/// The good plugin steers for the five minutes, and every refresh is in time.
#[track_caller]
fn isobath_is_refreshed(log: &Log) {
    let (mut steered_s, mut last) = (0.0, None::<f64>);
    for (at_s, sentence) in steering(log) {
        if sentence.starts_with("$BPRMB,") {
            if let Some(last_s) = last {
                assert!(
                    at_s - last_s <= GAP_MAX_S,
                    "{:.3} s between modifies at {at_s:.3} s",
                    at_s - last_s
                );
                steered_s += at_s - last_s;
            }
            last = Some(at_s);
        } else if sentence.starts_with("$BPEMB,") {
            last = None;
        }
    }
    assert!(steered_s > 200.0, "isobath steered for {steered_s:.0} s only");
    assert_eq!(
        log.notes()
            .filter(|(_, note)| note.starts_with("plugin 0 failed"))
            .count(),
        0
    );
}

/// As above, and no sentence that steers differs because of the faulty plugin.
#[track_caller]
fn isobath_steers(log: &Log) {
    isobath_is_refreshed(log);
    let steering = steering(log);
    for (here, there) in steering.iter().zip(undisturbed()) {
        // After the other plugin's own modify, the next waits for its rate, at a time that depends on the other
        // plugin's fuel.
        let same = here.1 == there.1 && (here.0 - there.0).abs() < 1e-6;
        assert!(same, "the first difference: {here:?}, undisturbed {there:?}");
    }
    assert_eq!(steering.len(), undisturbed().len());
}

/// A test for each fault: its name in the plugin's configuration, how the log reports it if it is a failure, and what
/// must be true of isobath.
macro_rules! faults {
    ($all:ident $holds:ident: $($name:ident $fault:literal $($kind:literal)?;)*) => {
        const $all: &[&str] = &[$($fault),*];
        $(
            #[test]
            fn $name() {
                let mission = beside_isobath($fault);
                let log = flies(&mission, &mission.beside("run.mcap"));
                $holds(&log);
                $(
                    let count = failures(&log, $kind);
                    assert!(count >= 2, "{count} failures of the kind {}", $kind);
                )?
            }
        )*
    };
}

faults! { STEERS isobath_steers:
    a_plugin_that_panics "trap" "Trap";
    a_plugin_that_calls_itself_without_end "recursion" "Trap";
    a_plugin_that_never_returns "loop" "OutOfFuel";
    a_plugin_that_takes_all_memory "grow" "Memory";
    a_plugin_that_floods_with_requests "flood" "TooMuch";
    a_plugin_that_returns_errors "error" "Error";
    a_plugin_that_sends_a_huge_string "huge_string" "TooMuch";
    a_plugin_with_a_huge_snapshot "big_snapshot";
    a_plugin_that_floods_the_log "log_flood";
    a_plugin_that_publishes_without_end "publish_flood";
    a_plugin_that_asks_for_what_is_no_number "nan";
    a_plugin_that_asks_for_the_infinite "infinite";
    a_plugin_that_asks_for_huge_figures "huge";
    a_plugin_that_asks_for_latitude_91 "latitude_91";
    a_plugin_that_falls_silent "stale";
    a_plugin_that_contradicts_itself "contradict";
    a_plugin_that_wants_across_the_fence "cross_fence";
    a_plugin_that_surfaces_again_and_again "gps_flood";
    a_plugin_whose_packet_has_too_many_frames "nine_frames" "TooMuch";
    a_plugin_whose_frame_is_too_long "long_frame" "TooMuch";
    a_plugin_whose_packet_is_empty "no_frames";
    a_plugin_whose_message_is_too_long "long_topside" "TooMuch";
}

// Requests of these faults may be sent within the limits. The link's delay is drawn for each write, so isobath's own
// sentences are then not the same to the byte.
faults! { IS_REFRESHED isobath_is_refreshed:
    a_plugin_that_floods_the_topside "topside_flood";
    a_plugin_that_floods_the_acoustic_modem "packet_flood";
    a_plugin_that_flashes_the_light "light_flood";
    a_plugin_whose_texts_delimit_sentences "reserved_text";
    a_plugin_that_throws_the_camera "camera_1000";
    a_plugin_that_does_not_wait_for_leave "uninvited";
}

#[test]
fn sr_006_every_fault_of_the_plugin_is_tried_beside_a_good_one() {
    let mut tried: Vec<&str> = [&["none"], STEERS, IS_REFRESHED].concat();
    let mut all = faulty::Fault::names();
    tried.sort_unstable();
    all.sort_unstable();
    assert_eq!(tried, all);
}

/// The times at which the pilot's modifies leave in four minutes of the steady mission, seconds. Its requests do not
/// depend on its input.
fn pilots_modifies(sibling: &str) -> Vec<f64> {
    let mission = Mission::steady()
        .edit("world.toml", "timeout_s = 600", "timeout_s = 230")
        .append("mission.toml", sibling);
    let log = flies(&mission, &mission.beside("run.mcap"));
    let pilots = |sentence: &str| sentence.starts_with("$BPRMB,") && sentence.contains(",90,8,0,1.5,1,0*");
    let sent = sent(&log).into_iter().filter(|(_, sentence)| pilots(sentence));
    sent.map(|(at_s, _)| at_s).collect()
}

#[test]
fn sr_006_no_fault_moves_a_siblings_refresh_by_a_millisecond() {
    let beside = |fault: &str| {
        pilots_modifies(&format!(
            "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = {EVERY_GRANT}\n\
             [plugin.config]\nfault = \"{fault}\"\nafter_s = 20.0"
        ))
    };
    // Compared with a run beside a good plugin, because a plugin's grants decide the first subscriptions, whose answers
    // bring control.
    let alone = beside("none");
    assert!(alone.len() > 200, "{} modifies in four minutes", alone.len());
    for fault in faulty::Fault::names() {
        let beside = beside(&fault);
        assert_eq!(beside.len(), alone.len(), "{fault}");
        for (beside_s, alone_s) in beside.iter().zip(&alone) {
            assert!(
                (beside_s - alone_s).abs() < 1e-3,
                "{fault}: at {beside_s:.6} s, beside a good one at {alone_s:.6} s"
            );
        }
    }
}

/// The reasons for which requests of the faulty plugin were rejected, other than isobath's steering.
fn rejections(log: &Log) -> Vec<String> {
    log.notes()
        .filter(|(_, note)| note.contains("(plugin 1, ") && note.contains("rejected: ") && !note.contains("priority"))
        .map(|(_, note)| note.to_owned())
        .collect()
}

#[test]
fn figures_that_make_no_sense_are_rejected_by_name() {
    for (fault, word) in [
        ("nan", "is NaN"),
        ("infinite", "is infinite"),
        ("latitude_91", "latitude is 91"),
    ] {
        // Alone, so that no other plugin has priority.
        let mission = Mission::steady()
            .edit("world.toml", "timeout_s = 600", "timeout_s = 60")
            .edit("mission.toml", "[\"modify\"]", "[\"modify\", \"insert\"]")
            .edit("mission.toml", "fault = \"none\"", &format!("fault = \"{fault}\""));
        let report = Backseat::new()
            .args(["sim", "--json"])
            .mission(&mission)
            .run()
            .exit(0)
            .json();
        let rejections = report["rejections"].to_string();
        assert!(rejections.contains(word), "{fault}: {rejections}");
        assert_eq!(report["requests"]["sent"], 0, "{fault}: {report}");
    }
}

#[test]
fn sr_006_the_lease_of_a_plugin_that_fails_ends_at_once_and_the_next_one_steers() {
    // With the faulty plugin first in priority: it steers until it panics, and then isobath does.
    let mission = beside_isobath("trap");
    let text = mission.read("mission.toml");
    let (good, bad) = (text.find("[[plugin]]").unwrap(), text.rfind("[[plugin]]").unwrap());
    let swapped = format!("{}{}{}", &text[..good], &text[bad..], &text[good..bad]);
    let mission = mission.write("mission.toml", swapped);
    let log = flies(&mission, &mission.beside("run.mcap"));
    let notes: Vec<(f64, &str)> = log.notes().map(|(at, note)| (at.as_secs_f64(), note)).collect();
    let failed_s = notes
        .iter()
        .find(|(_, note)| note.starts_with("plugin 0 failed (Trap)"))
        .expect("it panics")
        .0;
    let steered = notes
        .iter()
        .any(|(at_s, note)| *at_s < failed_s && note.contains("(plugin 0, ") && note.contains("accepted"));
    assert!(steered, "it steered before");
    let ended = sent(&log)
        .into_iter()
        .find(|(at_s, sentence)| *at_s >= failed_s && sentence.starts_with("$BPEMB,"));
    let ended_s = ended.expect("a BPEMB ends its lease").0;
    assert!(ended_s - failed_s <= 0.1, "after {:.3} s", ended_s - failed_s);
    let accepted = notes
        .iter()
        .filter(|(at_s, note)| *at_s > failed_s && note.contains("(plugin 1, ") && note.contains("accepted"));
    assert!(accepted.count() > 10, "isobath steers after it");
}

#[test]
fn what_should_stand_for_a_year_is_rejected_and_the_silent_plugins_lease_ends() {
    let mission = Mission::steady()
        .edit("mission.toml", "fault = \"none\"", "fault = \"stale\"\nafter_s = 10.0")
        .edit("mission.toml", "[limits]", "[limits]\nmodify_term_max_s = 30.0");
    let log = flies(&mission, &mission.beside("run.mcap"));
    let year = log
        .notes()
        .find(|(_, note)| note.contains("rejected: ") && note.contains("expected more than 0, at most 30 s"));
    let silent_s = year.expect("a year is over the mission's 30 s").0.as_secs_f64();
    let sent = sent(&log);
    let modifies = |from_s: f64, to_s: f64| {
        let within = |at_s: f64| at_s > from_s && at_s <= to_s;
        let is = |(at_s, sentence): &&(f64, String)| within(*at_s) && sentence.starts_with("$BPRMB,");
        sent.iter().filter(is).count()
    };
    assert!(modifies(0.0, silent_s) > 3, "it steered before");
    // Its last accepted modify lasts for 5 s.
    assert_eq!(modifies(silent_s + 5.0, f64::MAX), 0);
    let ended = sent.iter().rfind(|(_, sentence)| sentence.starts_with("$BPEMB,"));
    assert!(
        ended.is_some_and(|(at_s, _)| *at_s > silent_s && *at_s <= silent_s + 5.1),
        "{ended:?} after {silent_s}"
    );
}

#[test]
fn what_the_bad_plugin_asked_for_never_reached_the_wire() {
    let mission = beside_isobath("cross_fence");
    let log = flies(&mission, &mission.beside("run.mcap"));
    assert!(
        rejections(&log)
            .iter()
            .any(|note| note.contains("Trackline") && note.contains("shelf")),
        "{:?}",
        rejections(&log).first()
    );
    assert!(
        !sent(&log)
            .iter()
            .any(|(_, sentence)| sentence.starts_with("$BPRTK,") || sentence.starts_with("$BPRTC,"))
    );
}

#[test]
fn no_text_becomes_a_sentence_of_its_own() {
    let mission = beside_isobath("reserved_text");
    let log = flies(&mission, &mission.beside("run.mcap"));
    for (at_s, sentence) in sent(&log) {
        assert!(
            !sentence.starts_with("$BPABT") && !sentence.starts_with("$BPKIL"),
            "at {at_s} s: {sentence}"
        );
        assert_eq!(sentence.matches('$').count(), 1, "at {at_s} s: {sentence}");
        assert_eq!(sentence.matches('*').count(), 1, "at {at_s} s: {sentence}");
        assert!(sentence.is_ascii(), "at {at_s} s: {sentence}");
    }
}

#[test]
fn a_flood_is_cut_to_what_the_mission_allows() {
    for (fault, name, per_min) in [
        ("topside_flood", "$BPTOP,", 6),
        ("packet_flood", "$BPCPD,", 12),
        ("gps_flood", "$BPRGP,", 0),
    ] {
        let mission = beside_isobath(fault);
        let log = flies(&mission, &mission.beside("run.mcap"));
        let times: Vec<f64> = sent(&log)
            .into_iter()
            .filter(|(_, sentence)| sentence.starts_with(name))
            .map(|(at_s, _)| at_s)
            .collect();
        for begin_s in &times {
            let within = times.iter().filter(|at_s| (*begin_s..begin_s + 60.0).contains(*at_s));
            let count = within.count();
            assert!(count <= per_min, "{count} of {name} in the minute from {begin_s} s");
        }
    }
}

#[test]
fn the_reasons_of_a_flood_of_requests_add_up_to_all_that_were_rejected() {
    let mission = beside_isobath("light_flood");
    let log = mission.beside("run.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&log)
        .mission(&mission)
        .run()
        .exit(0)
        .json();
    let count = |line: &serde_json::Value| line.as_str()?.split_once(" x ")?.0.parse::<u64>().ok();
    let lines = report["rejections"].as_array().unwrap();
    let told: u64 = lines.iter().map(|line| count(line).unwrap()).sum();
    assert_eq!(report["requests"]["rejected"], told, "{lines:#?}");
    let logged = Backseat::new()
        .args(["log", "report", "--json"])
        .arg(&log)
        .run()
        .exit(0)
        .json();
    let refused = |asked: &serde_json::Value| asked["refused"].as_u64().unwrap();
    let of_log: u64 = logged["asked"].as_object().unwrap().values().map(refused).sum();
    // What was only counted in the last second of the run is in no log.
    assert!(of_log <= told && told - of_log < 2000, "{of_log} of {told}");
    assert!(told > 10_000, "{told}");
}
