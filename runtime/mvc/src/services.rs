//! What the vehicle does for its payloads apart from its mission. Each section of SPI is one type, which handles its
//! commands, a step of the vehicle ([`Services::step`]) and the end of a connection ([`Services::client_left`]).

mod acoustic;
mod adjustment;
mod dvl_trigger;
mod hovering;
mod power;
mod silence;
mod times;
mod topside;

use backseat_spi::SilentMode;
use backseat_world::World;

use self::acoustic::Acoustic;
use self::adjustment::Adjustment;
use self::dvl_trigger::DvlTrigger;
use self::hovering::Hovering;
use self::power::Power;
use self::silence::{Devices, Silence};
use self::topside::Topside;
use crate::context::{Context, Quiet};
use crate::event::ClientId;
use crate::executive::mission::Mission;
use crate::file::WorldFile;
use crate::server::answers::Regarding;
use crate::vehicle::{Drive, Vehicle};

/// The services, one for each section of SPI.
#[derive(Debug)]
pub(crate) struct Services {
    pub(crate) acoustic: Acoustic,
    pub(crate) adjustment: Adjustment,
    pub(crate) dvl_trigger: DvlTrigger,
    pub(crate) hovering: Hovering,
    pub(crate) power: Power,
    silence: Silence,
    pub(crate) topside: Topside,
}

impl Services {
    pub(crate) fn new(file: &WorldFile, world: &World, vehicle: &mut Vehicle, seed: u64) -> Self {
        Self {
            acoustic: Acoustic::new(file, seed),
            adjustment: Adjustment::new(file, seed),
            dvl_trigger: DvlTrigger::new(file),
            hovering: Hovering::new(file, world, vehicle, seed),
            power: Power::new(file, seed),
            silence: Silence::new(file, vehicle, seed),
            topside: Topside::new(file),
        }
    }

    /// How quiet the vehicle is.
    pub(crate) fn quiet(&self, vehicle: &Vehicle) -> Quiet {
        self.silence.quiet(vehicle)
    }

    /// Handles the end of a connection. The vehicle still decides about its requests, but no longer answers them.
    pub(crate) fn client_left(&mut self, client: ClientId) {
        self.silence.client_left(client);
        self.dvl_trigger.client_left(client);
    }

    /// BPSIL (SPI 7.22).
    pub(crate) fn silent_mode(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &SilentMode) {
        let (silence, mut devices) = self.silence_and_devices();
        silence.request(ctx, re, request, &mut devices);
    }

    /// What actually moves the vehicle when its mission demands `drive`.
    pub(crate) fn quieted(&mut self, ctx: &mut Context<'_>, drive: Drive) -> Drive {
        let (silence, mut devices) = self.silence_and_devices();
        silence.quieted(ctx, drive, &mut devices)
    }

    /// The part of a vehicle's step up to the payload's power. Returns whether the power goes off in this step.
    #[must_use]
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) -> bool {
        let (silence, mut devices) = self.silence_and_devices();
        silence.step(ctx, &mut devices);
        ctx.quiet = self.quiet(ctx.vehicle);
        self.adjustment.step(ctx);
        self.power.step(ctx)
    }

    /// The rest of the same step, if the payload's power stays on.
    pub(crate) fn step_on(&mut self, ctx: &mut Context<'_>, mission: &Mission) {
        self.dvl_trigger.step(ctx);
        self.topside.step(ctx);
        self.acoustic.step(ctx);
        self.hovering.step(ctx, mission);
    }

    /// Handles the begin or the end of a fault that takes the payload's power. Returns whether the power goes off now.
    #[must_use]
    pub(crate) fn shut_down(&mut self, ctx: &mut Context<'_>, begins: bool) -> bool {
        if begins {
            self.power.shut_down(ctx.now);
        }
        self.power.watch(ctx)
    }

    fn silence_and_devices(&mut self) -> (&mut Silence, Devices<'_>) {
        let devices = Devices {
            adjustment: &mut self.adjustment,
            acoustic: &mut self.acoustic,
        };
        (&mut self.silence, devices)
    }
}
