"""Section `match`: features to a smooth warp."""

from pydantic import Field

from shapemorph.config.section import Section


class MatchConfig(Section):
    """Section `match`: features to a smooth warp."""

    ratio: float = Field(0.85, gt=0, lt=1, description="best over second-best distance")
    max_rounds: int = Field(3, ge=1, description="rounds of matching through the last warp")
    settle_px: float = Field(0.1, gt=0, description="stop when the warp moves less than this, px")
    min_matches: int = Field(20, ge=6, description="fewer pairs are an error")
