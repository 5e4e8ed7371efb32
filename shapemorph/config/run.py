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
    """A whole run; its defaults are not checked, so that only the check of the whole is built."""

    version: Literal[1] = Field(1, description="of this file format")
    inputs: InputsConfig = InputsConfig.model_construct()
    track: TrackConfig = TrackConfig.model_construct()
    flatten: FlattenConfig = FlattenConfig.model_construct()
    match: MatchConfig = MatchConfig.model_construct()
    morph: MorphConfig = MorphConfig.model_construct()
    correlate: CorrelateConfig = CorrelateConfig.model_construct()
    lift: LiftConfig = LiftConfig.model_construct()
    spread: SpreadConfig = SpreadConfig.model_construct()
    align: AlignConfig = AlignConfig.model_construct()
    strain: StrainConfig = StrainConfig.model_construct()
    forming: FormingConfig = FormingConfig.model_construct()
    reconstruct: ReconstructConfig = ReconstructConfig.model_construct()
    report: ReportConfig = ReportConfig.model_construct()
    assess: AssessConfig = AssessConfig.model_construct()

    @model_validator(mode="after")
    def _stress_needs_a_thickness(self) -> Self:
        if self.forming.pressure is not None and self.strain.thickness is None:
            raise ValueError("forming.pressure gives a stress only with strain.thickness: set both")
        return self
