"""The YAML file as types: one frozen model per section, all defaults, unknown keys are errors."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Unit = Literal["mm", "um", "cm", "m", "in"]
Vector3 = tuple[float, float, float]
Channel = Literal["auto", "luma", "red", "green", "blue"]


class Section(BaseModel):
    """Base of every section: immutable, unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")


Polygon = Annotated[list[tuple[float, float]], Field(min_length=3)]


class RegionConfig(Section):
    """A part of the reference; every given limit applies."""

    polygon: Polygon | None = Field(
        None,
        description="corners (x, y) in px of the flattened reference image, or of the reference "
        "picture where pictures are measured",
    )
    polygons: Annotated[list[Polygon], Field(min_length=1)] | None = Field(
        None, description="several of them; the region is what lies in any"
    )
    holes: Annotated[list[Polygon], Field(min_length=1)] | None = Field(
        None, description="polygons that are left out"
    )
    mask: Path | None = Field(
        None, description="picture of the size of that image, white = measured"
    )
    centre: Vector3 | None = Field(
        None,
        description="centre of a ball, in the reference file's units and frame; of meshes only",
    )
    radius: float | None = Field(None, gt=0, description="radius of the ball, in the same units")

    @model_validator(mode="after")
    def _ball_is_whole(self) -> Self:
        if (self.centre is None) != (self.radius is None):
            raise ValueError("centre and radius describe a ball together: give both or neither")
        return self


class InputsConfig(Section):
    """What is measured."""

    reference: Path | None = Field(
        None, description="textured mesh, or picture, before the deformation"
    )
    deformed: Path | None = Field(None, description="the same after the deformation")
    sequence: Path | None = Field(
        None,
        description="pictures of one view instead of the two: a pattern such as frames/*.tif, or "
        "a TIFF of many pages; the first is the reference",
    )
    units: Unit = Field("mm", description="length unit of both files, whatever their format")
    reference_units: Unit | None = Field(None, description="overrides units for the reference")
    deformed_units: Unit | None = Field(None, description="overrides units for the deformed")
    channel: Channel = Field(
        "auto",
        description="what of the colours becomes grey, on both sides; auto: luma, unless a channel "
        "shows twice its gradient",
    )
    landmarks: Path | None = Field(
        None, description="CSV name,ref_x,ref_y,ref_z,def_x,def_y,def_z in the frames of the files"
    )
    region: RegionConfig | None = Field(None, description="limits the measurement")

    @model_validator(mode="after")
    def _sequence_stands_alone(self) -> Self:
        if self.sequence is not None and (self.reference or self.deformed):
            raise ValueError(
                "sequence stands instead of reference and deformed: give one or the other"
            )
        return self


FlatteningMethod = Literal[
    "auto",
    "bff",
    "lscm",
    "arap",
    "slim",
    "harmonic",
    "orthographic",
    "spherical",
    "cylindrical",
    "profile",
]
PARAMETERS_OF_METHODS = {
    "charts": ("auto", "bff", "lscm", "arap", "slim", "harmonic"),
    "axis": ("orthographic", "spherical", "cylindrical", "profile"),
    "centre": ("spherical", "cylindrical", "profile"),
    "projection": ("spherical",),
    "profile": ("profile",),
}


class FlattenConfig(Section):
    """Section `flatten`: meshes to calibrated images."""

    method: FlatteningMethod = Field(
        "auto", description="auto: boundary-first (bff), repaired or replaced where it flips"
    )
    px_per_mm: float | None = Field(
        None, gt=0, description="image scale; empty: from the size of the speckle"
    )
    speckle_px: float = Field(
        5.0, ge=3, le=20, description="size of a speckle that the automatic scale aims at, px"
    )
    max_megapixels: float = Field(
        16.0, gt=0, description="largest calibrated image; a finer scale is reduced to it"
    )
    charts: int | None = Field(
        None,
        ge=1,
        le=64,
        description="pieces that the largest component is split into; empty: as few as show it "
        "well",
    )
    axis: Vector3 | None = Field(
        None,
        description="towards the viewer (orthographic), from the centre to the picture's middle "
        "(spherical), or of symmetry (cylindrical, profile); empty: fitted",
    )
    centre: Vector3 | None = Field(
        None,
        description="centre of the ball (spherical) or a point of the axis (cylindrical, profile), "
        "mm, in the frame of each file; empty: fitted",
    )
    projection: Literal["equidistant", "equal_area", "stereographic"] | None = Field(
        None,
        description="kind of spherical: meridian lengths (equidistant, when empty), areas "
        "(equal_area) or angles (stereographic) are kept",
    )
    profile: Path | None = Field(
        None,
        description="CSV r,z of the meridian for profile, from the axis outward, in the units of "
        "the deformed file; empty, or where it does not fit: measured from the mesh",
    )

    @model_validator(mode="after")
    def _parameters_have_a_use(self) -> Self:
        for name, methods in PARAMETERS_OF_METHODS.items():
            if getattr(self, name) is not None and self.method not in methods:
                raise ValueError(
                    f"{name} is for method {', '.join(methods)}, got method {self.method}: "
                    "set one of these, or leave it empty"
                )
        return self


class MatchConfig(Section):
    """Section `match`: features to a smooth warp."""

    ratio: float = Field(0.85, gt=0, lt=1, description="best over second-best distance")
    max_rounds: int = Field(3, ge=1, description="rounds of matching through the last warp")
    settle_px: float = Field(0.1, gt=0, description="stop when the warp moves less than this, px")
    min_matches: int = Field(20, ge=6, description="fewer pairs are an error")


Law = Literal["warp", "polynomial", "landmarks", "fe", "identity"]


class MorphConfig(Section):
    """Section `morph`: the deformed image brought close to the reference."""

    law: Law = Field(
        "warp",
        description="warp: free two-dimensional, from the matches; polynomial: r_m of the radius; "
        "landmarks: through marks; fe: from a finite element result; identity: nothing deformed",
    )
    laws: tuple[Law, ...] = Field(
        (), description="further laws to measure with; their spread is a systematic uncertainty"
    )
    order: int = Field(3, ge=1, le=9, description="polynomial: highest power of the radius")
    centre: tuple[float, float] | None = Field(
        None, description="polynomial, landmarks: centre in the flattened reference, px"
    )
    coefficients: list[float] | None = Field(
        None, min_length=1, description="polynomial: c_1, c_2, ... in mm of the flattened images"
    )
    dots: Path | None = Field(
        None,
        description="landmarks: CSV x_ref_px,y_ref_px,x_def_px,y_def_px in the flattened images; "
        "empty: those of inputs.landmarks",
    )
    fe: Path | None = Field(
        None, description="fe: CSV r0,r,z or x,y,z,ux,uy,uz, frd, or what meshio reads (vtu, inp)"
    )
    fe_model: Literal["solid", "axisymmetric"] = Field(
        "solid", description="fe: axisymmetric meshes have the radius as x and the axis as y"
    )
    fe_deformed: Path | None = Field(
        None, description="fe: mesh with the same nodes after the deformation"
    )
    fe_displacement: str | None = Field(None, description="fe: name of the displacements")
    fe_units: Unit | None = Field(None, description="fe: length unit; empty: the reference's")
    images: int | None = Field(
        None,
        ge=0,
        multiple_of=2,
        description="synthetic images of the morph sequence (N - 2); empty: from strain and ZNCC",
    )

    @property
    def all_laws(self) -> tuple[Law, ...]:
        """Every law that is asked for, the main one first, each once."""
        return tuple(dict.fromkeys((self.law, *self.laws)))

    @model_validator(mode="after")
    def _laws_have_their_files(self) -> Self:
        if "fe" in self.all_laws and self.fe is None:
            raise ValueError("law fe needs the path of a finite element result: give morph.fe")
        return self


class TrackConfig(Section):
    """Section `track`: which method of the paper."""

    method: Literal["shape_morphing"] = Field("shape_morphing", description="the stage list")


OddSize = Annotated[int, Field(ge=5, le=201)]


PAPER = {"tolerance": 0.1, "refinements": 0}  # of `correlate` in mode paper
UNSMOOTH = {"refinements": 0}  # islands that move apart have no smooth warp
PAPER_SIZES = {"subset_size": 21, "spacing": 8}


class CorrelateConfig(Section):
    """Section `correlate`: subset DIC."""

    mode: Literal["icgn", "paper"] = Field(
        "icgn",
        description="icgn: inverse compositional Gauss-Newton; paper: as Genovese and Sorgente "
        "2017, whole-pixel search, then affine to 0.1 px; its own subset_size is 21, spacing 8, "
        "tolerance 0.1, refinements 0",
    )
    search: OddSize = Field(
        41,
        description="mode paper, seeds propagate: width of the window in which a subset is "
        "sought, odd, px",
    )
    seeds: Literal["warp", "propagate"] = Field(
        "warp",
        description="where points start: warp: from the morph; propagate: from searched seeds, "
        "neighbour by neighbour, and two pictures need no features (refinements is 0 then)",
    )
    subset_size: OddSize | None = Field(
        None, description="width of a subset, odd, px; empty: from the speckle"
    )
    spacing: Annotated[int, Field(ge=1, le=200)] | None = Field(
        None, description="distance between points, px; empty: from the subset"
    )
    order: Literal[0, 1, 2] = Field(1, description="order of the subset shape function")
    threads: Annotated[int, Field(ge=1)] | None = Field(
        None, description="threads of the kernel; empty: all cores"
    )
    tolerance: float = Field(1e-3, gt=0, description="stop below this motion of a corner, px")
    max_iterations: int = Field(30, ge=1, description="beyond it: NOT_CONVERGED")
    min_zncc: float = Field(0.7, ge=-1, le=1, description="below it: LOW_ZNCC")
    min_inside: float = Field(
        0.5, gt=0, le=1, description="share of a subset that must lie inside the mask"
    )
    refinements: int = Field(
        1, ge=0, le=5, description="times the morph is renewed from the field that DIC found"
    )

    reference: Literal["first", "previous", "auto"] = Field(
        "auto",
        description="of a sequence of pictures, which one each is compared with; auto: the first, "
        "and a later one as soon as that agrees better",
    )
    update_zncc: float = Field(
        0.9, gt=0, lt=1, description="auto: a later reference is tried below this median ZNCC"
    )
    update_strain: float = Field(
        0.5, gt=0, description="auto: and above this strain, E1 since the reference, of 5 % of it"
    )

    @model_validator(mode="before")
    @classmethod
    def _ways_have_their_own_defaults(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        if given.get("mode") != "paper":
            return UNSMOOTH | given if given.get("seeds") == "propagate" else given
        empty = {key: size for key, size in PAPER_SIZES.items() if given.get(key) is None}
        return PAPER | given | empty

    @model_validator(mode="after")
    def _search_has_room(self) -> Self:
        if self.mode != "paper" and self.seeds != "propagate":
            return self
        if self.subset_size is not None and self.search < self.subset_size + 2:
            raise ValueError(
                f"search {self.search} px leaves a subset of {self.subset_size} px no room to be "
                "sought in: raise search or lower subset_size"
            )
        return self

    @model_validator(mode="after")
    def _paper_is_affine_and_has_its_own_seeds(self) -> Self:
        if self.mode == "paper" and self.order != 1:
            raise ValueError(f"order must be 1 in mode paper, got {self.order}")
        if self.mode == "paper" and self.seeds != "warp":
            raise ValueError("mode paper searches every point: leave seeds out")
        return self

    @model_validator(mode="after")
    def _subset_has_a_centre(self) -> Self:
        if self.search % 2 == 0:
            raise ValueError(f"search must be odd, got {self.search}")
        if self.subset_size is not None and self.subset_size % 2 == 0:
            raise ValueError(f"subset_size must be odd, got {self.subset_size}")
        if self.subset_size and self.spacing and self.spacing > self.subset_size:
            raise ValueError(
                f"spacing {self.spacing} px leaves gaps between subsets of {self.subset_size} px: "
                "lower spacing or raise subset_size"
            )
        return self


class LiftConfig(Section):
    """Section `lift`: grid positions to points in space."""

    max_extrapolation_px: float = Field(
        1.0, ge=0, description="farthest a match may lie outside the mesh and still be placed, px"
    )


class AlignConfig(Section):
    """Section `align`: the rigid motion between the two files."""

    method: Literal["auto", "landmarks", "icp", "landmarks+icp", "points"] = Field(
        "auto", description="auto: landmarks where given, else a robust fit to matched points"
    )
    rigid_region: RegionConfig | None = Field(
        None, description="part of the reference that did not deform; icp and points use only it"
    )
    icp_iterations: int = Field(50, ge=1, description="most iterations of ICP")

    @model_validator(mode="after")
    def _region_has_a_use(self) -> Self:
        if self.rigid_region is not None and self.method == "landmarks":
            raise ValueError(
                "rigid_region is for method icp, landmarks+icp, points or auto, got method "
                "landmarks, which takes no points of the surface: leave one of the two out"
            )
        return self


class StrainConfig(Section):
    """Section `strain`: the local fit."""

    window: int = Field(5, ge=3, le=51, description="points across the fitting window, odd")

    @model_validator(mode="after")
    def _window_has_a_centre(self) -> Self:
        if self.window % 2 == 0:
            raise ValueError(f"window must be odd, got {self.window}")
        return self


class ReportConfig(Section):
    """Section `report`: pictures and the page."""

    figures: bool = Field(True, description="write figures/*.png and show them in report.html")


class StarConfig(Section):
    """A picture pair whose displacement has one amplitude and a period that grows along x."""

    periods: tuple[float, float] = Field(
        (10.0, 300.0),
        description="in the first and in the last column of the picture, px; linear between",
    )
    amplitude: float = Field(0.5, gt=0, description="px")
    component: Literal["u", "v"] = Field("v", description="which displacement is imposed")
    row: float | None = Field(
        None, description="where the amplitude is the same at all periods, px; empty: the middle"
    )

    @model_validator(mode="after")
    def _periods_grow(self) -> Self:
        if not 2.0 <= self.periods[0] < self.periods[1]:
            raise ValueError(f"periods must grow from 2 px or more, got {list(self.periods)}")
        return self


class AssessConfig(Section):
    """Section `assess`: how well pictures can be correlated."""

    star: StarConfig | None = Field(
        None, description="the pair is a star pattern: spatial resolution and MEI are measured"
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
    align: AlignConfig = AlignConfig()
    strain: StrainConfig = StrainConfig()
    report: ReportConfig = ReportConfig()
    assess: AssessConfig = AssessConfig()


class FoldersConfig(Section):
    """Specimens found on the disk, one in each folder."""

    pattern: str = Field(description="glob of folders; the name of a folder names the case")
    reference: str = Field("reference.*", description="glob of the reference file in each")
    deformed: str = Field("deformed.*", description="glob of the deformed file in each")


class ClusterConfig(Section):
    """Where the cases of a batch run."""

    workers: int | None = Field(
        None, ge=1, description="cases at a time on this machine; empty: one for each core"
    )
    threads: int | None = Field(
        None, ge=1, description="threads of each; empty: the cores divided by the workers"
    )
    memory_gb: float | None = Field(
        None, gt=0, description="most memory of each; empty: nine tenths divided by the workers"
    )
    attempts: int = Field(2, ge=1, description="times a case is tried whose worker dies")


class BatchConfig(Section):
    """The YAML file of a batch."""

    version: Literal[1] = Field(1, description="of this file format")
    base: Path | dict[str, Any] = Field({}, description="sections of a run, or the path of a run's")
    cases: list[dict[str, Any]] | None = Field(
        None, description="name, reference, deformed and any other keys of each case"
    )
    table: Path | None = Field(None, description="CSV with one column for each such key")
    folders: FoldersConfig | None = Field(None, description="cases found on the disk")
    cluster: ClusterConfig = ClusterConfig()

    @model_validator(mode="after")
    def _cases_come_from_one_place(self) -> Self:
        given = [n for n in ("cases", "table", "folders") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError(
                "expected one of cases, table and folders, got "
                f"{' and '.join(given) if given else 'none'}"
            )
        return self


class DamageConfig(Section):
    """What went wrong with the pattern of the deformed side."""

    glare: bool = Field(False, description="a saturated spot")
    lost_patch: bool = Field(False, description="a patch without pattern")
    print_at_pole: bool = Field(False, description="a foreign mark at the pole")


class SynthesizeConfig(Section):
    """Section `synthesize`: a textured pair with exact truth."""

    shape: Literal[
        "dome", "bulge", "indentation", "freeform", "hole", "tube", "rigid", "balloon", "sheet"
    ] = Field("bulge", description="kind of deformation")
    size: float = Field(70.0, gt=0, description="diameter or length of the object, mm")
    speckle: float = Field(0.8, gt=0, description="diameter of a speckle on the material, mm")
    faces: int = Field(40_000, ge=200, description="triangles of each mesh, about")
    texture: int = Field(2048, ge=64, le=16384, description="width of the square texture, px")
    grey_noise: float = Field(2.0, ge=0, description="noise of the texture, grey levels of 255")
    vertex_noise: float = Field(
        0.006, ge=0, description="noise of every vertex coordinate, mm, one sigma"
    )
    seed: int = Field(0, ge=0, description="of everything random")
    format: Literal["obj", "glb", "ply"] = Field("obj", description="file format of both sides")
    offset: float = Field(0.0, description="indentation: distance of the punch from the centre, mm")
    tilt: float = Field(0.0, ge=-20, le=20, description="indentation: tilt of the punch, degrees")
    stretch: float = Field(2.0, gt=0, description="sheet: stretch along its direction")
    direction: float = Field(
        0.0,
        description="sheet: of the stretch, from the long side of the sheet; freeform: of all that "
        "happens to it, against the reference; degrees",
    )
    turn: float = Field(0.0, description="sheet: turned in its plane afterwards, degrees")
    damage: DamageConfig = DamageConfig()
