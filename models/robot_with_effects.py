"""A robot file of any kind, with the effects that it states held to what there is."""

from __future__ import annotations

from pathlib import Path

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document
from deltactl.models.chain.stated import forms_of, wrong_effects, wrong_values
from deltactl.models.robot import RobotModel, kind_in, model_sections


def load_with_effects(path: Path) -> RobotModel:
    """Read a robot file as `load_robot_model` does, and refuse effects that there are not.

    Raises MissingFile or ConfigError, a line for each mistake.
    """
    document = Document.read(path)
    kind, data = kind_in(document), model_sections(document)
    try:
        robot = document.check(kind, data)
    except ConfigError as error:
        forms = forms_of(str(data["kind"]), data.get("motion"))
        also = wrong_values(("effects",), data.get("effects"), forms)
        raise ConfigError(*error.args, *document.fail_all(also).args) from None
    if mistakes := list(wrong_effects(robot)):
        raise document.fail_all(mistakes)
    return robot
