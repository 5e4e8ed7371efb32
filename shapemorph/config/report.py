"""Section `report`: pictures and the page."""

from pydantic import Field

from shapemorph.config.section import Section


class ReportConfig(Section):
    """Section `report`: pictures and the page."""

    figures: bool = Field(True, description="write figures/*.png and show them in report.html")
