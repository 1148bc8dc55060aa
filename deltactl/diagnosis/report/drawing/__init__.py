"""A drawing of the machine with the culprits marked."""

from deltactl.diagnosis.report.drawing.machine import machine_drawing

__all__ = ["machine_drawing"]
