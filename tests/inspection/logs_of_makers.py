"""Logs as they come from tools of many makers, with a plausible machine behind the numbers.

Each is a `Log`: what the file holds, and what its columns must be taken for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import numpy as np

ROWS = 700
PERIOD_S = 0.02
_DRAWN = np.random.default_rng(11).standard_normal((12, ROWS))
T_S = PERIOD_S * np.arange(ROWS)
START = datetime(2024, 3, 5, 9, 12, 5, 693_000, tzinfo=UTC)


def asked(motor: int = 0) -> np.ndarray:
    """A command [rad] that no other motor has."""
    return 0.7 * np.sin((1.7 + 0.3 * motor) * T_S + motor) + 0.3 * np.sin(3.1 * T_S - 2.0 * motor)


def seen(motor: int = 0) -> np.ndarray:
    """What is read of it: 50 ms late, and noisy."""
    return np.interp(T_S - 0.05, T_S, asked(motor)) + 0.002 * _DRAWN[motor]


def speed(motor: int = 0) -> np.ndarray:
    return np.gradient(asked(motor), T_S)


def current(motor: int = 0) -> np.ndarray:
    """What it takes to move: inertia, friction, noise."""
    pull = np.gradient(speed(motor), T_S) + 0.4 * np.sign(speed(motor))
    return 0.3 * pull + 0.02 * _DRAWN[6 + motor % 6]


@dataclass(frozen=True)
class Log:
    """A file's text, and what its columns must be taken for."""

    text: str
    kind: str | None
    taken: dict[str, str]
    """Column of the program -> column of the file."""
    units: dict[str, str] = field(default_factory=dict)
    """Unit of some of them."""
    says: Sequence[str] = ()
    """Parts of what is said besides."""


def rows(
    columns: Iterable[np.ndarray | list[str]], separator: str = ",", decimal: str = "."
) -> str:
    def cell(value: object) -> str:
        return value if isinstance(value, str) else f"{value:.15g}".replace(".", decimal)

    lines = (separator.join(map(cell, row)) for row in zip(*columns, strict=True))
    return "\n".join(lines) + "\n"


def moments(form: str) -> list[str]:
    """Times of the rows, as strftime has them; @@@ stands for the milliseconds."""
    at = [START + timedelta(seconds=float(t)) for t in T_S]
    return [one.strftime(form).replace("@@@", f"{one.microsecond // 1000:03d}") for one in at]


def joints(number: int) -> list[np.ndarray]:
    return [part(n) for part in (asked, seen, current) for n in range(number)]


DEG = np.degrees
COUNTS = 4096 / (2.0 * np.pi)
AXIS = {"t": "time", "command": "command", "position": "position"}

ROS_FLAT = Log(
    "time,/joint_states.position[0],/joint_states.velocity[0],/joint_states.effort[0],"
    "/reference.data[0]\n" + rows([T_S + 1.7e9, seen(), speed(), current(), asked()]),
    "servo_axis",
    {
        "t": "time", "position": "/joint_states.position[0]", "command": "/reference.data[0]",
        "velocity": "/joint_states.velocity[0]", "effort": "/joint_states.effort[0]",
    },
)  # fmt: skip
ROSTOPIC = Log(
    "%time,field.header.seq,field.header.stamp,field.position0,field.position1,field.position2,"
    "field.position3,field.position4,field.position5\n"
    + rows([1e9 * (T_S + 1.7e9), np.arange(ROWS), 1e9 * (T_S + 1.7e9), *map(seen, range(6))]),
    None, {"t": "time", "position": "field.position0"}, {"t": "ns"},
    ["more joints than one", "--set"],
)  # fmt: skip
PLOTJUGGLER = Log(
    "__time,/joint_states/elbow/position,/joint_states/elbow/velocity,"
    "/controller/reference/elbow/position\n" + rows([T_S + 1.7e9, seen(), speed(), asked()]),
    "servo_axis",
    {
        "t": "__time", "position": "/joint_states/elbow/position",
        "velocity": "/joint_states/elbow/velocity",
        "command": "/controller/reference/elbow/position",
    },
)  # fmt: skip
LEROBOT_JOINTS = ("shoulder_pan.pos", "shoulder_lift.pos", "elbow_flex.pos", "gripper.pos")
LEROBOT = Log(
    ",".join(["index", "timestamp", *(f"{side}.{joint}" for side in ("action", "observation.state")
                                      for joint in LEROBOT_JOINTS)]) + "\n"
    + rows([np.arange(ROWS), T_S, *(DEG(part(n)) for part in (asked, seen) for n in range(4))]),
    "servo_axis",
    {
        "t": "timestamp", "command": "action.shoulder_pan.pos",
        "position": "observation.state.shoulder_pan.pos",
    },
    {"command": "deg", "position": "deg"}, ["more joints than one"],
)  # fmt: skip
DYNAMIXEL = Log(
    "Time(ms),Goal Position,Present Position,Present Velocity,Present Current\n"
    + rows([1e3 * T_S, *(np.round(2048 + COUNTS * one) for one in (asked(), seen())),
            np.round(speed() * 60.0 / (2.0 * np.pi) / 0.229), np.round(1e3 * current() / 2.69)]),
    "servo_axis",
    {
        "t": "Time(ms)", "command": "Goal Position", "position": "Present Position",
        "effort": "Present Current",
    },
    {"t": "ms"}, ["4096 a turn", "Present Velocity: is left out"],
)  # fmt: skip
ODRIVE = Log(
    "time,axis0.controller.pos_setpoint,axis0.encoder.pos_estimate,axis0.encoder.vel_estimate,"
    "axis0.motor.current_control.Iq_setpoint,axis0.motor.current_control.Iq_measured\n"
    + rows([T_S, asked() / 6.2832, seen() / 6.2832, speed() / 6.2832, current(), current()]),
    "servo_axis",
    {
        "t": "time", "command": "axis0.controller.pos_setpoint",
        "position": "axis0.encoder.pos_estimate", "velocity": "axis0.encoder.vel_estimate",
        "effort": "axis0.motor.current_control.Iq_measured",
    },
)  # fmt: skip
KLIPPER = Log(
    "#time,accel_x,accel_y,accel_z\n" + rows([T_S + 4132.0, *(1e3 * _DRAWN[:3])]),
    None, {"t": "time"}, {}, ["not enough is known", "--set position="],
)  # fmt: skip
HALSAMPLER = Log(
    rows([np.arange(ROWS) * 1.0, 100 * asked(), 100 * seen(), 100 * (asked() - seen())], " "),
    "servo_axis",
    {"t": "column_1", "command": "column_2", "position": "column_3"}, {}, ["rate_hz"],
)  # fmt: skip
TWINCAT = Log(
    "Name\tScope Project\nFile\tC:\\Scope\\Axis.svdx\nStarttime of export\t09:12:05\n\n"
    "Time\tAxis 1.SetPos\tAxis 1.ActPos\tAxis 1.ActTorque\n[ms]\t[mm]\t[mm]\t[%]\n"
    + rows([1e3 * T_S, 100 * asked(), 100 * seen(), 10 * current()], "\t", ","),
    "servo_axis",
    {
        "t": "Time", "command": "Axis 1.SetPos", "position": "Axis 1.ActPos",
        "effort": "Axis 1.ActTorque",
    },
    {"t": "ms", "command": "mm", "position": "mm"},
)  # fmt: skip
EPICS = Log(
    "# Archiver export\nTime,IOC:m1.VAL,IOC:m1.RBV\n"
    + rows([moments("%Y-%m-%d %H:%M:%S.@@@000000"), 10 * asked(), 10 * seen()]),
    "servo_axis", {"t": "Time", "command": "IOC:m1.VAL", "position": "IOC:m1.RBV"},
)  # fmt: skip
RTDE = Log(
    " ".join(["timestamp", *(f"{stem}_{n}" for stem in ("target_q", "actual_q", "actual_current")
                             for n in range(6))]) + "\n"
    + rows([T_S + 1612345678.0, *joints(6)], " "),
    "servo_axis",
    {
        "t": "timestamp", "command": "target_q_0", "position": "actual_q_0",
        "effort": "actual_current_0",
    },
    {}, ["more joints than one"],
)  # fmt: skip
KUKA = Log(
    "Zeit [s];A1 Sollposition [\u00b0];A1 Istposition [\u00b0];A1 Motorstrom [A]\n"
    + rows([T_S, DEG(asked()), DEG(seen()), current()], ";", ","),
    "servo_axis",
    {
        "t": "Zeit [s]", "command": "A1 Sollposition [\u00b0]",
        "position": "A1 Istposition [\u00b0]", "effort": "A1 Motorstrom [A]",
    },
    {"command": "deg", "effort": "A"},
)  # fmt: skip
KUKA_VARIABLES = Log(
    "$TIME;$AXIS_CMD.A1;$AXIS_ACT.A1\n" + rows([T_S, DEG(asked()), DEG(seen())], ";"),
    "servo_axis", {"t": "$TIME", "command": "$AXIS_CMD.A1", "position": "$AXIS_ACT.A1"},
)  # fmt: skip
ABB = Log(
    "Time (s),Joint 1 Position Ref (rad),Joint 1 Position (rad),Joint 1 Torque (Nm)\n"
    + rows([T_S, asked(), seen(), current()]),
    "servo_axis",
    {
        "t": "Time (s)", "command": "Joint 1 Position Ref (rad)",
        "position": "Joint 1 Position (rad)", "effort": "Joint 1 Torque (Nm)",
    },
    {"command": "rad", "effort": "Nm"}, ["put load in place of effort"],
)  # fmt: skip
PHD2 = Log(
    "PHD2 version 2.6.11, Log version 2.5. Log enabled at 2024-03-05 21:12:05\n"
    "Exposure = 2000 ms\n\nFrame,Time,mount,dx,dy,RARawDistance,DECRawDistance,RADirection\n"
    + rows([np.arange(ROWS) + 1.0, 2.1 * np.arange(ROWS), ["Mount"] * ROWS, *_DRAWN[:2],
            *_DRAWN[2:4], ["W"] * ROWS]),
    None, {"t": "Time"}, {}, ["not enough is known"],
)  # fmt: skip
ARDUINO = Log(
    "".join(f"{at} -> {c:.2f},{p:.2f}\n" for at, c, p in zip(
        moments("%H:%M:%S.@@@"), DEG(asked()), DEG(seen()), strict=True)),
    "servo_axis", {"t": "column_1", "command": "column_2", "position": "column_3"},
)  # fmt: skip
ARDUINO_NAMED = Log(
    "millis,setpoint,angle\n" + rows([1e3 * T_S, DEG(asked()), DEG(seen())]),
    "servo_axis", {"t": "millis", "command": "setpoint", "position": "angle"}, {"t": "ms"},
)  # fmt: skip
SALEAE = Log(
    "Time [s],Channel 0,Channel 1\n"
    + rows([T_S, np.sign(_DRAWN[0]) > 0, np.sign(_DRAWN[1]) > 0]).replace("True", "1").replace(
        "False", "0"),
    None, {"t": "Time [s]"}, {}, ["not enough is known"],
)  # fmt: skip
SIEMENS = Log(
    "Sample;Timestamp [ms];Axis_1.Position [mm];Axis_1.ActualPosition [mm]\n"
    + rows([np.arange(ROWS), 1e3 * T_S, 100 * asked(), 100 * seen()], ";"),
    "servo_axis",
    {
        "t": "Timestamp [ms]", "command": "Axis_1.Position [mm]",
        "position": "Axis_1.ActualPosition [mm]",
    },
    {"t": "ms", "position": "mm"},
)  # fmt: skip
EXCEL = Log(
    "Zeit;Sollwert;Istwert\n"
    + rows([moments("%d.%m.%Y %H:%M:%S,@@@"), 100 * asked(), 100 * seen()], ";", ","),
    "servo_axis", {"t": "Zeit", "command": "Sollwert", "position": "Istwert"}, {"t": "s"},
)  # fmt: skip
NUMBERED = Log(
    "time,set1,set2,set3,meas1,meas2,meas3\n"
    + rows([T_S, *(DEG(part(n)) for part in (asked, seen) for n in range(3))]),
    "delta",
    {
        "t": "time", **{f"command_{n}": f"set{n}" for n in (1, 2, 3)},
        **{f"theta_{n}": f"meas{n}" for n in (1, 2, 3)},
    },
    {"theta_2": "deg"},
)  # fmt: skip
MOTEUS = Log(
    "TIME,POSITION,CONTROL_POSITION,COMMAND_POSITION,VELOCITY,CONTROL_VELOCITY,COMMAND_VELOCITY,"
    "TORQUE,CONTROL_TORQUE,Q_CURRENT,FAULT\n"
    + rows([T_S, seen(), asked(), 0.7 + 0.0 * T_S, speed(), speed(), 0.0 * T_S, current(),
            current() + 0.01 * _DRAWN[3], 2.0 * current(), 0 * np.arange(ROWS)]),
    "servo_axis",
    {
        "t": "TIME", "command": "CONTROL_POSITION", "position": "POSITION",
        "velocity": "VELOCITY", "effort": "TORQUE",
    },
)  # fmt: skip
MILL = Log(
    "Time [s]," + ",".join(f"{axis}_{what}" for axis in "XY" for what in (
        "ActualPosition", "ActualVelocity", "SetPosition", "SetVelocity", "CurrentFeedback",
        "DCBusVoltage", "OutputCurrent", "OutputVoltage")) + "\n"
    + rows([T_S, *(part for n in range(2) for part in (
        100 * seen(n), 100 * speed(n), 100 * asked(n), 100 * speed(n), current(n),
        0.05 + 0.001 * _DRAWN[4 + n], 327.0 + 0.2 * _DRAWN[n], 10.0 * speed(n)))]),
    "servo_axis",
    {
        "t": "Time [s]", "command": "X_SetPosition", "position": "X_ActualPosition",
        "velocity": "X_ActualVelocity", "effort": "X_CurrentFeedback",
    },
)  # fmt: skip
WRITTEN_TWICE = Log(
    rows([1e3 * T_S, asked(), asked(), seen()], "\t"),
    "servo_axis",
    {"t": "column_1", "command": "column_2", "position": "column_4"},
)
CONTROLLER_OF_AN_ARM = Log(
    rows([T_S + 3696.0, np.round(8e3 * T_S / PERIOD_S + 500 * _DRAWN[0]), *joints(6),
          np.round(1e4 + 300 * _DRAWN[7]), np.round(2e4 + 300 * _DRAWN[8])]),
    "servo_axis", {"t": "column_1", "command": "column_3", "position": "column_9"},
)  # fmt: skip
LOGS = {name: log for name, log in globals().items() if isinstance(log, Log)}
NO_TABLES = {
    "marlin": "X:10.00 Y:0.00 Z:5.00 E:0.00 Count X:800 Y:0 Z:2000\nok\n" * 20,
    "words": "start\nhoming\ndone\n",
}
