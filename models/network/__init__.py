"""TFLite networks that map a target to arm angles: the file, its metadata, and running it.

Needs numpy and a TFLite runtime only; writing and training files is `deltactl.models.training`.
"""

from deltactl.models.network.file import NetworkFile
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.network.metadata import Box, Cylinder, Domain, NetworkMetadata, fingerprint

__all__ = [
    "Box",
    "Cylinder",
    "Domain",
    "InverseNetwork",
    "NetworkFile",
    "NetworkMetadata",
    "fingerprint",
]
