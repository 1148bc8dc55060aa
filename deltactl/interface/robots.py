"""Robots as a notebook has them: read from robot files, written back, and their kinematics."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from deltactl.firmware_py.named_files import ROBOT_KEY, find
from deltactl.foundation.errors import ConfigError, UnreachablePoint
from deltactl.foundation.plain_file import said_of_output, write_whole
from deltactl.foundation.strict_yaml import Document
from deltactl.interface import older
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray, RobotModel
from deltactl.models.robot_files import with_effects_in

if TYPE_CHECKING:
    from deltactl.interface.recordings import AnyPath


@dataclass(frozen=True, eq=False)
class Robot:
    """A machine as its robot file describes it.

    Attributes
    ----------
    model : RobotModel
        The file's sections: `model.geometry`, `model.drive`, `model.effects`, ...
    document : Document
        The file's text and name.

    Examples
    --------
    >>> import deltactl as dc
    >>> robot = dc.Robot.load("zhao-2023.yaml")
    >>> robot
    Robot('zhao-2023': delta, no known effects)
    >>> robot.model.geometry.forearm_m
    0.5
    """

    model: RobotModel
    document: Document

    @classmethod
    def load(cls, path: AnyPath) -> Robot:
        """Read a robot file of any kind.

        Parameters
        ----------
        path : path
            The file; a plain name is also looked for among the files of the package.

        Raises
        ------
        MissingFile, ConfigError
            A line for each mistake, with file, line and the nearest valid key.
        """
        return cls._of(Document.read(find(str(path), key=ROBOT_KEY)))

    @classmethod
    def from_text(cls, text: str, name: str = "robot.yaml") -> Robot:
        """Read the text of a robot file.

        Parameters
        ----------
        text : str
            YAML, as a robot file has it.
        name : str, optional
            What messages call it; files that the text names are sought beside it.

        Raises
        ------
        ConfigError
            A line for each mistake.

        Examples
        --------
        >>> import deltactl as dc
        >>> dc.Robot.from_text("{kind: servo_axis, name: slide, motion: linear}")
        Robot('slide': servo_axis, no known effects)
        """
        return cls._of(Document(Path(name), text))

    @classmethod
    def _of(cls, document: Document) -> Robot:
        return cls(with_effects_in(document), document)

    @property
    def name(self) -> str:
        """What reports call it."""
        return self.model.name

    @property
    def path(self) -> Path:
        """The file it was read from, or would be written to."""
        return self.document.path

    @property
    def text(self) -> str:
        """The text of its file."""
        return self.document.text

    def save(self, path: AnyPath, replace: bool = False) -> None:
        """Write the robot file; `replace`: over one that is there.

        Raises RecordingError when it exists or cannot be written.
        """
        with said_of_output(Path(path), fresh=True):
            write_whole(Path(path), self.text, fresh=not replace)

    def __repr__(self) -> str:
        known = ", ".join(f"{entry.effect} {entry.component}" for entry in self.model.effects)
        has = f"known effects: {known}" if known else "no known effects"
        return f"Robot({self.name!r}: {self.model.kind}, {has})"

    def _repr_html_(self) -> str:
        lines = html.escape(self.text)
        return f"<p>{html.escape(repr(self))}</p><details><pre>{lines}</pre></details>"


def load_robot(robot: AnyPath) -> RobotModel:
    """Use `Robot.load(...).model`; this name goes."""
    older("load_robot")
    return Robot.load(robot).model


def robot_of(robot: AnyPath | Robot) -> Robot:
    """A robot, or the file of one. Raises MissingFile or ConfigError."""
    if isinstance(robot, Robot):
        return robot
    if isinstance(robot, str | Path):
        return Robot.load(robot)
    what = type(robot).__name__
    raise ConfigError(f"robot: {what} is no robot; give a path or what Robot.load returns")


class Kinematics:
    """Positions to arm angles and back, of a delta; made by `deltactl.kinematics`.

    The frame: origin in the middle of the base at the height of the motor axes, z up, x towards
    motor 1. An arm angle is 0 when the upper arm is level, and grows downwards.
    """

    def __init__(self, robot: DeltaRobot):
        from deltactl.models.calibrated_inverse import CalibratedInverse

        self._closed_form = CalibratedInverse(robot)

    def inverse(self, xyz: ArrayLike, strict: bool = True) -> FloatArray:
        """Commanded arm angles of platform positions.

        Parameters
        ----------
        xyz : array_like, shape (n, 3) or (3,)
            Positions of the platform's middle [m].
        strict : bool, optional
            Raise for a position out of reach; otherwise its row is NaN.

        Returns
        -------
        ndarray, shape of `xyz`
            Angles [rad].

        Raises
        ------
        UnreachablePoint
            The first position that the linkage cannot reach, and its row.
        ValueError
            The last dimension is not 3.
        """
        position_m = _rows(xyz, "xyz")
        angles_rad = self._closed_form.angles_rad_at_once(position_m)
        return self._checked(angles_rad, position_m, "m", strict).reshape(np.shape(xyz))

    def forward(self, angles: ArrayLike, strict: bool = True) -> FloatArray:
        """Platform positions of commanded arm angles.

        Parameters
        ----------
        angles : array_like, shape (n, 3) or (3,)
            Arm angles [rad].
        strict : bool, optional
            Raise for angles at which the linkage cannot be assembled; otherwise their row is NaN.

        Returns
        -------
        ndarray, shape of `angles`
            Positions of the platform's middle [m].

        Raises
        ------
        UnreachablePoint
            The first angles that the linkage cannot have, and their row.
        ValueError
            The last dimension is not 3.
        """
        angles_rad = _rows(angles, "angles")
        position_m = self._closed_form.position_m(angles_rad)
        return self._checked(position_m, angles_rad, "rad", strict).reshape(np.shape(angles))

    @staticmethod
    def _checked(found: FloatArray, given: FloatArray, unit: str, strict: bool) -> FloatArray:
        lost = np.flatnonzero(~np.isfinite(found).all(axis=1))
        if strict and len(lost):
            values = ", ".join(f"{value:.6g}" for value in given[lost[0]])
            more = f", nor can {len(lost) - 1} more rows" if len(lost) > 1 else ""
            raise UnreachablePoint(
                f"row {lost[0]}: ({values}) {unit} cannot be reached by the linkage{more};"
                " strict=False gives NaN for such rows"
            )
        return found


def kinematics(robot: AnyPath | Robot) -> Kinematics:
    """Both kinematics of a delta, vectorised.

    Lengths, directions and angles that the robot file's `effects` correct are taken into account,
    as a run of the robot does; effects that remember (play, friction) are not.

    Parameters
    ----------
    robot : Robot or path
        A delta.

    Raises
    ------
    ConfigError
        The robot is no delta.

    Examples
    --------
    >>> import deltactl as dc
    >>> delta = dc.kinematics("zhao-2023.yaml")
    >>> angles = delta.inverse([[0.03, 0.01, -0.45], [0.05, 0.02, -0.40]])
    >>> angles.shape
    (2, 3)
    >>> delta.forward(angles).round(6)
    array([[ 0.03,  0.01, -0.45],
           [ 0.05,  0.02, -0.4 ]])
    """
    one = robot_of(robot)
    if not isinstance(one.model, DeltaRobot):
        raise ConfigError(f"{one.path}: is a {one.model.kind}; kinematics needs a delta")
    return Kinematics(one.model)


def _rows(values: Any, name: str) -> FloatArray:
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape[-1:] != (ARMS,):
        raise ValueError(f"{name} must have shape (n, 3) or (3,), got {rows.shape}")
    return rows.reshape(-1, ARMS)
