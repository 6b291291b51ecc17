"""The SDK for writing plugins in Python.

A plugin is a function of its inputs. The runtime calls ``step`` at the period that the plugin's ``Description`` gives.
Each ``StepInput`` holds the time, the vehicle's navigation, whether the backseat has control, and the events since the
last step. The plugin returns requests. It has no clock, no random numbers, no files and no network, so the same inputs
give the same requests, in simulation and at sea::

    from dataclasses import dataclass
    from backseat_sdk import SECOND_NS, Depth, Description, Modify, Plugin

    class NorthAtTenMetres(Plugin):
        def describe(self):
            return Description("north", "0.1.0", step_period_ns=SECOND_NS)

        def step(self, input):
            if not input.control:
                return []
            return [Modify(tag=1, heading=0.0, vertical=Depth(10.0), speed=1.5, duration_ns=5 * SECOND_NS)]

``python -m backseat_sdk.build DIR -o NAME.wasm`` makes a component of the ``plugin.py`` in a folder. Under plain
Python, 3.11 or later, the same module works without the runtime, and ``backseat_sdk.testing`` steps it. Inside the
component runs Python 3.14 with its standard library and **without numpy** or any other package that has compiled code.
"""

from . import fence, log, measures
from .briefing import Area, Briefing, Budget, Grant, KeepIn, Limits, Zone
from .events import (
    Behavior,
    BehaviorBegan,
    BehaviorEnded,
    Control,
    DvlTriggerAllowed,
    Event,
    LoggingBegan,
    LoggingEnded,
    MissionCommand,
    Plan,
    PlannedElement,
    PlannedPoint,
    ReceivedFrame,
    ReceivedPacket,
    Restored,
    Shutdown,
    Sidescan,
    StepInput,
    SubBottom,
    TimerExpired,
    Topic,
    TopsideMessage,
    Window,
)
from .frame import Local, LocalFrame
from .navigation import Cartesian, Navigation, Relative
from .outcomes import (
    Accepted,
    Cancelled,
    Edge,
    Ended,
    EndKind,
    Failed,
    Failure,
    FrameAcked,
    FrameFailed,
    FrameOther,
    FrameOutcome,
    FrameUnacknowledged,
    FrameUnset,
    NotInPlan,
    Outcome,
    Pending,
    Refusal,
    Rejected,
    Rule,
    Sent,
    SonarFailure,
    Started,
    State,
    TimedOut,
    Unknown,
    VehicleFailure,
)
from .plugin import Description, NoConfig, Plugin, Refused
from .requests import (
    FRAME_BYTES,
    FRAMES,
    TEXT_BYTES,
    AdjustBuoyancy,
    AdjustTrim,
    BottomPosition,
    Camera,
    Cancel,
    DvlTrigger,
    EndModify,
    EndStation,
    GpsHit,
    Here,
    HullPosition,
    Light,
    Message,
    Modify,
    Packet,
    Request,
    Silent,
    SonarAngle,
    SonarLog,
    SonarSet,
    Station,
    StationTarget,
    Timer,
    Topside,
    Trackcircle,
    Trackline,
    Transport,
    is_plain,
)
from .samples import (
    Axes,
    Battery,
    Beams,
    Buoyancy,
    Compass,
    Ctd,
    Dvl,
    DvlBeams,
    Imu,
    Pressure,
    Sample,
    Servo,
    SoundVelocity,
    Surfaces,
    Telemetry,
    Trim,
    VehicleSpeed,
)
from .sonar import (
    ActiveAlarms,
    AltitudeSource,
    ControllerShutdown,
    Decimation,
    PingNavigation,
    PingTime,
    SensorHealth,
    SetDefault,
    SetGain,
    SetPeriod,
    SetPinging,
    SetPower,
    SetPulse,
    SetRange,
    SonarAlarm,
    SonarChannel,
    SonarEvent,
    SonarHealth,
    SonarLogging,
    SonarPing,
    SonarReady,
    SonarSetting,
    SonarSide,
    Swath,
)
from .values import I32, I64, SECOND_NS, U32, U64, Altitude, Depth, Position, Vertical, Within

__all__ = [
    name
    for name, value in globals().items()
    if not name.startswith("_") and (not isinstance(value, type(log)) or value in (fence, log, measures))
]
