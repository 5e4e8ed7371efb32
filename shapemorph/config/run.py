"""The YAML file of a whole run."""

from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.assess import AssessConfig
from shapemorph.config.correlate import CorrelateConfig
from shapemorph.config.flatten import FlattenConfig
from shapemorph.config.forming import FormingConfig
from shapemorph.config.inputs import InputsConfig
from shapemorph.config.match import MatchConfig
from shapemorph.config.morph import MorphConfig
from shapemorph.config.reconstruct import ReconstructConfig
from shapemorph.config.report import ReportConfig
from shapemorph.config.section import Section
from shapemorph.config.spread import SpreadConfig
from shapemorph.config.surface import AlignConfig, LiftConfig, StrainConfig


class TrackConfig(Section):
    """Section `track`: how points are followed from the first state to the last."""

    method: Literal["shape_morphing", "image_morphing", "incremental"] = Field(
        "shape_morphing",
        description="shape_morphing: two textured shapes, laid flat; of the pictures of two "
        "cameras: image_morphing: over synthetic pictures between two that differ too much; "
        "incremental: from state to state",
    )
    temporal: bool = Field(
        False, description="pictures of two cameras: strain of every state, one mesh over time"
    )


class RunConfig(Section):
    """A whole run."""

    version: Literal[1] = Field(1, description="of this file format")
    inputs: InputsConfig = InputsConfig()
    track: TrackConfig = TrackConfig()
    flatten: FlattenConfig = FlattenConfig()
    match: MatchConfig = MatchConfig()
    morph: MorphConfig = MorphConfig()
    correlate: CorrelateConfig = CorrelateConfig()
    lift: LiftConfig = LiftConfig()
    spread: SpreadConfig = SpreadConfig()
    align: AlignConfig = AlignConfig()
    strain: StrainConfig = StrainConfig()
    forming: FormingConfig = FormingConfig()
    reconstruct: ReconstructConfig = ReconstructConfig()
    report: ReportConfig = ReportConfig()
    assess: AssessConfig = AssessConfig()

    @model_validator(mode="after")
    def _stress_needs_a_thickness(self) -> Self:
        if self.forming.pressure is not None and self.strain.thickness is None:
            raise ValueError("forming.pressure gives a stress only with strain.thickness: set both")
        return self
