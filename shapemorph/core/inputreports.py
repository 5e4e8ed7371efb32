"""What is known of the two meshes before anything is measured."""

from dataclasses import dataclass

from shapemorph.core.meshreport import MeshReport


@dataclass(frozen=True, slots=True)
class InputReports:
    """What was found in both files.

    Attributes
    ----------
    reference, deformed : MeshReport
    reference_size, deformed_size : float
        Diagonals of the bounding boxes, mm.
    channel, channel_reason : str
        What of the colours of both became grey, and why.
    """

    reference: MeshReport
    deformed: MeshReport
    reference_size: float
    deformed_size: float
    channel: str
    channel_reason: str
