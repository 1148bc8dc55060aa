"""What a job allows its feedback to do."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from deltactl.foundation.strict_yaml import RuledModel, rule


class FeedbackSettings(RuledModel):
    """Correct errors that came since the job began: lost steps, a slipping belt, a bent arm."""

    least_m: Annotated[
        float, Field(ge=0.0002, le=0.1, description="metres; less is below what sensors can tell")
    ] = 0.0015
    """Smallest error of an elbow's position that is corrected."""
    most_m: Annotated[
        float, Field(gt=0.0, le=0.1, description="metres; more is a case for homing, not feedback")
    ] = 0.02
    """No elbow is ever moved further from its planned position than this."""
    steps_hz: Annotated[
        float, Field(gt=0.0, le=100.0, description="extra steps a second and motor; gently")
    ] = 50.0

    @rule("least_m", "most_m")
    def _ordered(self) -> None:
        if self.least_m >= self.most_m:
            raise ValueError("least_m must be smaller than most_m, or nothing is ever corrected")
