"""The YAML files as types: one frozen model per section, all defaults, unknown keys are errors."""

from shapemorph.config.assess import AssessConfig, StarConfig
from shapemorph.config.batch import BatchConfig, ClusterConfig, FoldersConfig
from shapemorph.config.calibrate import (
    CalibrateConfig,
    RigConfig,
    TargetConfig,
    ViewsConfig,
)
from shapemorph.config.correlate import CorrelateConfig, OddSize
from shapemorph.config.flatten import FlattenConfig, FlatteningMethod
from shapemorph.config.forming import CutConfig, FormingConfig
from shapemorph.config.inputs import Channel, InputsConfig, Polygon, RegionConfig
from shapemorph.config.match import MatchConfig
from shapemorph.config.morph import Law, MorphConfig
from shapemorph.config.reconstruct import ReconstructConfig
from shapemorph.config.report import EquipmentConfig, ReportConfig
from shapemorph.config.reproduce import BulgeConfig, ReproduceConfig
from shapemorph.config.run import RunConfig, TrackConfig
from shapemorph.config.section import Section, Unit, Vector3
from shapemorph.config.spread import SpreadConfig
from shapemorph.config.surface import AlignConfig, LiftConfig, StrainConfig
from shapemorph.config.synthesize import DamageConfig, SynthesizeConfig
from shapemorph.config.turn import TurnConfig
from shapemorph.config.twin import TwinConfig

__all__ = [
    "AlignConfig",
    "AssessConfig",
    "BatchConfig",
    "BulgeConfig",
    "CalibrateConfig",
    "Channel",
    "ClusterConfig",
    "CorrelateConfig",
    "CutConfig",
    "DamageConfig",
    "EquipmentConfig",
    "FlattenConfig",
    "FlatteningMethod",
    "FoldersConfig",
    "FormingConfig",
    "InputsConfig",
    "Law",
    "LiftConfig",
    "MatchConfig",
    "MorphConfig",
    "OddSize",
    "Polygon",
    "ReconstructConfig",
    "RegionConfig",
    "ReportConfig",
    "ReproduceConfig",
    "RigConfig",
    "RunConfig",
    "Section",
    "SpreadConfig",
    "StarConfig",
    "StrainConfig",
    "SynthesizeConfig",
    "TargetConfig",
    "TrackConfig",
    "TurnConfig",
    "TwinConfig",
    "Unit",
    "Vector3",
    "ViewsConfig",
]
