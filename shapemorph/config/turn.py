"""The YAML file of a reconstruction from many views."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from shapemorph.config.correlate import CorrelateConfig
from shapemorph.config.match import MatchConfig
from shapemorph.config.morph import MorphConfig
from shapemorph.config.reconstruct import ReconstructConfig
from shapemorph.config.report import ReportConfig
from shapemorph.config.section import Section


class TurnConfig(Section):
    """A part that was photographed from all sides, in poses that a calibration knows."""

    version: Literal[1] = Field(1, description="of this file format")
    calibration: Path = Field(
        description="calibration.json whose views are the poses of a target that turned with the "
        "part"
    )
    target: str = Field(description="name of that target")
    pictures: dict[str, str] = Field(
        min_length=1,
        description="for each camera a pattern of the pictures of the part; the star is the name "
        "of the view",
    )
    masks: dict[str, str] = Field(
        {}, description="for each camera a mask, or a pattern of them, white = the part"
    )
    angle: float = Field(20.0, gt=1, lt=60, description="between the views of a pair, degrees")
    patches: int | None = Field(
        None,
        ge=1,
        description="pairs that are matched, evenly around; their pictures are read; empty: all",
    )
    px_per_mm: float | None = Field(
        None, gt=0, description="of the texture; empty: that of the pictures"
    )
    match: MatchConfig = MatchConfig()
    morph: MorphConfig = MorphConfig()
    correlate: CorrelateConfig = CorrelateConfig()
    reconstruct: ReconstructConfig = ReconstructConfig()
    report: ReportConfig = ReportConfig()
