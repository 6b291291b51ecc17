use backseat_log_export::Format;
use netcdf3::FileReader;

use crate::{Desk, compose};

const FILL: f64 = 9.969_209_968_386_869e36;

/// The file of the composed log without these channels.
fn opened(left_out: &[&str]) -> (Desk, FileReader) {
    let desk = Desk::with(&compose::without(left_out));
    desk.export(Format::Netcdf, "track.nc").unwrap();
    let reader = FileReader::open(desk.at("track.nc")).unwrap();
    (desk, reader)
}

fn text(reader: &FileReader, variable: &str, attribute: &str) -> String {
    let text = reader.data_set().get_var_attr_as_string(variable, attribute);
    text.unwrap_or_else(|| panic!("{variable} has no {attribute}"))
}

#[test]
fn each_solution_is_a_row_with_what_was_measured_nearest_to_it() {
    let (_desk, mut reader) = opened(&[]);
    let times = reader.read_var_f64("time").unwrap();
    let start_s = compose::START_NS as f64 / 1e9;
    assert_eq!(times[0], start_s);
    assert!(times.is_sorted_by(|a, b| a < b) && times.last().is_some_and(|last| *last == start_s + compose::LAST_S));
    let [depth, temperature, altitude] =
        ["depth", "temperature", "altitude"].map(|name| reader.read_var_f64(name).unwrap());
    // No bottom lock in the first 30 s.
    assert_eq!((altitude[149], altitude[150]), (FILL, 40.0 - depth[150]));
    for row in 0..200 {
        let expected = if row % 7 == 0 { 10.25 + depth[row] / 8.0 } else { FILL };
        assert_eq!(temperature[row], expected, "row {row}");
    }
}

#[test]
fn units_and_names_are_those_of_data_centres() {
    let (_desk, mut reader) = opened(&[]);
    for (name, standard_name, units) in [
        ("time", "time", "seconds since 1970-01-01T00:00:00Z"),
        ("lat", "latitude", "degrees_north"),
        ("lon", "longitude", "degrees_east"),
        ("depth", "depth", "m"),
        ("pressure", "sea_water_pressure", "dbar"),
        ("conductivity", "sea_water_electrical_conductivity", "S m-1"),
        ("salinity", "sea_water_practical_salinity", "1"),
        ("heading", "platform_orientation", "degree"),
    ] {
        assert_eq!(text(&reader, name, "standard_name"), standard_name);
        assert_eq!(text(&reader, name, "units"), units);
    }
    assert_eq!(text(&reader, "trajectory", "cf_role"), "trajectory_id");
    assert_eq!(text(&reader, "depth", "positive"), "down");
    assert_eq!(text(&reader, "salinity", "coordinates"), "time lat lon depth");
    assert_eq!(text(&reader, "measure_pilot_slope", "units"), "percent");
    let [pressure, conductivity, salinity, slope] =
        ["pressure", "conductivity", "salinity", "measure_pilot_slope"].map(|name| reader.read_var_f64(name).unwrap());
    assert_eq!(pressure[0], 10.1325);
    assert_eq!((conductivity[0], salinity[0]), (FILL, FILL));
    let depth = reader.read_var_f64("depth").unwrap()[140];
    assert_eq!(conductivity[140], (39_000.5 - depth) / 10_000.0);
    assert!((30.0..40.0).contains(&salinity[140]), "{}", salinity[140]);
    assert_eq!(slope.iter().filter(|value| **value != FILL).collect::<Vec<_>>(), [&3.5]);
}

#[test]
fn flags_say_who_may_steer_and_who_steers() {
    let (_desk, mut reader) = opened(&[]);
    assert_eq!(text(&reader, "control", "flag_meanings"), "no_control control");
    assert_eq!(text(&reader, "steering", "flag_meanings"), "nobody plan modify insert");
    let control = reader.read_var_i32("control").unwrap();
    assert_eq!(
        control.iter().position(|control| *control == 1),
        Some(5),
        "granted after 1 s"
    );
    let steering = reader.read_var_i32("steering").unwrap();
    assert!(steering.iter().all(|steering| *steering == 2));
    let (_desk, reader) = opened(&["/truth", "/sensors", "/measures"]);
    for absent in [
        "steering",
        "true_depth",
        "salinity",
        "instrument_ctd",
        "measure_pilot_slope",
    ] {
        assert!(!reader.data_set().has_var(absent), "{absent}");
    }
}

#[test]
fn a_log_gives_the_same_bytes_each_time_and_wherever_it_is() {
    let [one, other] = [(); 2].map(|()| {
        let (desk, _) = opened(&[]);
        std::fs::read(desk.at("track.nc")).unwrap()
    });
    assert!(one == other);
}

#[test]
fn a_log_without_navigation_gets_one_line_and_an_earlier_export_stays() {
    let desk = Desk::with(&compose::without(&["/navigation"]));
    std::fs::write(desk.at("track.nc"), "earlier").unwrap();
    let error = desk.export(Format::Netcdf, "track.nc").unwrap_err().to_string();
    assert!(
        error.ends_with("dive.mcap: no position on /navigation, so there is no trajectory to write"),
        "{error}"
    );
    assert_eq!(std::fs::read(desk.at("track.nc")).unwrap(), b"earlier");
    assert_eq!(desk.names(), ["dive.mcap", "track.nc"]);
}
