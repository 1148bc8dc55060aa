"""What to do about each effect, by the kind of machine: a table in layers.

A machine's own lines stand before those that hold for all. `{part}` is the component in words,
`{size}` the main size without its sign, `{factor}` a scale as it is, `{true}` what the robot file's
own value becomes, `{follows}` what an unknown follows; `{sign:a|b}` is a where the main size is
above nothing and b where it is below.
A key may end in `.small` (below what SMALL says), in the name of the main parameter, or of an
unknown in what it follows (and `.force` where it is one); in `.beside` where friction or play is
found too that may be the cause.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping

from deltactl.models.robot import DeltaRobot, RobotModel, ServoAxis, kind

Table = Mapping[str, str]

SMALL = {"gear_ratio": 0.02}
"""Departures below which no wrong gear and no wrong switch is meant: those are steps."""

EVERYWHERE: Table = {
    "gear_backlash": "take up the play of {part} ({size} at its output): tighten coupling and set"
    " screws; if it stays, replace the gear",
    "joint_friction": "free the bearings of {part} (look for what rubs, clean, grease) if {size} of"
    " friction is more than its maker states; or enter it in the robot file",
    "joint_friction.width": "free the bearings of {part} (look for what rubs, clean, grease):"
    " friction keeps its two directions {size} apart; or enter it in the robot file",
    "viscous_friction": "look at the grease and seals of {part} if {size} of viscous friction is"
    " more than its maker states; or enter it in the robot file",
    "stribeck_friction": "grease {part}: it sticks at low speed",
    "joint_compliance": "look for loose clamps and thin shafts at {part}: it yields under load",
    "home_offset": "correct the home stop or jig of {part}: at home its arm stands {size}"
    " {sign:lower|higher} than it should; or enter the offset in the robot file",
    "gear_ratio": "compare gear and microstep switches of {part} with the robot file: it moves"
    " {size} {sign:further|less far} than commanded",
    "gear_ratio.small": "enter the ratio of {part} in the robot file: it moves {size}"
    " {sign:further|less far} than commanded; that is too little for a wrong gear or"
    " microstep switch",
    "transmission_error": "enter the periodic error of {part}'s gear ({size}) in the robot file,"
    " and jobs compensate it; replace the gear only if that is not enough",
    "encoder_error": "centre the encoder of {part}: it errs by {size} periodically",
    "lost_steps": "home again; then run slower or softer, and look for what held {part} up:"
    " {size} were lost",
    "following_lag": "raise the gains in the control of {part}, or command it earlier: it is late"
    " by {size}",
    "following_lag.dead": "command {part} earlier, or look for what delays it (a bus, a slow cycle,"
    " a filter or ramp of its controller; higher gains shorten no dead time): it is late by {size}",
    "following_lag.beside": "raise the gains in the control of {part}, or command it earlier: it is"
    " late by {size}, which a loop that rings as was found makes by itself",
    "following_lag.effort": "look for what delays the motion of {part}, or its readings, behind the"
    " effort (a filter, a slow bus, two clocks): it comes after the effort by {size}",
    "following_lag.several": "command {part} earlier, or raise the gains in their control (which"
    " shortens no dead time): they are late by {size}",
    "upper_arm_length": "set the upper arm of {part} to {true} in the robot file, or replace it",
    "forearm_length": "set the forearm of {part} to {true} in the robot file, or replace it",
    "base_radius": "measure base and platform: the difference of their radii is {true}",
    "motor_azimuth": "turn {part} on the base, it is {size} off; or enter the angle in the"
    " robot file",
    "frame_tilt": "align the sensors with the robot, or enter their rotation ({size}) in the robot"
    " file",
    "thermal_expansion": "let the arms warm up before exact work: they {sign:grow|shrink} by"
    " {size}",
    "payload": "weigh what the platform carries: it is {size} {sign:more|less} than the robot file"
    " says",
    "contact": "clear away what stops the platform at {size}",
    "resonance": "accelerate more gently, or stiffen the frame: it rings at {size}",
    "sensor_offset": "set {part} to zero ('deltactl sensors --calibrate'): it reads {size}"
    " {sign:too far|short}",
    "sensor_scale": "have {part} calibrated: it reads {size} {sign:too far|short}",
    "sensor_crosstalk": "clean the window of {part}, or move it: its error grows with distance",
    "sensor_latency": "allow for readings that come {size} late, or read them faster",
    "sensor_drift": "let {part} warm up before use: it drifts by {size}",
    "stale_reading": "look at the cable and supply of {part}: it repeats old values",
    "inertia": "enter the true inertia of {part} in the robot file: {size}",
    "effort_offset": "balance {part}, or correct the zero of its effort: the same {size} is there"
    " whichever way it moves, where friction would change sign with the motion",
    "effort_offset.beside": "find out first what of the effort follows the speed, at slow speeds"
    " both ways; balance {part}, or correct the zero of its effort, only by what stays there: the"
    " {size} found are what the speeds of this recording have in common",
    "effort_gain": "set the scale between effort and force of {part}: its effort gives {size}"
    " {sign:more|less} than the robot file says",
    "unknown": "find out what the unknown error at {part} comes with: it follows {follows}; repeat"
    " the motion with that changed, and with all else as it was",
    "unknown.position": "repeat the motion: an unknown error at {part} follows {follows}; where it"
    " comes back at the same places, look there for what is bent, loose or in the way",
    "unknown.speed": "record {part} at several steady speeds, slow to fast, both ways: an unknown"
    " error follows {follows}, and such a recording shows how it depends on it",
    "unknown.direction": "come to the same places from both sides: an unknown error at {part}"
    " follows {follows}; play and friction leave the same difference everywhere, what yields leaves"
    " more under more load",
    "unknown.time": "record again from switching on, with the same motion: an unknown error at"
    " {part} follows {follows}; what comes back is warming up, what does not came loose or moved",
    "unknown.few_periods": "record {part} over at least three periods of the wave that is told at"
    " the finding below, and diagnose that: with fewer no periodic error can be named",
    "unknown.time.pace": "repeat one and the same motion, no faster at its end than at its"
    " beginning: an unknown error at {part} follows {follows}, along which this motion changes its"
    " speed; what does not come back came with the speed",
    "unknown.load": "repeat the motion with another weight: an unknown error at {part} follows"
    " {follows}, and what yields under load grows with the weight",
}
"""A stepper-driven delta, and all that has no line of its own; what is not here nobody can mend."""

OF_SERVO_DRIVES: Table = {
    "gear_ratio": "compare the gear of {part}, and the counts per turn of its encoder, with the"
    " robot file: it moves {size} {sign:further|less far} than commanded",
    "gear_ratio.small": "enter the ratio of {part} in the robot file: it moves {size}"
    " {sign:further|less far} than commanded; that is too little for a wrong gear or"
    " count of the encoder",
}

OF_AN_AXIS: Table = {
    "unknown.position.force": "repeat the motion: an unknown force of {part} follows {follows};"
    " where it comes back at the same places, have the controller add a table of it (--json FILE"
    " writes one), or look there for what rubs or is bent",
    "unknown.effort": "record {part} with another load, and slower: an unknown part of the"
    " mismatch follows {follows}; what the drive adds by itself stays, what the load does changes",
    "unknown.direction.beside": "move {part} to and fro by a little at several places along its"
    " travel, and record that: its friction or play differs from place to place (by about {size}),"
    " and such a recording shows where; look there for a worn gear, a cable that drags, or a"
    " weight",
    "home_offset": "{sign:take|add} {size} {sign:off|to} the commands of {part}, or move its zero"
    " by as much: it stands that far {sign:above|below} what it is told",
    "home_offset.beside": "then look at the zero of {part} again: it stands {size}"
    " {sign:above|below} what it is told, as it may where the zero was set after coming from one"
    " side; {sign:take|add} what stays {sign:off|to} its commands",
    "gear_ratio.small": "divide the commands of {part} by {factor}, or correct the scale in its"
    " drive: it moves {size} {sign:further|less far} than commanded",
    "transmission_error": "have the controller of {part} subtract the periodic error of its gear"
    " ({size}; many can learn it), and replace the gear only if that is not enough",
    "encoder_error": "centre the encoder of {part}, or subtract its periodic error ({size}) from"
    " what it reads",
    "gear_backlash": "take up the play of {part} ({size} at its output) at coupling, set screws and"
    " gear; or come to each place from the same side",
    "sensor_latency": "take {size} off the times of the readings, or read them faster",
}

OF_A_SERVO_AXIS: Table = {
    "gear_backlash": "see first whether the drive of {part} has a dead zone, and narrow it, or"
    " raise its P gain: within a dead zone a servo does not correct, which looks the same as play"
    " ({size}). What stays is play: take it up at horn, coupling, set screws and gear; or come to"
    " each place from the same side",
    "gear_ratio": "divide the commands of {part} by {factor}, or correct the scale by which its"
    " drive or program turns angles into counts: it moves {size} {sign:further|less far} than"
    " commanded",
    "joint_friction.width": "look for what rubs at {part}, raise the gain of its position control,"
    " or come to each place from the same side: its two directions end {size} apart",
    "joint_compliance": "raise the gain of the position control of {part}, or look for what gives"
    " way: it yields under load",
}

OF_A_SLIDE: Table = {
    "gear_ratio": "compare steps per mm (or counts), the lead of the screw, and the teeth and pitch"
    " of belt and pulley of {part} with what is set: it moves {size} {sign:further|less far} than"
    " commanded",
    "gear_ratio.small": "divide the steps per mm (or counts) of {part} by {factor}: it moves {size}"
    " {sign:further|less far} than commanded; a stretched belt and a screw's lead are off by as"
    " little",
    "gear_backlash": "take up the play of {part} ({size}): preload or replace the nut of the screw,"
    " tension the belt, tighten coupling and pulleys; or set it as the backlash of the controller,"
    " or come to each place from the same side",
    "transmission_error": "have the controller of {part} subtract the periodic error of its screw"
    " or belt ({size}); look for a bent screw or a pulley out of centre, and replace that only if"
    " it is not enough",
    "encoder_error": "have the controller of {part} subtract the periodic error of its scale or"
    " encoder ({size}), or align that anew",
    "joint_friction": "free the guides and the screw or belt of {part} (look for what rubs, clean,"
    " grease) if {size} of friction is more than its maker states; or enter it in the"
    " robot file",
    "joint_friction.width": "free the guides of {part} (clean, grease), tension the belt, or come"
    " to each place from the same side; where a servo drives it, raise its gain: its two directions"
    " end {size} apart",
    "viscous_friction": "look at the grease and seals of guides and screw of {part} if {size} of"
    " viscous friction is more than its maker states; or enter it in the robot file",
    "stribeck_friction": "grease the guides and the screw of {part}: it sticks at low speed",
    "joint_compliance": "tension the belt of {part}, look for a loose coupling or screw bearing;"
    " where a servo drives it, raise its gain: it yields under load",
    "following_lag": "command {part} earlier, or look for what delays it (a smoothing filter of its"
    " controller; where a servo drives it, its gains): it is late by {size}",
    "resonance": "accelerate more gently, tension the belt, or stiffen the frame: it rings at"
    " {size}",
}
"""Belts and screws, whatever motor turns them: the file of an axis does not say which."""

OF_A_SENSOR: Table = {
    "unknown": "look at what {part} reads while nothing moves, and with another target: an unknown"
    " error follows {follows}; what changes with the target comes from it or its surroundings",
    "unknown.time": "record {part} from switching on, before a target that stands still: an"
    " unknown error follows {follows}; what comes back each time is warming up",
    "sensor_offset": "{sign:take|add} {size} {sign:off|to} what {part} reads: it reads that much"
    " {sign:too far|short} at every distance",
    "sensor_scale": "divide what {part} reads by {factor} (after taking off a constant error, if"
    " there is one): it reads {size} {sign:too far|short}",
    "sensor_crosstalk": "look for what {part} sees beside its target (a dirty window, reflections):"
    " its error grows with the distance squared",
    "sensor_latency": "take {size} off the times of the readings, or read them faster",
}

ADVICE: dict[str, Table] = {
    "delta": EVERYWHERE,
    "servo_delta": ChainMap(dict(OF_SERVO_DRIVES), dict(EVERYWHERE)),
    "stepper_axis": ChainMap(dict(OF_AN_AXIS), dict(EVERYWHERE)),
    "servo_axis": ChainMap(
        dict(OF_A_SERVO_AXIS), dict(OF_AN_AXIS), dict(OF_SERVO_DRIVES), dict(EVERYWHERE)
    ),
    "slide": ChainMap(
        dict(OF_A_SLIDE),
        dict(OF_AN_AXIS),
        dict(OF_SERVO_DRIVES),
        dict(EVERYWHERE),
    ),
    "range_sensor": ChainMap(dict(OF_A_SENSOR), dict(EVERYWHERE)),
}
"""By machine and drive, the nearest table first."""


def machine_of(robot: RobotModel | None, component: str, effect: str) -> str:
    """The key of ADVICE for a robot; without one by what the finding is at."""
    if isinstance(robot, DeltaRobot):
        return (
            "servo_delta" if robot.drive is not None and kind(robot.drive) == "servo" else "delta"
        )
    if isinstance(robot, ServoAxis) and robot.motion == "linear":
        return "slide"
    if robot is not None:
        return robot.kind
    if component != "axis":
        return "delta"
    return "range_sensor" if effect.startswith("sensor_") else "servo_axis"


def advice(machine: str, effect: str, parameter: str, departure: float) -> str | None:
    """The line of a machine for an effect of which the main parameter is so far from nothing."""
    small = abs(departure) < SMALL.get(effect, 0.0)
    names = [f"{effect}.{parameter}", effect]
    if small:
        names.insert(0, f"{effect}.small")
    return next((ADVICE[machine][name] for name in names if name in ADVICE[machine]), None)
