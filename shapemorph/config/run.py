"""The YAML file of a whole run."""

from typing import Literal

from pydantic import Field

from shapemorph.config.assess import AssessConfig
from shapemorph.config.correlate import CorrelateConfig
from shapemorph.config.flatten import FlattenConfig
from shapemorph.config.inputs import InputsConfig
from shapemorph.config.match import MatchConfig
from shapemorph.config.morph import MorphConfig
from shapemorph.config.reconstruct import ReconstructConfig
from shapemorph.config.report import ReportConfig
from shapemorph.config.section import Section
from shapemorph.config.surface import AlignConfig, LiftConfig, StrainConfig


class TrackConfig(Section):
    """Section `track`: which method of the paper."""

    method: Literal["shape_morphing"] = Field("shape_morphing", description="the stage list")


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
    align: AlignConfig = AlignConfig()
    strain: StrainConfig = StrainConfig()
    reconstruct: ReconstructConfig = ReconstructConfig()
    report: ReportConfig = ReportConfig()
    assess: AssessConfig = AssessConfig()
