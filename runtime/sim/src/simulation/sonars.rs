//! The sonars: the mock payload controller over the simulated world, the client beside core, and the link between them.

use std::collections::VecDeque;

use backseat_core::{Input, ToSonar};
use backseat_plc::{ClientId, FileEffect, FileFailure, FileId, Ping, Plc, SensorKind, Sonar, Stored};
use backseat_scenario::{Scenario, Soundings, true_pose};
use backseat_sonar::Input as ClientInput;
use backseat_sonar_bridge::{Act, Bridge};
use backseat_units::{Timestamp, Utc};
use backseat_world::World;

use crate::digest::Direction;
use crate::link::Lane;
use crate::simulation::{SimError, Simulation};
use crate::trace::Trace;

/// Carries out what the payload controller does with its files, and says what has failed.
pub type FileSink = Box<dyn FnMut(FileEffect) -> Result<(), (FileId, FileFailure)>>;

/// The payload controller, which runs on when the runtime is killed.
pub(super) struct Controller {
    plc: Plc,
    soundings: Soundings<World>,
    to_controller: Lane,
    to_client: Lane,
    client: ClientId,
    connected: bool,
    files: Option<FileSink>,
    scratch: Vec<u8>,
}

impl Controller {
    /// The controller of a scenario, if it has one.
    pub(super) fn new(scenario: &Scenario, seed: u64, utc: Utc) -> Result<Option<Self>, SimError> {
        let Some(plc) = scenario.controller(seed, utc, &Stored::default())? else {
            return Ok(None);
        };
        Ok(Some(Self {
            plc,
            soundings: scenario.soundings(seed)?,
            to_controller: Lane::new(seed, "link to the payload controller"),
            to_client: Lane::new(seed, "link from the payload controller"),
            client: ClientId(0),
            connected: false,
            files: None,
            scratch: Vec::new(),
        }))
    }

    /// When the controller has something to do, and when bytes arrive there and at the client.
    pub(super) fn due(&self) -> [Option<Timestamp>; 3] {
        [
            self.plc.poll_timeout(),
            self.to_controller.next(),
            self.to_client.next(),
        ]
    }

    fn disconnect(&mut self, now: Timestamp) {
        if std::mem::take(&mut self.connected) {
            self.plc.disconnect(now, self.client);
            self.to_controller.cut();
            self.to_client.cut();
        }
    }
}

/// The client in a process of the runtime.
pub(super) struct Client {
    bridge: Bridge,
    /// What core wants of the sonars.
    pub(super) wishes: VecDeque<ToSonar>,
}

impl Client {
    pub(super) const fn new(bridge: Bridge) -> Self {
        Self {
            bridge,
            wishes: VecDeque::new(),
        }
    }

    /// When it has something to do, on its process's clock.
    pub(super) fn due(&self) -> Option<Timestamp> {
        self.bridge.poll_timeout()
    }
}

/// Lets the sonars hear, and notes the pings of the sidescans.
struct Witness<'a> {
    soundings: &'a mut Soundings<World>,
    trace: &'a mut Trace,
}

impl Sonar for Witness<'_> {
    fn side_scan(&mut self, sensor: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>) {
        self.trace.sounding(sensor, ping);
        self.soundings.side_scan(sensor, ping, port, starboard);
    }

    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>) {
        self.soundings.sub_bottom(ping, out);
    }
}

impl Simulation {
    /// Hands the controller's files to `sink`. Without one, they are written nowhere, and no write fails.
    pub fn set_sonar_files(&mut self, sink: FileSink) {
        if let Some(controller) = &mut self.controller {
            controller.files = Some(sink);
        }
    }

    /// Shows the controller where the vehicle is.
    pub(super) fn show_controller(&mut self) {
        if let Some(controller) = &mut self.controller {
            controller.plc.truth(self.now, true_pose(&self.mvc));
        }
    }

    /// The controller's own time has come.
    pub(super) fn controller_due(&mut self) -> Result<(), SimError> {
        if let Some(controller) = &mut self.controller {
            let mut witness = Witness {
                soundings: &mut controller.soundings,
                trace: &mut self.trace,
            };
            controller.plc.handle_timeout(self.now, &mut witness);
        }
        self.drain_controller()
    }

    pub(super) fn arrive_at_controller(&mut self) -> Result<(), SimError> {
        if let Some(controller) = &mut self.controller
            && let Some(bytes) = controller.to_controller.take()
        {
            controller.plc.receive(self.now, controller.client, &bytes);
            controller.to_controller.recycle(bytes);
        }
        self.drain_controller()
    }

    pub(super) fn arrive_at_client(&mut self) -> Result<(), SimError> {
        let Some(bytes) = self
            .controller
            .as_mut()
            .and_then(|controller| controller.to_client.take())
        else {
            return Ok(());
        };
        self.tell_client(ClientInput::Received(&bytes))?;
        if let Some(controller) = &mut self.controller {
            controller.to_client.recycle(bytes);
        }
        Ok(())
    }

    /// The client's own time has come.
    pub(super) fn client_due(&mut self) -> Result<(), SimError> {
        self.tell_client(ClientInput::Timeout)
    }

    fn tell_client(&mut self, input: ClientInput<'_>) -> Result<(), SimError> {
        self.with_client(|bridge, own| bridge.handle(own, input));
        self.drain_client()
    }

    fn with_client(&mut self, act: impl FnOnce(&mut Bridge, Timestamp)) {
        if let Some(process) = &mut self.process {
            let own = process.own_time(self.now);
            if let Some(client) = &mut process.client {
                act(&mut client.bridge, own);
            }
        }
    }

    fn next_act(&mut self) -> Option<Act> {
        self.process.as_mut()?.client.as_mut()?.bridge.poll()
    }

    fn next_wish(&mut self) -> Option<ToSonar> {
        self.process.as_mut()?.client.as_mut()?.wishes.pop_front()
    }

    /// Carries out what the client wants, and tells it what core wants, until neither wants anything.
    pub(super) fn drain_client(&mut self) -> Result<(), SimError> {
        loop {
            if let Some(act) = self.next_act() {
                self.act(act)?;
            } else if let Some(wish) = self.next_wish() {
                self.with_client(|bridge, own| bridge.tell(own, wish));
            } else {
                return Ok(());
            }
        }
    }

    fn act(&mut self, act: Act) -> Result<(), SimError> {
        let now = self.now;
        match act {
            Act::Connect => {
                let connected = self.connect_client();
                self.with_client(|bridge, own| {
                    bridge.handle(
                        own,
                        if connected {
                            ClientInput::Connected
                        } else {
                            ClientInput::Lost
                        },
                    );
                });
                self.drain_controller()
            }
            Act::Disconnect => {
                if let Some(controller) = &mut self.controller {
                    controller.disconnect(now);
                }
                self.with_client(|bridge, own| bridge.handle(own, ClientInput::Lost));
                Ok(())
            }
            Act::Send(bytes) => {
                if let Some(controller) = self.controller.as_mut().filter(|controller| controller.connected) {
                    self.digest.write(Direction::ToController, now, &bytes);
                    controller.to_controller.write(now, &bytes, |_| {});
                }
                Ok(())
            }
            Act::Report(report) => self.feed_core(Input::Sonar(report)),
            Act::Finished => Ok(()),
        }
    }

    /// Whether there is a controller that listens.
    fn connect_client(&mut self) -> bool {
        let Some(controller) = self
            .controller
            .as_mut()
            .filter(|controller| !controller.plc.is_shut_down())
        else {
            return false;
        };
        controller.client = ClientId(controller.client.0 + 1);
        controller.connected = true;
        controller.plc.connect(self.now, controller.client);
        true
    }

    /// The client is gone with its process.
    pub(super) fn lose_client(&mut self) {
        if let Some(controller) = &mut self.controller {
            controller.disconnect(self.now);
        }
    }

    /// The run is over. The controller's log file ends with its catalogue, as at a shutdown.
    pub(super) fn end_sonar_files(&mut self) {
        let Some(controller) = &mut self.controller else { return };
        let Some(files) = &mut controller.files else { return };
        controller.plc.shut_down(self.now);
        while let Some(effect) = controller.plc.poll_file() {
            if let Err((file, failure)) = files(effect) {
                controller.plc.file_failed(self.now, file, failure);
            }
        }
    }

    fn drain_controller(&mut self) -> Result<(), SimError> {
        let now = self.now;
        let Some(controller) = &mut self.controller else {
            return Ok(());
        };
        let mut buffer = std::mem::take(&mut controller.scratch);
        while let Some(to) = controller.plc.poll_transmit(&mut buffer) {
            if controller.connected && to == controller.client {
                self.digest.write(Direction::FromController, now, &buffer);
                controller.to_client.write(now, &buffer, |_| {});
            }
        }
        controller.scratch = buffer;
        while let Some(effect) = controller.plc.poll_file() {
            if let Some(files) = &mut controller.files
                && let Err((file, failure)) = files(effect)
            {
                controller.plc.file_failed(now, file, failure);
            }
        }
        while let Some(event) = controller.plc.poll_event() {
            if let Some(recorder) = &mut self.recorder {
                recorder.vehicle_event(now, &format!("payload controller: {}", event.kind))?;
            }
        }
        let mut cut = false;
        while let Some(client) = controller.plc.poll_disconnect() {
            cut |= client == controller.client;
        }
        if cut && controller.connected {
            controller.disconnect(now);
            self.tell_client(ClientInput::Lost)?;
        }
        Ok(())
    }
}
