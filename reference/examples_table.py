"""Examples of the keys that no file in `config/` has, by model and key."""

from __future__ import annotations

from typing import Any

_PLAY = {"effect": "gear_backlash", "component": "motor2", "parameters": {"width": 0.004}}
_CURVE = {"shape": "circle", "centre_m": [0, 0, -0.45], "radius_m": 0.1}
_TOGETHER = {"mode": "together", "t_pwm_s": 0.006}
_GEOMETRY = {"kind": "geometry"}
_FOUND = {"recordings": ["circle.mcap"], "on": "2026-01-31", "ci95": {"width": [0.0037, 0.0043]}}

EXAMPLES: dict[str, Any] = {
    # robots
    "Geometry.home_offset_deg": [0.0, -0.4, 0.0],
    "DeltaRobot.effects": [_PLAY],
    "DeltaRobot.calibrated_from": "0f3a91c2d4e5b678",
    "DeltaRobot.calibrated_on": "zhao-2023, collected 2026-01-31",
    "RobotFile.recordings": {"max_gib": 8},
    "RobotFile.networks": {"zhao-2023.tflite": "my-delta.tflite"},
    "EffectEntry.effect": "gear_backlash",
    "EffectEntry.component": "motor2",
    "EffectEntry.parameters": {"width": 0.004},
    "EffectEntry.found": _FOUND,
    "FoundBy.recordings": ["circle.mcap"],
    "FoundBy.on": "2026-01-31",
    "FoundBy.ci95": {"width": [0.0037, 0.0043]},
    "FoundBy.probability": 0.98,
    "ServoDrive.overload_s": 0.5,
    "ServoDrive.setpoint_deg": 0.001,
    "ServoDrive.record_rate_hz": 500,
    "StepSettings.inverted": [False, True, False],
    "StepSettings.enable_active_high": True,
    "StepSettings.alarm_active_high": False,
    "StepSettings.minimum_gap_fraction": 0.9,
    "StepSettings.heartbeat_s": 0.25,
    "StepSettings.chip": 0,
    "InputSettings.estop_active_high": True,
    "NamedInput.active_high": False,
    "SwitchedPin.active_high": True,
    "RangingSettings.addresses": [0x30, 0x31, 0x32],
    "RangingSettings.offsets_mm": [-3.2, 0.5, 12.0],
    "RangingSettings.minimum_signal_mcps": 0.5,
    "RangingSettings.maximum_sigma_mm": 30,
    "RangingSettings.maximum_jump_mm": 100,
    "RangingSettings.maximum_age_s": 0.2,
    "RangingSettings.retries": 3,
    "RangingSettings.io_2v8": True,
    "Limits.box_m": [[-0.2, 0.2], [-0.2, 0.2], [-0.6, -0.3]],
    "Limits.network_deg": 10,
    "Homing.switch_pins": [7, 8, 9],
    "Homing.switch_active_high": False,
    "Homing.speed_radps": 0.1,
    "Homing.warning_m": 0.01,
    "KeptRecordings.max_gib": 8,
    "KeptRecordings.max_age_days": 90,
    "KeptRecordings.keep_free_gib": 1,
    "AsBuilt.effects": [_PLAY],
    "AsBuilt.noise": {"sigma_m": 0.0005},
    "AsBuilt.servo": {"payload_kg": 0.005},
    "SensorNoise.sigma_m": 0.0005,
    "SensorNoise.correlation": 0.6,
    "SensorNoise.seed": 3,
    "AsBuiltServo.coulomb_scale": [1.0, 1.5, 1.0],
    "AsBuiltServo.viscous_scale": [1.0, 1.5, 1.0],
    "AsBuiltServo.torque_constant_scale": [1.0, 0.95, 1.0],
    "AsBuiltServo.rotor_inertia_scale": 1.1,
    "AsBuiltServo.mass_scale": 1.2,
    "AsBuiltServo.payload_kg": 0.005,
    "AsBuiltServo.faults": [{"kind": "encoder_lost", "joint": 2, "at_s": 5}],
    "FaultAt.kind": "encoder_lost",
    "FaultAt.joint": 2,
    "FaultAt.at_s": 5,
    "FaultAt.lasts_s": 0.2,
    "StepperAxis.effects": [
        {"effect": "gear_backlash", "component": "axis", "parameters": {"width": 0.004}}
    ],
    "ServoAxis.drive_stiffness": 250000,
    "ServoAxis.effects": [
        {"effect": "home_offset", "component": "axis", "parameters": {"offset": 0.001}}
    ],
    "AxisGravity.torque_nm": 1.5,
    "AxisGravity.zero_rad": 0.35,
    "RangeSensor.effects": [
        {"effect": "sensor_offset", "component": "axis", "parameters": {"offset": -0.004}}
    ],
    # jobs
    "JobFile.record": "first-circle.mcap",
    "JobFile.on_step_loss": "warn",
    "JobFile.feedback": {"least_m": 0.002},
    "JobFile.on_blind": "warn",
    "Points.shape": "points",
    "Points.points_m": [[0.05, 0, -0.45], [-0.05, 0, -0.45]],
    "Points.dwell_s": 0.5,
    "Points.spacing_m": 0.0005,
    "Way.spacing_m": 0.0005,
    "WayLeg.dwell_s": 0.5,
    "WayLeg.clockwise": True,
    "WayLeg.spline": True,
    "Joints.shape": "joints",
    "Joints.angles_deg": [[30, 30, 30], [40, 20, 30]],
    "Joints.dwell_s": 0.5,
    "PathStep.timing": _TOGETHER,
    "Accelerated.duration_s": 4,
    "Accelerated.joint_speed_radps": 2,
    "Accelerated.joint_acceleration_radps2": 10,
    "Awaited.is_on": False,
    "JobStep.job": {
        "name": "circle", "path": _CURVE, "timing": _TOGETHER, "inverse_kinematics": _GEOMETRY
    },
    "InnerJob.name": "circle",
    "InnerJob.path": _CURVE,
    "InnerJob.steps": [{"set": {"gripper": True}}, {"wait_s": 0.2}],
    "InnerJob.timing": _TOGETHER,
    "InnerJob.inverse_kinematics": _GEOMETRY,
    "InnerJob.repeats": 3,
    "CalibratedIk.kind": "calibrated",
    "FeedbackSettings.least_m": 0.002,
    "FeedbackSettings.most_m": 0.02,
    "FeedbackSettings.steps_hz": 50,
    # mappings
    "Mapping.columns": {"t": {"from": "time", "unit": "ms"}},
    "Mapping.rate_hz": 100,
    "Mapping.skip_lines": 3,
    "Mapping.heading": ["time", "angle", "target"],
    "Mapping.separator": ";",
    "Mapping.decimal": ",",
    "Source.from": "angle",
    "Source.scale": 0.5,
    "Source.offset": -0.02,
    "Source.unit": "deg",
    "Source.value": 0.2,
}  # fmt: skip
"""Values as a file has them; those of a base stand for the models that are built on it."""
