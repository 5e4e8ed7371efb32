"""Write docs/outputs.md from the table of quantities."""

from pathlib import Path

from shapemorph.io.outputs_page import outputs_page

if __name__ == "__main__":
    page = Path(__file__).parents[1] / "docs" / "outputs.md"
    page.write_text(outputs_page(), encoding="utf-8")
