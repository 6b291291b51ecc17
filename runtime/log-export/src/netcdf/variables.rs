//! The variables of the file: which property of which channel each one is, with its attributes.

/// Navigation, which has a row for each of its messages.
pub(super) const NAVIGATION: &str = "/navigation";
/// What only a simulation knows.
pub(super) const TRUTH: &str = "/truth";
/// Whether the runtime may steer.
pub(super) const CONTROL: &str = "/control";
/// What plugins publish: `/measures/PLUGIN/NAME`.
pub(super) const MEASURES: &str = "/measures/";
const CTD: &str = "/sensors/BFCTD";

/// What a variable is not, in numbers.
pub(super) const FILL: f64 = 9.969_209_968_386_869e36;
/// What a flag is not.
pub(super) const FILL_FLAG: i32 = -2_147_483_647;

/// The coordinates of every other variable.
pub(super) const COORDINATES: &str = "time lat lon depth";

/// A number of a channel.
pub(super) struct Measured {
    pub(super) topic: &'static str,
    /// The path of its property.
    pub(super) property: &'static str,
    pub(super) name: &'static str,
    /// Of CF's table; empty where the table has none.
    pub(super) standard_name: &'static str,
    pub(super) long_name: &'static str,
    /// Of the file.
    pub(super) units: &'static str,
    /// The log's unit in the file's.
    pub(super) per_unit: f64,
    /// The least and the greatest valid value; empty where any number is valid.
    pub(super) range: Option<(f64, f64)>,
    /// Other attributes.
    pub(super) more: &'static [(&'static str, &'static str)],
}

const fn plain(
    [topic, property, name]: [&'static str; 3],
    [standard_name, long_name, units]: [&'static str; 3],
) -> Measured {
    Measured {
        topic,
        property,
        name,
        standard_name,
        long_name,
        units,
        per_unit: 1.0,
        range: None,
        more: &[],
    }
}

const BY_CTD: &[(&str, &str)] = &[("instrument", "instrument_ctd"), ("observation_type", "measured")];

/// The pressure of the CTD, which [`SALINITY`] needs.
pub(super) const PRESSURE: &str = "pressure";
pub(super) const TEMPERATURE: &str = "temperature";
pub(super) const CONDUCTIVITY: &str = "conductivity";

/// All numbers of channels, in the order of the file.
pub(super) const MEASURED: &[Measured] = &[
    Measured {
        range: Some((-90.0, 90.0)),
        more: &[
            ("axis", "Y"),
            ("reference", "WGS84"),
            ("observation_type", "measured"),
            ("ancillary_variables", "gps"),
        ],
        ..plain(
            [NAVIGATION, "latitude_deg", "lat"],
            ["latitude", "Latitude", "degrees_north"],
        )
    },
    Measured {
        range: Some((-180.0, 180.0)),
        more: &[
            ("axis", "X"),
            ("reference", "WGS84"),
            ("observation_type", "measured"),
            ("ancillary_variables", "gps"),
        ],
        ..plain(
            [NAVIGATION, "longitude_deg", "lon"],
            ["longitude", "Longitude", "degrees_east"],
        )
    },
    Measured {
        range: Some((-100.0, 12_000.0)),
        more: &[
            ("axis", "Z"),
            ("positive", "down"),
            ("reference_datum", "sea-surface"),
            ("observation_type", "measured"),
        ],
        ..plain([NAVIGATION, "depth_m", "depth"], ["depth", "Depth", "m"])
    },
    Measured {
        range: Some((0.0, 12_000.0)),
        more: &[("comment", "Absent without bottom lock of the Doppler velocity log.")],
        ..plain(
            [NAVIGATION, "altitude_m", "altitude"],
            ["height_above_sea_floor", "Altitude above the sea floor", "m"],
        )
    },
    Measured {
        range: Some((0.0, 360.0)),
        ..plain(
            [NAVIGATION, "heading_deg", "heading"],
            ["platform_orientation", "True heading", "degree"],
        )
    },
    Measured {
        range: Some((-180.0, 180.0)),
        ..plain(
            [NAVIGATION, "pitch_deg", "pitch"],
            ["platform_pitch_fore_up", "Pitch, nose up positive", "degree"],
        )
    },
    Measured {
        range: Some((-180.0, 180.0)),
        ..plain(
            [NAVIGATION, "roll_deg", "roll"],
            [
                "platform_roll_starboard_down",
                "Roll, starboard down positive",
                "degree",
            ],
        )
    },
    plain(
        [NAVIGATION, "yaw_rate_dps", "yaw_rate"],
        [
            "platform_yaw_rate_fore_starboard",
            "Yaw rate, clockwise positive",
            "degree s-1",
        ],
    ),
    plain(
        [NAVIGATION, "east_mps", "platform_eastward_velocity"],
        ["", "Eastward velocity of the vehicle over the ground", "m s-1"],
    ),
    plain(
        [NAVIGATION, "north_mps", "platform_northward_velocity"],
        ["", "Northward velocity of the vehicle over the ground", "m s-1"],
    ),
    plain(
        [NAVIGATION, "down_mps", "platform_downward_velocity"],
        ["", "Downward velocity of the vehicle", "m s-1"],
    ),
    Measured {
        per_unit: 10.0,
        more: &[
            ("instrument", "instrument_ctd"),
            ("observation_type", "measured"),
            (
                "comment",
                "As the vehicle reports it. SPI does not say whether it counts from zero or from the air's pressure.",
            ),
        ],
        ..plain(
            [CTD, "pressure_kpa", PRESSURE],
            ["sea_water_pressure", "Pressure", "dbar"],
        )
    },
    Measured {
        more: BY_CTD,
        ..plain(
            [CTD, "temperature_c", TEMPERATURE],
            ["sea_water_temperature", "Temperature", "degree_Celsius"],
        )
    },
    Measured {
        per_unit: 10_000.0,
        more: BY_CTD,
        ..plain(
            [CTD, "conductivity_us_per_cm", CONDUCTIVITY],
            ["sea_water_electrical_conductivity", "Conductivity", "S m-1"],
        )
    },
    plain(
        ["/sensors/BFSVS", "sound_velocity_mps", "sound_speed"],
        ["speed_of_sound_in_sea_water", "Speed of sound", "m s-1"],
    ),
    plain(
        ["/sensors/BFRVL", "water_speed_mps", "speed_through_water"],
        ["platform_speed_wrt_sea_water", "Speed through the water", "m s-1"],
    ),
    plain(
        ["/sensors/BFRVL", "thruster_rpm", "thruster_speed"],
        ["", "Revolutions of the thruster", "min-1"],
    ),
    plain(
        [TRUTH, "position.latitude_deg", "true_latitude"],
        ["", "True latitude of the simulated vehicle", "degree"],
    ),
    plain(
        [TRUTH, "position.longitude_deg", "true_longitude"],
        ["", "True longitude of the simulated vehicle", "degree"],
    ),
    plain(
        [TRUTH, "depth_m", "true_depth"],
        ["", "True depth of the simulated vehicle", "m"],
    ),
    plain(
        [TRUTH, "water_depth_m", "water_depth"],
        ["sea_floor_depth_below_sea_surface", "True depth of the water", "m"],
    ),
];

/// What is computed of the CTD's three numbers.
pub(super) const SALINITY: Measured = Measured {
    range: Some((2.0, 42.0)),
    more: &[
        ("instrument", "instrument_ctd"),
        ("observation_type", "calculated"),
        (
            "references",
            "Practical Salinity Scale 1978 (Unesco technical papers in marine science 44)",
        ),
        (
            "comment",
            "Computed from conductivity, temperature and pressure, which is taken as absolute. An error of the air's \
             pressure changes it by 0.005.",
        ),
    ],
    ..plain(
        [CTD, "", "salinity"],
        ["sea_water_practical_salinity", "Practical salinity", "1"],
    )
};

/// What the vehicle's velocity over the ground is as speed and course.
pub(super) const SPEED: Measured = Measured {
    more: &[("observation_type", "calculated")],
    ..plain(
        [NAVIGATION, "", "platform_speed"],
        ["platform_speed_wrt_ground", "Speed over the ground", "m s-1"],
    )
};

/// A state of the run, by number.
pub(super) struct Flag {
    pub(super) name: &'static str,
    pub(super) long_name: &'static str,
    /// Each state's name; its number is its place.
    pub(super) meanings: &'static [&'static str],
    pub(super) comment: &'static str,
    /// ACDD's kind of content.
    pub(super) content: &'static str,
}

/// Whether GPS is in the solution.
pub(super) const GPS: Flag = Flag {
    name: "gps",
    long_name: "GPS in the navigation solution",
    meanings: &["without_gps", "with_gps"],
    comment: "1 where the vehicle's navigation includes GPS.",
    content: "qualityInformation",
};

/// Whether the runtime may steer.
pub(super) const CONTROLS: Flag = Flag {
    name: "control",
    long_name: "Control of the payload computer",
    meanings: &["no_control", "control"],
    comment: "1 where the payload computer can send requests that steer the vehicle.",
    content: "thematicClassification",
};

/// Who steers, by the log's own words.
pub(super) const STEERING: Flag = Flag {
    name: "steering",
    long_name: "Who steers the simulated vehicle",
    meanings: &["nobody", "plan", "modify", "insert"],
    comment: "plan: the front seat, by its own plan. modify: a plugin, by heading, depth and speed. insert: the front \
              seat, by tracklines and circles of a plugin. nobody: before and after the mission, and while it is \
              suspended.",
    content: "thematicClassification",
};

/// The units that a plugin may give and UDUNITS knows, with UDUNITS' name. Others are in the comment only.
pub(super) const PUBLISHED_UNITS: [(&str, &str); 14] = [
    ("m", "m"),
    ("km", "km"),
    ("s", "s"),
    ("min", "min"),
    ("m/s", "m s-1"),
    ("deg", "degree"),
    ("deg/s", "degree s-1"),
    ("degC", "degree_Celsius"),
    ("C", "degree_Celsius"),
    ("%", "percent"),
    ("Hz", "Hz"),
    ("kPa", "kPa"),
    ("dbar", "dbar"),
    ("V", "V"),
];
