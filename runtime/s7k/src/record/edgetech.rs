//! EdgeTech's own headers, which follow the imagery as optional data (appendix A).

use crate::layout::{Range, layouts};
use crate::wire::{Chars, Reserved, codes};

codes! {
    /// What starts a ping.
    pub enum TriggerSource: u16 {
        /// The sonar itself.
        0 Internal,
        /// A signal from outside.
        1 External,
    }

    /// What a stored sample is.
    pub enum EdgeTechFormat: u16 {
        /// One number a sample: the envelope.
        0 Envelope,
        /// Two numbers a sample: real and imaginary part.
        1 Complex,
        /// One number a sample, before the matched filter.
        2 Raw,
        /// One number a sample: the real part of the analytic signal.
        3 RealPart,
        /// One number a sample: pixels (SEG-Y headers only).
        4 Pixel,
    }

    /// The units of coordinates in a SEG-Y header.
    pub enum CoordinateUnits: u16 {
        /// Lengths.
        1 Length,
        /// Seconds of arc.
        2 SecondsOfArc,
    }

    /// Whether SEG-Y data went through a matched filter.
    pub enum Correlated: u16 {
        /// No.
        1 No,
        /// Yes.
        2 Yes,
    }
}

layouts! {
    /// EdgeTech's header of a sidescan channel, 80 bytes. One a channel, port first.
    "Volume III, appendix A, SideScanDefs.h" SideScanHeader side_scan_header {
        /// Subsystem, from 0.
        subsystem: u16, "index", Range::ANY;
        /// Channel, from 0.
        channel: u16, "index", Range::ANY;
        /// Ping number.
        ping: u32, "count", Range::ANY;
        /// Packet of the ping, from 1.
        packet: u16, "count", Range::ANY;
        /// What starts a ping.
        trigger: TriggerSource, "code", Range::ANY;
        /// Samples in this packet.
        samples: u32, "samples", Range::ANY;
        /// Sample interval of the stored data.
        sample_interval_ns: u32, "ns", Range::ANY;
        /// Start of the window.
        start_depth_samples: u32, "samples", Range::ANY;
        /// N, where one step of a sample is 2^-N volts.
        weighting_factor: i16, "exponent", Range::ANY;
        /// Gain of the converter.
        adc_gain: u16, "factor", Range::ANY;
        /// Greatest absolute value of the converter's samples.
        adc_max: u16, "steps", Range::ANY;
        /// Range as set.
        range_dm: u16, "dm", Range::ANY;
        /// Pulse as set.
        pulse_id: u16, "identifier", Range::ANY;
        /// Mark number; 0 for none.
        mark: u16, "count", Range::ANY;
        /// What a sample is.
        data_format: EdgeTechFormat, "code", Range::new(0.0, 3.0);
        /// Reserved.
        reserved: Reserved<2>, "reserved", Range::ANY;
        /// Time of day by the sonar's computer.
        day_ms: u32, "ms", Range::ANY;
        /// Year by the sonar's computer.
        year: i16, "year", Range::new(0.0, 32_767.0);
        /// Day of the year.
        day: u16, "day of year", Range::new(0.0, 366.0);
        /// Hour of the day.
        hour: u16, "h", Range::new(0.0, 23.0);
        /// Minute of the hour.
        minute: u16, "min", Range::new(0.0, 59.0);
        /// Second of the minute.
        second: u16, "s", Range::new(0.0, 60.0);
        /// Compass heading.
        heading_arcmin: i16, "arcmin", Range::new(-21_600.0, 21_600.0);
        /// Pitch.
        pitch_arcmin: i16, "arcmin", Range::new(-10_800.0, 10_800.0);
        /// Roll.
        roll_arcmin: i16, "arcmin", Range::new(-10_800.0, 10_800.0);
        /// Heave.
        heave_cm: i16, "cm", Range::ANY;
        /// Yaw.
        yaw_arcmin: i16, "arcmin", Range::new(-21_600.0, 21_600.0);
        /// Depth of the vehicle.
        depth_cm: u32, "cm", Range::ANY;
        /// Temperature.
        temperature_ddegc: i16, "0.1 degC", Range::ANY;
        /// Reserved.
        reserved_2: Reserved<10>, "reserved", Range::ANY;
    }

    /// EdgeTech's SEG-Y header of a sub-bottom channel, 240 bytes.
    "Volume III, appendix A, SegyDefs.h" SegyHeader segy_header {
        /// Trace sequence number, always 0.
        sequence: i32, "count", Range::new(0.0, 0.0);
        /// Start of the window.
        start_depth_samples: u32, "samples", Range::ANY;
        /// Ping number.
        ping: u32, "count", Range::ANY;
        /// Channel, from 0.
        channel: u32, "index", Range::ANY;
        /// Unused.
        unused_1: Reserved<12>, "unused", Range::ANY;
        /// Trace identification: 1, seismic data.
        trace_id: i16, "code", Range::new(1.0, 1.0);
        /// Unused.
        unused_2: Reserved<4>, "unused", Range::ANY;
        /// What a sample is.
        data_format: EdgeTechFormat, "code", Range::new(0.0, 4.0);
        /// Distance from the towfish to the antenna.
        antenna_r_cm: i16, "cm", Range::ANY;
        /// Distance to the antenna in the direction of starboard.
        antenna_o_cm: i16, "cm", Range::ANY;
        /// Reserved for data of a serial line.
        rs232: Reserved<32>, "reserved", Range::ANY;
        /// Source, x: metres, or seconds of arc east of Greenwich.
        source_x: i32, "m or arcsec", Range::ANY;
        /// Source, y: metres, or seconds of arc north of the equator.
        source_y: i32, "m or arcsec", Range::ANY;
        /// Group, x: millimetres, or ten-thousandths of a minute of arc.
        group_x: i32, "mm or 0.0001 arcmin", Range::ANY;
        /// Group, y: millimetres, or ten-thousandths of a minute of arc.
        group_y: i32, "mm or 0.0001 arcmin", Range::ANY;
        /// Units of the coordinates.
        coordinate_units: CoordinateUnits, "code", Range::new(1.0, 2.0);
        /// Annotation.
        annotation: Chars<24>, "text", Range::ANY;
        /// Samples in this packet. Longer channels take several packets.
        samples: u16, "samples", Range::ANY;
        /// Sample interval of the stored data.
        sample_interval_ns: u32, "ns", Range::ANY;
        /// Gain of the converter.
        adc_gain: u16, "factor", Range::ANY;
        /// Pulse power as set.
        pulse_power_percent: i16, "%", Range::new(0.0, 100.0);
        /// Whether the data went through a matched filter.
        correlated: Correlated, "code", Range::new(1.0, 2.0);
        /// First frequency of the sweep.
        start_frequency_dahz: u16, "10 Hz", Range::ANY;
        /// Last frequency of the sweep.
        end_frequency_dahz: u16, "10 Hz", Range::ANY;
        /// Length of the sweep.
        sweep_ms: u16, "ms", Range::ANY;
        /// Unused.
        unused_7: Reserved<8>, "unused", Range::ANY;
        /// Half the sample frequency.
        alias_frequency: u16, "Hz", Range::ANY;
        /// Pulse as set.
        pulse_id: u16, "identifier", Range::ANY;
        /// Unused.
        unused_8: Reserved<12>, "unused", Range::ANY;
        /// Year by the sonar's computer.
        year: i16, "year", Range::new(0.0, 32_767.0);
        /// Day of the year.
        day: i16, "day of year", Range::new(0.0, 366.0);
        /// Hour of the day.
        hour: i16, "h", Range::new(0.0, 23.0);
        /// Minute of the hour.
        minute: i16, "min", Range::new(0.0, 59.0);
        /// Second of the minute.
        second: i16, "s", Range::new(0.0, 60.0);
        /// Time basis: 3, other.
        time_basis: i16, "code", Range::new(3.0, 3.0);
        /// N, where one step of a sample is 2^-N volts.
        weighting_factor: i16, "exponent", Range::ANY;
        /// Unused.
        unused_9: Reserved<2>, "unused", Range::ANY;
        /// Compass heading.
        heading_cdeg: i16, "0.01 deg", Range::new(-18_000.0, 18_000.0);
        /// Pitch; the specification states no unit.
        pitch: i16, "not stated", Range::ANY;
        /// Roll; the specification states no unit.
        roll: i16, "not stated", Range::ANY;
        /// Temperature.
        temperature_ddegc: i16, "0.1 degC", Range::ANY;
        /// Heave compensation.
        heave_samples: i16, "samples", Range::ANY;
        /// What starts a ping.
        trigger: TriggerSource, "code", Range::ANY;
        /// Mark number; 0 for none.
        mark: u16, "count", Range::ANY;
        /// Hour by the position's source.
        nmea_hour: i16, "h", Range::new(0.0, 23.0);
        /// Minute by the position's source.
        nmea_minute: i16, "min", Range::new(0.0, 59.0);
        /// Second by the position's source.
        nmea_second: i16, "s", Range::new(0.0, 60.0);
        /// Course by the position's source; the specification states no unit.
        nmea_course: i16, "not stated", Range::ANY;
        /// Speed by the position's source; the specification states no unit.
        nmea_speed: i16, "not stated", Range::ANY;
        /// Day by the position's source.
        nmea_day: i16, "day", Range::new(0.0, 366.0);
        /// Year by the position's source.
        nmea_year: i16, "year", Range::new(0.0, 32_767.0);
        /// Time of day.
        day_ms: u32, "ms", Range::ANY;
        /// Greatest absolute value of the converter's samples.
        adc_max: u16, "steps", Range::ANY;
        /// System constant.
        calibration_ddb: i16, "0.1 dB", Range::ANY;
        /// Vehicle.
        vehicle_id: i16, "identifier", Range::ANY;
        /// Version of the sonar's software.
        software_version: Chars<6>, "text", Range::ANY;
        /// First spherical correction.
        spherical_correction_c: i32, "0.01", Range::ANY;
        /// Packet of the ping, from 1.
        packet: u16, "count", Range::ANY;
        /// Decimation before the transform.
        adc_decimation: i16, "factor", Range::ANY;
        /// Decimation after the transform.
        decimation: i16, "factor", Range::ANY;
        /// Unused.
        unused_a: Reserved<14>, "unused", Range::ANY;
    }
}

impl SideScanHeader {
    /// The format of the optional data that hold these headers.
    pub const OPTIONAL_ID: u32 = 1;
}

impl SegyHeader {
    /// The format of the optional data that hold these headers.
    pub const OPTIONAL_ID: u32 = 2;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Offsets that the comments of appendix A state, typed off it.
    #[test]
    fn fields_lie_where_appendix_a_says() {
        let offset = |layout: &crate::Layout, name: &str| {
            layout
                .offsets()
                .find(|(_, field)| field.name == name)
                .map(|(at, _)| at)
                .unwrap()
        };
        assert_eq!(SideScanHeader::SIZE, 80);
        for (name, at) in [
            ("subsystem", 0),
            ("channel", 2),
            ("ping", 4),
            ("packet", 8),
            ("trigger", 10),
            ("samples", 12),
            ("sample_interval_ns", 16),
            ("start_depth_samples", 20),
            ("weighting_factor", 24),
            ("adc_gain", 26),
            ("adc_max", 28),
            ("range_dm", 30),
            ("pulse_id", 32),
            ("mark", 34),
            ("data_format", 36),
            ("reserved", 38),
            ("day_ms", 40),
            ("year", 44),
            ("day", 46),
            ("hour", 48),
            ("minute", 50),
            ("second", 52),
            ("heading_arcmin", 54),
            ("pitch_arcmin", 56),
            ("roll_arcmin", 58),
            ("heave_cm", 60),
            ("yaw_arcmin", 62),
            ("depth_cm", 64),
            ("temperature_ddegc", 68),
            ("reserved_2", 70),
        ] {
            assert_eq!(offset(&SideScanHeader::LAYOUT, name), at, "{name}");
        }
        assert_eq!(SegyHeader::SIZE, 240);
        for (name, at) in [
            ("sequence", 0),
            ("start_depth_samples", 4),
            ("ping", 8),
            ("channel", 12),
            ("unused_1", 16),
            ("trace_id", 28),
            ("unused_2", 30),
            ("data_format", 34),
            ("antenna_r_cm", 36),
            ("antenna_o_cm", 38),
            ("rs232", 40),
            ("source_x", 72),
            ("source_y", 76),
            ("group_x", 80),
            ("group_y", 84),
            ("coordinate_units", 88),
            ("annotation", 90),
            ("samples", 114),
            ("sample_interval_ns", 116),
            ("adc_gain", 120),
            ("pulse_power_percent", 122),
            ("correlated", 124),
            ("start_frequency_dahz", 126),
            ("end_frequency_dahz", 128),
            ("sweep_ms", 130),
            ("unused_7", 132),
            ("alias_frequency", 140),
            ("pulse_id", 142),
            ("unused_8", 144),
            ("year", 156),
            ("day", 158),
            ("hour", 160),
            ("minute", 162),
            ("second", 164),
            ("time_basis", 166),
            ("weighting_factor", 168),
            ("unused_9", 170),
            ("heading_cdeg", 172),
            ("pitch", 174),
            ("roll", 176),
            ("temperature_ddegc", 178),
            ("heave_samples", 180),
            ("trigger", 182),
            ("mark", 184),
            ("nmea_hour", 186),
            ("nmea_minute", 188),
            ("nmea_second", 190),
            ("nmea_course", 192),
            ("nmea_speed", 194),
            ("nmea_day", 196),
            ("nmea_year", 198),
            ("day_ms", 200),
            ("adc_max", 204),
            ("calibration_ddb", 206),
            ("vehicle_id", 208),
            ("software_version", 210),
            ("spherical_correction_c", 216),
            ("packet", 220),
            ("adc_decimation", 222),
            ("decimation", 224),
            ("unused_a", 226),
        ] {
            assert_eq!(offset(&SegyHeader::LAYOUT, name), at, "{name}");
        }
    }
}
