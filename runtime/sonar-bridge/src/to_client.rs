//! From core's types to the client's.

use backseat_core::plugin::{NavigationSample, SonarSetting};
use backseat_core::{SonarOrder, SonarRates};
use backseat_s7k::SensorIndex;
use backseat_s7k::plc::Generic;
use backseat_sonar::{Order, VehicleNavigation, VehicleRates};
use backseat_units::{Timestamp, Utc};

pub(crate) fn order(order: &SonarOrder) -> Result<Order, &'static str> {
    Ok(match order {
        SonarOrder::Log {
            on: false,
            file: Some(_),
        } => return Err("a file name needs logging on"),
        SonarOrder::Log { on, file } => Order::Logging {
            on: *on,
            file: file.as_deref().map(Box::from),
        },
        SonarOrder::Set { sensor, setting } => Order::Set {
            sensor: SensorIndex(*sensor),
            setting: generic(setting),
        },
    })
}

fn generic(setting: &SonarSetting) -> Generic {
    match setting {
        SonarSetting::RangeM(range_m) => Generic::Range { range_m: *range_m },
        SonarSetting::Pulse(name) => Generic::Pulse {
            name: Box::from(name.as_str()),
        },
        SonarSetting::Ping(on) => Generic::Ping { on: *on },
        SonarSetting::PowerPercent(percent) => Generic::TxPower { percent: *percent },
        SonarSetting::Gain(gain) => Generic::RxGain { gain: *gain },
        SonarSetting::PeriodMs(period_ms) => Generic::Duration { period_ms: *period_ms },
        SonarSetting::DefaultState => Generic::DefaultState {},
    }
}

pub(crate) fn navigation(
    sample: &NavigationSample,
    rates: Option<SonarRates>,
    utc: impl Fn(Timestamp) -> Utc,
) -> VehicleNavigation {
    VehicleNavigation {
        solution: utc(sample.solution),
        position: sample.position,
        depth: sample.depth,
        altitude: sample.altitude,
        heading: sample.heading,
        roll_deg: sample.roll_deg,
        pitch_deg: sample.pitch_deg,
        rates: rates.map(|rates| VehicleRates {
            east_mps: sample.east_mps,
            north_mps: sample.north_mps,
            down_mps: sample.down_mps,
            roll_rate_dps: rates.roll_rate_dps,
            pitch_rate_dps: rates.pitch_rate_dps,
            yaw_rate_dps: sample.yaw_rate_dps,
        }),
    }
}
