use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// Values of each side of a [`Item::Ping`].
pub(crate) const PING_BINS: usize = 128;
/// A pace of this or more is as fast as can be.
pub(crate) const PACE_MAX: f64 = 10_000.0;

/// Something that happened, in the words of the page. Times are seconds since the start of the run; positions are WGS 84
/// degrees; lengths metres, speeds m/s, angles degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Item {
    /// Navigation as the runtime uses it.
    Navigation {
        /// Latitude.
        lat: f64,
        /// Longitude.
        lon: f64,
        /// Depth.
        depth_m: f64,
        /// Altitude above the seabed, with bottom lock.
        #[serde(skip_serializing_if = "Option::is_none")]
        altitude_m: Option<f64>,
        /// Heading, from north.
        heading_deg: f64,
        /// Roll.
        roll_deg: f64,
        /// Pitch.
        pitch_deg: f64,
        /// Speed over ground.
        speed_mps: f64,
        /// Course over ground, from north.
        course_deg: f64,
        /// Turn rate.
        yaw_rate_dps: f64,
        /// Whether it is from a GPS fix.
        gps: bool,
    },
    /// The heartbeat both ways, once a second.
    Beat(Beat),
    /// The runtime's own status, as it tells it to the vehicle.
    Status {
        /// In words.
        text: String,
    },
    /// Whether requests can be sent.
    Control {
        /// True if so.
        granted: bool,
        /// Why not.
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<String>,
    },
    /// Who steers by a modify, and how.
    Steering(Steering),
    /// The vehicle's mission.
    Mission {
        /// As the vehicle says it.
        status: String,
    },
    /// An element of the vehicle's plan began or ended.
    Behavior {
        /// True if it began.
        began: bool,
        /// Its number in the plan.
        #[serde(skip_serializing_if = "Option::is_none")]
        number: Option<u64>,
        /// What it is.
        behavior: String,
    },
    /// A new state of a request.
    Request {
        /// Its number.
        request: u64,
        /// The plugin's name, or `operator` or `external`.
        owner: String,
        /// What it asks for.
        request_kind: String,
        /// The state.
        state: String,
        /// The plugin's tag.
        #[serde(skip_serializing_if = "Option::is_none")]
        tag: Option<u64>,
        /// Why it was refused, has failed or has ended.
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<String>,
        /// The identifier by which the vehicle knows it.
        #[serde(skip_serializing_if = "Option::is_none")]
        identifier: Option<u64>,
    },
    /// How many requests came to which state.
    Counts {
        /// Of all.
        #[serde(flatten)]
        all: Counts,
        /// By the owner's name.
        by: BTreeMap<String, Counts>,
    },
    /// A plugin's state.
    Plugin {
        /// Its name.
        plugin: String,
        /// `running`, `failed` or `quarantined`.
        state: &'static str,
        /// What failed.
        #[serde(skip_serializing_if = "Option::is_none")]
        text: Option<String>,
        /// How often it has failed.
        failures: u64,
    },
    /// How much of its budget a plugin used.
    Headroom {
        /// Its name.
        plugin: String,
        /// The largest share of its fuel that a step used, 0 to 1.
        #[serde(skip_serializing_if = "Option::is_none")]
        fuel: Option<f64>,
        /// Steps so far.
        steps: u64,
    },
    /// A line of somebody's log.
    Line {
        /// `debug`, `info`, `warn` or `error`.
        level: &'static str,
        /// `runtime`, `vehicle`, `operator` or `plugin NAME`.
        who: String,
        /// The line.
        text: String,
    },
    /// A value that a plugin publishes.
    Measure {
        /// Its name.
        plugin: String,
        /// The value's name.
        name: String,
        /// The value.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// A sentence of the vehicle that is a measurement.
    Sensor {
        /// The sentence's name.
        name: String,
        /// Its fields.
        data: Value,
    },
    /// A layer of the map, which replaces the last one.
    Map {
        /// `plan`, `inserts` or `requests`.
        layer: &'static str,
        /// The layer.
        geojson: Value,
    },
    /// Where the live modify can lead: all places within a radius of a line. A radius of 0: nothing steers any more.
    Reach {
        /// Latitude of the vehicle.
        lat: f64,
        /// Longitude of the vehicle.
        lon: f64,
        /// Latitude of the end of the line.
        ahead_lat: f64,
        /// Longitude of the end of the line.
        ahead_lon: f64,
        /// Metres.
        radius_m: f64,
    },
    /// The operator acted.
    Operator {
        /// `hold`, `release`, `stop` or `order`.
        act: String,
        /// Who, if it was somebody at a console.
        #[serde(skip_serializing_if = "Option::is_none")]
        who: Option<String>,
    },
    /// Navigation became implausible or good again.
    Integrity {
        /// Whether it is good.
        ok: bool,
        /// In words.
        text: String,
    },
    /// Whether the log of the run is written.
    Recording {
        /// False if it has ended, or the disk is too slow.
        written: bool,
        /// In words.
        text: String,
    },
    /// What the sonars' payload controller said.
    Sonar {
        /// In words.
        text: String,
    },
    /// A ping of the sidescan, as the first plugin that listens to it gets it.
    Ping {
        /// The sensor's index in the payload controller.
        sensor: i64,
        /// To port, from the vehicle outwards: 128 bytes as hexadecimal digits, each in half decibels over one step
        /// of the converter. Absent without this side.
        #[serde(skip_serializing_if = "Option::is_none")]
        port: Option<String>,
        /// To starboard.
        #[serde(skip_serializing_if = "Option::is_none")]
        starboard: Option<String>,
        /// Slant range of the last sample.
        range_m: f64,
    },
    /// How wide a strip of the seabed a ping showed, and where the vehicle was.
    Swath {
        /// Latitude.
        lat: f64,
        /// Longitude.
        lon: f64,
        /// Heading, from north.
        heading_deg: f64,
        /// Over the ground to port.
        port_m: f64,
        /// Over the ground to starboard.
        starboard_m: f64,
    },
    /// A place that a plugin tells of in a line of its log: `contact NAME ... at LATITUDE LONGITUDE ...`. A later one of the
    /// same name replaces it.
    Contact {
        /// The plugin.
        plugin: String,
        /// The plugin's name for it.
        name: String,
        /// Latitude.
        lat: f64,
        /// Longitude.
        lon: f64,
        /// The line.
        text: String,
    },
    /// How fast a simulation goes.
    Pace {
        /// Times real time; 0 stands, and 10,000 is as fast as can be.
        times: f64,
    },
    /// What only a simulation knows.
    Truth {
        /// Latitude.
        lat: f64,
        /// Longitude.
        lon: f64,
        /// Depth.
        depth_m: f64,
        /// Depth of the seabed.
        #[serde(skip_serializing_if = "Option::is_none")]
        water_depth_m: Option<f64>,
    },
    /// The run is over.
    End {
        /// In words.
        text: String,
    },
}

/// The heartbeat both ways. What is absent has not happened yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Beat {
    /// When the last modify was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refreshed: Option<f64>,
    /// The longest time between two modifies of one lease.
    pub worst_gap_s: f64,
    /// How long the vehicle took to acknowledge the last command that it acknowledged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub round_trip_s: Option<f64>,
    /// When that acknowledgement came.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acknowledged: Option<f64>,
    /// When the vehicle was last heard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heard: Option<f64>,
    /// The time of the newest navigation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub navigated: Option<f64>,
}

/// Who steers by a modify, and how; nobody if there is no owner.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Steering {
    /// The plugin's name, or `operator` or `external`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owner: Option<String>,
    /// The heading that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading_deg: Option<f64>,
    /// The rudder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rudder_deg: Option<f64>,
    /// The depth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
    /// The altitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
    /// The speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
    /// Why the last one ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// How many requests came to which state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Refused by the runtime.
    pub rejected: u64,
    /// Sent.
    pub sent: u64,
    /// Accepted by the vehicle.
    pub accepted: u64,
    /// Failed, by the vehicle's word or its silence.
    pub failed: u64,
}
