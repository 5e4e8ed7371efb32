import numpy as np

from shapemorph.methods.grid_windows import connected_windows


def members(usable: np.ndarray, window: int, chunk: int = 1000) -> dict[int, set[int]]:
    found = {}
    for windows in connected_windows(usable, window=window, chunk=chunk):
        for centre, neighbours, inside in zip(
            windows.centres, windows.neighbours, windows.inside, strict=True
        ):
            assert int(centre) not in found
            found[int(centre)] = set(neighbours[inside].tolist())
    return found


def test_interior_point_has_a_full_square_window():
    found = members(np.ones((9, 11), dtype=bool), 5)
    rows, cols = np.meshgrid(np.arange(2, 7), np.arange(3, 8), indexing="ij")
    assert found[4 * 11 + 5] == set((rows * 11 + cols).ravel().tolist())


def test_every_usable_point_is_a_centre_exactly_once_whatever_the_chunk():
    usable = np.random.default_rng(2).random((13, 17)) > 0.3
    found = members(usable, 5, chunk=7)
    assert set(found) == set(np.flatnonzero(usable).tolist())
    assert found == members(usable, 5, chunk=1000)


def test_window_grows_at_a_rim_until_it_holds_as_many_points():
    found = members(np.ones((20, 20), dtype=bool), 5)
    assert len(found[10]) >= 25  # on the upper edge: 4 x 7
    assert len(found[0]) == 25  # in the corner: 5 x 5


def test_window_never_reaches_across_a_gap():
    usable = np.ones((12, 12), dtype=bool)
    usable[:, 6] = False
    found = members(usable, 5)
    assert all(neighbour % 12 < 6 for neighbour in found[5 * 12 + 5])
    assert all(neighbour % 12 > 6 for neighbour in found[5 * 12 + 7])


def test_lost_points_are_never_members():
    usable = np.random.default_rng(3).random((10, 14)) > 0.2
    allowed = set(np.flatnonzero(usable).tolist())
    assert all(chosen <= allowed for chosen in members(usable, 5).values())
