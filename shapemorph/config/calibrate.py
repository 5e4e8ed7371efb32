"""The YAML file of a calibration."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.report import ReportConfig
from shapemorph.config.section import Section

Name = Annotated[str, Field(min_length=1)]


class CalibrateConfig(Section):
    """Section `calibrate`: what is sought."""

    radial: Literal[0, 1, 2, 3] = Field(
        3, description="radial distortion: how many of k1, k2, k3 are sought"
    )
    tangential: bool = Field(False, description="tangential distortion p1, p2 is sought")
    skew: bool = Field(False, description="the angle between rows and columns is sought")
    before: Path | None = Field(
        None, description="calibration.json of an earlier calibration: has the rig moved since?"
    )


class TargetConfig(Section):
    """One entry of `targets`."""

    kind: Literal["chessboard", "charuco", "dots", "asymmetric_dots", "points"] = Field(
        description="points: dots in space whose coordinates stand in a file"
    )
    columns: int | None = Field(
        None,
        ge=2,
        description="chessboard: inner corners along a row; charuco: squares; dots: dots (of "
        "asymmetric_dots those of one row)",
    )
    rows: int | None = Field(None, ge=2, description="the same across; asymmetric_dots: all rows")
    spacing: float | None = Field(
        None,
        gt=0,
        description="mm from corner to corner or from dot to dot; asymmetric_dots: from row to row",
    )
    marker: float | None = Field(None, gt=0, description="charuco: side of a marker, mm")
    dictionary: str = Field("DICT_4X4_50", description="charuco: OpenCV's name of its markers")
    dot_diameter: float = Field(
        0.0, ge=0, description="dots, points: mm; corrects where tilted dots have their middle"
    )
    dot_shape: Literal["round", "square"] = Field("round", description="points: of the dots")
    dark: bool = Field(True, description="dots, points: darker than what surrounds them")
    least_px: float | None = Field(
        None,
        gt=0,
        description="points: diameter of the smallest dot in the pictures, px; smaller spots "
        "are no dots, such as the speckle of a part beside them",
    )
    points: Path | None = Field(
        None,
        description="points: CSV row,column,x_mm,y_mm,z_mm of a target in space, its dots in rows "
        "and columns; nx,ny,nz too if its surface does not bulge outward",
    )

    @model_validator(mode="after")
    def _is_described(self) -> Self:
        if self.kind == "points":
            if self.points is None:
                raise ValueError("kind points needs the path of a CSV: give points")
            return self
        missing = [name for name in ("columns", "rows", "spacing") if getattr(self, name) is None]
        if missing:
            raise ValueError(f"kind {self.kind} needs {', '.join(missing)}")
        if self.kind == "charuco" and self.marker is None:
            raise ValueError("kind charuco needs marker, the side of a marker in mm")
        return self


Anchor = tuple[int, int, float, float]


class ViewsConfig(Section):
    """One entry of `views`: pictures of one target."""

    target: Name = Field(description="name of the target")
    pictures: dict[Name, Name] = Field(
        min_length=1,
        description="for each camera a file, or a pattern whose star is the name of the view",
    )
    simultaneous: bool = Field(
        True, description="pictures of one name show the target in one place"
    )
    anchors: dict[Name, list[Anchor]] = Field(
        {},
        description="for each camera some [row, column, x, y]: which dot is seen where, roughly",
    )


class RigConfig(Section):
    """The YAML file of a calibration."""

    version: Literal[1] = Field(1, description="of this file format")
    cameras: list[Name] = Field(min_length=1, description="names; the first is the world")
    targets: dict[Name, TargetConfig] = Field(min_length=1, description="by name")
    views: list[ViewsConfig] = Field(min_length=1, description="what was photographed")
    calibrate: CalibrateConfig = CalibrateConfig()
    report: ReportConfig = ReportConfig()

    @model_validator(mode="after")
    def _names_are_known(self) -> Self:
        if len(set(self.cameras)) < len(self.cameras):
            raise ValueError(f"cameras need different names, got {', '.join(self.cameras)}")
        for views in self.views:
            if views.target not in self.targets:
                raise ValueError(
                    f"views name target {views.target!r}, expected one of {', '.join(self.targets)}"
                )
            for camera in [*views.pictures, *views.anchors]:
                if camera not in self.cameras:
                    raise ValueError(
                        f"views name camera {camera!r}, expected one of {', '.join(self.cameras)}"
                    )
        return self
