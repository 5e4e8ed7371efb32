from shapemorph.core.morphed import Morphed
from shapemorph.view.calibrated_images import calibrated_figure


def test_points_lie_on_the_pattern_that_they_follow(results):
    image = results.pair.reference.calibrated.image
    figure = calibrated_figure(results.pair, Morphed(image, results.morphed.warp), results.grid)
    deformed, morphed, undeformed = (axes.lines[0].get_xydata() for axes in figure.axes)
    assert 100 < len(deformed) <= results.grid.ok_count
    assert (morphed == undeformed).all()
    assert abs(deformed / undeformed - [1.2, 1.1]).max() < 1e-9
