"""Section `report`: pictures and the page."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from shapemorph.config.section import Section

Words = Annotated[str, Field(min_length=1, max_length=300, coerce_numbers_to_str=True)]


class EquipmentConfig(Section):
    """What only the user knows, for the tables of the report.

    It stands there as it is given, with its unit.
    """

    camera: Words | None = Field(None, description="make and model of the cameras or the scanner")
    resolution: Words | None = Field(None, description="of its pictures, as 2448 x 2048 px")
    lens: Words | None = Field(None, description="make, model and focal length, as 35 mm")
    aperture: Words | None = Field(None, description="as f/8")
    filters: Words | None = Field(None, description="as polarisers, blue band pass")
    lighting: Words | None = Field(None, description="lamps, their colour and place")
    field_of_view: Words | None = Field(None, description="as 120 x 100 mm")
    stereo_angle: Words | None = Field(None, description="between the cameras, as 20 degrees")
    stand_off: Words | None = Field(None, description="distance to the specimen, as 400 mm")
    frame_rate: Words | None = Field(None, description="pictures per second, as 5 Hz")
    exposure: Words | None = Field(None, description="time of a picture, as 10 ms")
    pattern: Words | None = Field(None, description="how the pattern was made, as sprayed")
    pattern_materials: Words | None = Field(None, description="paint of ground and speckle")
    calibration_target: Words | None = Field(None, description="its kind and size")
    calibration_score: Words | None = Field(None, description="residual, as 0.04 px rms")


class ReportConfig(Section):
    """Section `report`: pictures and the page."""

    figures: bool = Field(True, description="write figures/*.png and show them in report.html")
    animation: bool = Field(
        False,
        description="write animation.gif and .mp4: the shape on its way, coloured by strain",
    )
    title: Words | None = Field(None, description="heading of the page; empty: a general one")
    theme: Literal["light", "print"] = Field(
        "light", description="of figures and page; print: twice the pixels, black on white"
    )
    equipment: EquipmentConfig = Field(
        EquipmentConfig(), description="what only the user knows, for the tables of the report"
    )
    noise: Path | None = Field(
        None, description="noise.json of `shapemorph noise`, for the noise floor in the tables"
    )
