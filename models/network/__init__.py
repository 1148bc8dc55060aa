"""TFLite networks that map a target to arm angles: the file, its metadata, and running it.

Needs numpy and a TFLite runtime only; writing and training files is `models.training`.
"""

from models.network.domain import Box, Cylinder, Domain
from models.network.file import NetworkFile
from models.network.inverse import InverseNetwork
from models.network.metadata import NetworkMetadata, fingerprint

__all__ = [
    "Box",
    "Cylinder",
    "Domain",
    "InverseNetwork",
    "NetworkFile",
    "NetworkMetadata",
    "fingerprint",
]
