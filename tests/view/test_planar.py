from PIL import Image

from shapemorph.core.status import PointStatus
from shapemorph.methods.planar_strain import planar_strain
from shapemorph.view.planar import write_planar_figures
from shapemorph.view.style import STATUS_COLOURS


def test_planar_figures_need_no_opengl(results, tmp_path):
    reference = results.pair.reference.calibrated.image
    strain = planar_strain(results.grid, window=5)
    write_planar_figures(results.grid, strain, reference, tmp_path / "new")
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["correlation.png", "strain.png", "uncertainty.png"]
    colours = Image.open(tmp_path / "new" / names[0]).convert("RGB").getcolors(1 << 20)
    lost = bytes.fromhex(STATUS_COLOURS[PointStatus.LOW_ZNCC][1:])
    # the map has 193 of 3675 points with this status on about 550 x 370 px, and the key a patch
    assert {colour: count for count, colour in colours}[tuple(lost)] > 3000
    for name in names[1:]:
        assert len(Image.open(tmp_path / "new" / name).convert("RGB").getcolors(1 << 20)) > 200
