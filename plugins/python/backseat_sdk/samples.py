"""Measurements of the vehicle's sensors. Each is an event, for a plugin that lists the sensor's topic.

``age_ns`` is the age of the measurement at this step, ns. ``None`` means that the vehicle sent no value.
"""

from __future__ import annotations

from dataclasses import dataclass

from .values import U32, U64

#: One value for each of the DVL's four beams.
Beams = tuple[float | None, float | None, float | None, float | None]


@dataclass(frozen=True)
class Ctd:
    """Raw data of the CTD sensor (BFCTD, SPI 6.16). Topic ``CTD``.

    - ``conductivity``: microsiemens per centimetre.
    - ``temperature``: degrees Celsius.
    - ``pressure``: kilopascals.
    """

    age_ns: U64
    conductivity: float
    temperature: float
    pressure: float


@dataclass(frozen=True)
class Telemetry:
    """The vehicle's links to the topside in the last and the next minute (BFTEL, SPI 6.3). Topic ``TELEMETRY``.

    - ``acoustic_up_available``, ``acoustic_down_available``: capacity of the acoustic modem for uploads and downloads
      in the next minute, kilobytes.
    - ``acoustic_up_last``, ``acoustic_down_last``: what it carried in the last minute, kilobytes.
    """

    age_ns: U64
    acoustic_up_available: float
    acoustic_up_last: float
    acoustic_down_available: float
    acoustic_down_last: float
    rf_connected: bool
    ethernet_available: bool


@dataclass(frozen=True)
class SoundVelocity:
    """Sound velocity, measured or, on a vehicle without a sensor for it, estimated (BFSVS, SPI 6.4). Topic
    ``SOUND_VELOCITY``.

    - ``velocity``: m/s.
    """

    age_ns: U64
    velocity: float


@dataclass(frozen=True)
class Compass:
    """Raw output of one compass (BFRCM, SPI 6.5). Topic ``COMPASS``.

    - ``number``: the compass's number, from 1.
    - ``heading``, ``pitch``, ``roll``: degrees.
    """

    age_ns: U64
    number: U32
    heading: float
    pitch: float
    roll: float


@dataclass(frozen=True)
class Pressure:
    """Raw output of the depth sensor (BFRDP, SPI 6.6). Topic ``PRESSURE``.

    - ``pressure``: kilopascals.
    """

    age_ns: U64
    pressure: float


@dataclass(frozen=True)
class VehicleSpeed:
    """The thruster's speed, and the estimated speed of the vehicle (BFRVL, SPI 6.7). Topic ``VEHICLE_SPEED``.

    - ``thruster_rpm``: revolutions per minute.
    - ``water_speed``: through the water, m/s; ``None`` if the vehicle cannot determine it.
    """

    age_ns: U64
    thruster_rpm: float
    water_speed: float | None


@dataclass(frozen=True)
class Battery:
    """State of a battery (BFRBS, SPI 6.8). Topic ``BATTERY``.

    - ``number``: the battery's number, from 1; 0 stands for all batteries together.
    - ``voltage``: of the stack, volts.
    - ``cell_min``, ``cell_max``: of the lowest and the highest cell, volts.
    - ``temperature``: of the hottest cell, degrees Celsius.
    - ``capacity``: kilowatt hours.
    - ``charge``: percent.
    """

    age_ns: U64
    number: U32
    voltage: float | None
    cell_min: float | None
    cell_max: float | None
    temperature: float | None
    capacity: float | None
    charge: float | None


@dataclass(frozen=True)
class Surfaces:
    """Angles of elevator and rudder, degrees (BFERC, SPI 6.12). Positive angles pitch up and turn to starboard. Topic
    ``SURFACES``.

    - ``elevator``, ``rudder``: measured.
    - ``elevator_target``, ``rudder_target``: commanded.
    """

    age_ns: U64
    elevator: float
    rudder: float
    elevator_target: float
    rudder_target: float


@dataclass(frozen=True)
class Dvl:
    """Raw output of the Doppler velocity log, DVL (BFDVL, SPI 6.13). Topic ``DVL``.

    - ``velocity_forward``, ``velocity_starboard``, ``velocity_down``: m/s.
    - ``ranges``: of each beam, metres.
    - ``temperature``: degrees Celsius.
    """

    age_ns: U64
    velocity_forward: float | None
    velocity_starboard: float | None
    velocity_down: float | None
    ranges: Beams
    temperature: float | None


@dataclass(frozen=True)
class DvlBeams:
    """Raw output of the DVL for each beam (BFDV2, SPI 6.14). Topic ``DVL_BEAMS``.

    - ``velocities``: of each beam, m/s. On vehicles that do not hover: forward, starboard, down and error velocity.
    - ``ranges``: of each beam, metres.
    - ``temperature``: degrees Celsius.
    """

    age_ns: U64
    velocities: Beams
    ranges: Beams
    temperature: float | None


@dataclass(frozen=True)
class Axes:
    """A vector in the vehicle's axes."""

    forward: float
    starboard: float
    down: float


@dataclass(frozen=True)
class Imu:
    """Raw output of the inertial measurement unit (BFIMU, SPI 6.15). Topic ``IMU``.

    - ``rate``: rotation about each axis, degrees per second, by the right-hand rule.
    - ``acceleration``: along each axis, metres per second squared.
    """

    age_ns: U64
    rate: Axes
    acceleration: Axes


@dataclass(frozen=True)
class Servo:
    """Pitch angles of the servos of DVL and sonar, degrees (BFPIT, SPI 6.18). Topic ``SERVO``."""

    age_ns: U64
    dvl: float
    sonar: float


@dataclass(frozen=True)
class Trim:
    """The vehicle's estimate of its trim (BFTRM, SPI 6.22). Topic ``TRIM``. (To ask for an adjustment, use
    ``AdjustTrim``.)

    - ``adjusting``: an adjustment is in progress, requested or the vehicle's own.
    - ``pitch``, ``roll``: degrees.
    """

    age_ns: U64
    adjusting: bool
    pitch: float
    roll: float


@dataclass(frozen=True)
class Buoyancy:
    """The vehicle's estimate of its buoyancy (BFBOY, SPI 6.23). Topic ``BUOYANCY``. (To ask for an adjustment, use
    ``AdjustBuoyancy``.)

    - ``adjusting``: an adjustment is in progress, requested or the vehicle's own.
    - ``buoyancy``: newtons.
    """

    age_ns: U64
    adjusting: bool
    buoyancy: float


#: A measurement of one of the vehicle's sensors, without the CTD.
Sample = (
    Telemetry
    | SoundVelocity
    | Compass
    | Pressure
    | VehicleSpeed
    | Battery
    | Surfaces
    | Dvl
    | DvlBeams
    | Imu
    | Servo
    | Trim
    | Buoyancy
)
