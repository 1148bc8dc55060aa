"""The columns of a chain of joints in a table: one of each joint, and places that were measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.recording.tables.flat import TARGET, AnyArray, FlatRecording

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
ROTATION = ("rotvec_x", "rotvec_y", "rotvec_z")
IN_MM = "_mm"


def columns_of(joints: Sequence[str], stem: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The column of each joint, and the names that a table may have for it: by its place among the
    joints, by the joint's name; an angle also by the joint's name alone.
    """
    for number, joint in enumerate(joints, 1):
        bare = (joint,) if stem == "theta" else ()
        yield f"{stem}_{number}", (f"{stem}_{number}", f"{stem}_{joint}", f"{joint}_{stem}", *bare)


def joint_columns(joints: Sequence[str], recording: FlatRecording, stem: str) -> list[str | None]:
    """What the column of each joint is called in a table; None where it has none."""
    table = {**recording.extra, **recording.columns}
    each = (others for _, others in columns_of(joints, stem))
    return [next((name for name in others if _numbers(table.get(name))), None) for others in each]


def by_joint(
    joints: Sequence[str], recording: FlatRecording, stems: Sequence[str]
) -> FlatRecording:
    """A recording with the columns of the joints under one name each."""
    table = {**recording.extra, **recording.columns}
    own = {
        f"{stem}_{number}": np.asarray(table[name], dtype=float)
        for stem in stems
        for number, name in enumerate(joint_columns(joints, recording, stem), 1)
        if name is not None
    }
    return replace(recording, columns={**recording.columns, **own})


def counted(
    joints: Sequence[str], recording: FlatRecording, rad_per_count: Sequence[float | None],
    zeros: Sequence[int],
) -> dict[str, tuple[float, int]]:  # fmt: skip
    """Columns that are counts, what one turns the joint by [rad], and the count at zero: those of
    joints that have a drive, but for columns whose unit somebody gave.
    """
    return {
        name: (rad, 0 if stem == "velocity" else zero)
        for stem in ("theta", "command", "velocity")
        for name, rad, zero in zip(
            joint_columns(joints, recording, stem), rad_per_count, zeros, strict=True
        )
        if name is not None and rad is not None and name not in recording.units_given
    }


def in_angles(
    recording: FlatRecording, columns_of_counts: Mapping[str, tuple[float, int]]
) -> FlatRecording:
    """A recording with these columns of counts as angles [rad], see `counted`."""
    table = {**recording.extra, **recording.columns}
    turned = {n: rad * (table[n] - zero) for n, (rad, zero) in columns_of_counts.items()}
    extra = {name: turned.get(name, values) for name, values in recording.extra.items()}
    columns = {name: turned.get(name, values) for name, values in recording.columns.items()}
    return replace(recording, columns=columns, extra=extra)


def _numbers(values: object) -> bool:
    return isinstance(values, np.ndarray) and values.dtype.kind in "fiu" and len(values) > 0


def targets_in(recording: FlatRecording) -> tuple[str, ...]:
    """Stems of the columns of places: pos, pos1, pos2."""
    names = [*recording.columns, *recording.extra]
    found = {match[1] for name in names if (match := TARGET.fullmatch(name))}
    return tuple(sorted(found, key=lambda stem: (len(stem), stem)))


def place_of(recording: FlatRecording, stem: str) -> FloatArray | None:
    """Where a target was, (n, 3) [m]; None where a column is missing."""
    return block(recording, [f"{stem}_{axis}" for axis in "xyz"])


def measures_poses(joints: Sequence[str], recording: FlatRecording) -> bool:
    """Whether a table has places, and no efforts in motion, which say more of it."""
    efforts = all(joint_columns(joints, recording, "effort"))
    at_rest = not recording.timed or len(recording.stretches()) == len(recording)
    return bool(targets_in(recording)) and (at_rest or not efforts)


def block(recording: FlatRecording, names: Sequence[str]) -> FloatArray | None:
    """Columns (n, k) in SI units; None where one is missing."""
    table = {**recording.extra, **recording.columns}
    found = [_column(table, name) for name in names]
    known = [one for one in found if one is not None]
    return np.stack(known, axis=1) if len(known) == len(names) else None


def _column(table: dict[str, AnyArray], name: str) -> FloatArray | None:
    for called, factor in ((name, 1.0), (f"{name}{IN_MM}", 1e-3)):
        values = table.get(called)
        if values is not None and values.dtype.kind in "fiu":
            return factor * np.asarray(values, dtype=float)
    return None


def joints_of(joints: Sequence[str], recording: FlatRecording, stem: str) -> FloatArray | None:
    """Angles or commands of all joints, (n, joints)."""
    names = joint_columns(joints, recording, stem)
    known = [name for name in names if name is not None]
    return block(recording, known) if len(known) == len(names) else None


def orientation(recording: FlatRecording) -> FloatArray | None:
    """Rotation vectors (n, 3) [rad], NaN where none was measured; None without such columns."""
    quaternion, vector = block(recording, QUATERNION), block(recording, ROTATION)
    if quaternion is not None:
        size = np.linalg.norm(quaternion, axis=1)
        known = np.isfinite(size) & (size > 0.0)
        vector = np.full((len(size), 3), np.nan)
        vector[known] = Rotation.from_quat(quaternion[known]).as_rotvec()
    return vector
