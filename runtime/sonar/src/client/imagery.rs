//! Pings on their way to plugins.

use std::time::Duration;

use backseat_s7k::record::{HeaderLayout, Imagery};
use backseat_s7k::{Frame, SensorIndex};
use backseat_units::{Altitude, Utc};

use super::Sonar;
use crate::config::ExpectedLayout;
use crate::event::Event;
use crate::ping::{PingTime, SonarPing, channels, readable};
use crate::swath::swath;
use crate::vehicle::VehicleNavigation;

/// How often a sensor's swath is reported at most.
const SWATH_EVERY: Duration = Duration::from_secs(1);
/// An older altitude is not the altitude at the ping.
const BOTTOM_LOCK_NANOS: u64 = 2_000_000_000;

impl Sonar {
    fn report_not_subscribed(&mut self, device: u32, record_type: u32) {
        if core::mem::replace(&mut self.not_subscribed, true) {
            return;
        }
        let sensors = self.config.sensor.iter();
        let expected = sensors.map(|sensor| (sensor.device, sensor.records.clone())).collect();
        self.report(Event::NotSubscribed {
            device,
            record_type,
            expected,
        });
    }

    pub(super) fn imagery(&mut self, frame: &Frame<'_>, imagery: &Imagery<'_>, sub_bottom: bool) {
        let header = frame.header();
        let sensor = self.config.sensor_of(header.device.0);
        let subscribed = sensor.filter(|sensor| sensor.records.contains(&header.record_type));
        let Some(sensor) = subscribed.map(|sensor| sensor.index) else {
            self.counts.unsubscribed += 1;
            self.report_not_subscribed(header.device.0, header.record_type);
            return;
        };
        let expected = match self.config.header_layout {
            ExpectedLayout::Any => imagery.layout(),
            ExpectedLayout::Spec => HeaderLayout::Spec,
            ExpectedLayout::Padded => HeaderLayout::Padded,
        };
        self.counts.other_layouts += u64::from(imagery.layout() != expected);
        let read = readable(imagery).count();
        let unread = (imagery.header.channels as usize).saturating_sub(read);
        self.counts.unread_channels += unread as u64;
        if read == 0 {
            return;
        }
        let (time, time_source) = self.time_of(frame);
        let navigation = match time_source {
            PingTime::Measured | PingTime::Arrival => self.vehicle.at(time),
            PingTime::Controller => self.vehicle.newest(),
        }
        .copied();
        if !sub_bottom {
            self.swath(SensorIndex(sensor), imagery, time, navigation.as_ref());
        }
        let sound_speed_mps = self.vehicle.sound_speed_mps();
        for (number, grant) in self
            .grants
            .iter()
            .enumerate()
            .filter(|(_, grant)| grant.sensor == sensor)
        {
            let ping = SonarPing {
                grant: number,
                sensor: SensorIndex(sensor),
                device: header.device,
                sub_bottom,
                ping: imagery.header.ping,
                time,
                time_source,
                arrived: self.now,
                decimation: grant.decimation,
                channels: channels(imagery, grant, sound_speed_mps),
                navigation,
            };
            self.outbox.ping(ping, &mut self.counts);
        }
    }

    /// When the ping was, on our clock.
    fn time_of(&self, frame: &Frame<'_>) -> (Utc, PingTime) {
        let Some(controller) = frame.header().time.to_utc() else {
            return (self.utc(), PingTime::Arrival);
        };
        match self.controller_clock.ours(controller) {
            Some(ours) => (ours, PingTime::Measured),
            None => (controller, PingTime::Controller),
        }
    }

    fn swath(&mut self, sensor: SensorIndex, imagery: &Imagery<'_>, time: Utc, navigation: Option<&VehicleNavigation>) {
        let told = self.swaths.get(&sensor.0);
        if told.is_some_and(|told| self.now.since(*told) < SWATH_EVERY) {
            return;
        }
        let bottom_lock = navigation
            .filter(|known| known.solution.as_unix_nanos().abs_diff(time.as_unix_nanos()) <= BOTTOM_LOCK_NANOS)
            .and_then(|known| known.altitude)
            .map(Altitude::as_m);
        let sound_speed_mps = self.vehicle.sound_speed_mps();
        if let Some(swath) = swath(sensor, imagery, bottom_lock, sound_speed_mps, &mut self.bins) {
            self.swaths.insert(sensor.0, self.now);
            self.tell(Event::Swath(swath));
        }
    }
}
