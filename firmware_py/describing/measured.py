"""What a recording tells of a machine before it is described: gear, motion, zero."""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.describing.questions import MICROSTEPS, Answers, numbers
from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.flat import FlatRecording


def measured(kind: str, recording: FlatRecording, known: Answers) -> tuple[Answers, list[str]]:
    """Answers that the recording gives, and a line on each. Raises RecordingError without any.

    stepper_axis: the gear ratio, from steps and angle. servo_axis: whether zeros agree.
    """
    if kind == "stepper_axis" and recording.has("steps_1", "theta_1"):
        return _gear(recording, known)
    if recording.has("command", "position"):
        return _zero(recording)
    raise RecordingError(
        f"{recording.source}: nothing of a {kind} can be measured from it; leave --measure out"
    )


def _gear(recording: FlatRecording, known: Answers) -> tuple[Answers, list[str]]:
    steps, theta = recording.column("steps_1"), recording.column("theta_1")
    both = np.isfinite(steps) & np.isfinite(theta)
    rad_per_step = float(np.polyfit(steps[both], theta[both], 1)[0])
    (microsteps,) = numbers({MICROSTEPS.key: "1600"} | known, MICROSTEPS.key)
    gear = 2.0 * np.pi / (abs(rad_per_step) * microsteps)
    said = (
        f"gear_ratio {gear:.6g}: {abs(rad_per_step):.4g} rad a step, measured; a diagnosis of this "
        "recording cannot find it wrong any more, so give the gear's own ratio where it is known"
    )
    return {"gear_ratio": f"{gear:.6g}", "microsteps_per_rev": f"{microsteps:g}"}, [said]


def _zero(recording: FlatRecording) -> tuple[Answers, list[str]]:
    command, position = recording.column("command"), recording.column("position")
    apart = float(np.nanmedian(position - command))
    width = float(np.nanmax(command) - np.nanmin(command))
    zero = "absolute" if abs(apart) < 0.25 * width else "arbitrary"
    return {"zero": zero}, [f"zero: {zero} (readings stand {apart:.3g} from the commands)"]
