"""Section `correlate`: subset DIC."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section

OddSize = Annotated[int, Field(ge=5, le=201)]
PAPER = {"tolerance": 0.1, "refinements": 0}  # of `correlate` in mode paper
UNSMOOTH = {"refinements": 0}  # islands that move apart have no smooth warp
PAPER_SIZES = {"subset_size": 21, "spacing": 8}
MOST_SIGMA = 0.06  # px: beyond it one match in ten is off by more than 0.1 px


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
        None,
        description="distance between points, px; empty: from the subset, finer where the "
        "flattening shows a part of the surface much smaller than the rest",
    )
    order: Literal[0, 1, 2] = Field(1, description="order of the subset shape function")
    interpolation: Literal["cubic", "quintic"] = Field(
        "cubic",
        description="spline between the pixels; quintic: less bias from fine patterns, slower",
    )
    threads: Annotated[int, Field(ge=1)] | None = Field(
        None, description="threads of the kernel; empty: all cores"
    )
    tolerance: float = Field(1e-3, gt=0, description="stop below this motion of a corner, px")
    max_iterations: int = Field(30, ge=1, description="beyond it: NOT_CONVERGED")
    min_zncc: float = Field(0.7, ge=-1, le=1, description="below it: LOW_ZNCC")
    max_sigma: Annotated[float, Field(gt=0)] | None = Field(
        None,
        description="largest random error of a component that is believed where it stands out "
        "from the others, px of the deformed side; beyond it: LOW_CONTRAST; empty: 0.06 for two "
        "plain pictures that need features and for reconstructed shapes, else no limit",
    )
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

    def with_certainty(self) -> Self:
        """Believe no random error beyond `MOST_SIGMA` that stands out, unless told otherwise."""
        return self if self.max_sigma else self.model_copy(update={"max_sigma": MOST_SIGMA})

    @property
    def degree(self) -> int:
        """Of the spline between the pixels."""
        return {"cubic": 3, "quintic": 5}[self.interpolation]

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
        if self.mode == "paper" and self.interpolation != "cubic":
            raise ValueError(f"interpolation must be cubic in mode paper, got {self.interpolation}")
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
