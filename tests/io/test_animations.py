"""Animations that other programs read back."""

import cv2
import numpy as np
from PIL import Image

from shapemorph.core.image import GreyImage
from shapemorph.io.animations import frames_of, write_gif, write_mp4


def _pictures():
    pictures = []
    for number, shape in enumerate([(61, 83), (75, 83), (75, 101)]):
        grey = np.full(shape, 0.2 + 0.2 * number, "f4")
        mask = np.ones(shape, bool)
        mask[:20, :20] = False
        pictures.append(GreyImage(grey, mask))
    return pictures


def test_frames_have_one_even_size_and_are_black_outside_the_masks():
    frames = frames_of(_pictures())
    assert frames.shape == (3, 74, 100)
    assert frames[:, 5, 5].tolist() == [0, 0, 0]
    assert frames[0, 40, 40] == 51
    assert frames[0, 70, 90] == 0  # beyond the smaller picture


def test_large_pictures_are_reduced():
    picture = GreyImage(np.full((300, 1500), 0.5, "f4"), np.ones((300, 1500), bool))
    assert frames_of([picture, picture]).shape == (2, 144, 720)


def test_a_gif_holds_every_frame(tmp_path):
    frames = frames_of(_pictures())
    write_gif(tmp_path / "a.gif", frames)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames == 3
        for number in range(3):
            film.seek(number)
            assert abs(int(film.convert("L").getpixel((40, 40))) - int(frames[number, 40, 40])) < 3


def test_a_film_is_read_back_or_not_there_at_all(tmp_path):
    frames = frames_of(_pictures())
    path = tmp_path / "a.mp4"
    if not write_mp4(path, frames):
        assert not path.exists()
        return
    film = cv2.VideoCapture(str(path))
    assert film.get(cv2.CAP_PROP_FRAME_WIDTH) == 100
    assert film.get(cv2.CAP_PROP_FRAME_HEIGHT) == 74
    found, first = film.read()
    assert found
    assert abs(int(first[40, 60, 0]) - 51) < 8  # lossy
    film.release()


def _coloured():
    frames = np.full((3, 40, 60, 3), 255, np.uint8)
    for number in range(3):
        frames[number, 10:30, 10 * number + 5 : 10 * number + 25] = (200, 30, 60)
    return frames


def test_colours_survive_in_a_gif_and_a_film(tmp_path):
    frames = _coloured()
    write_gif(tmp_path / "a.gif", frames)
    with Image.open(tmp_path / "a.gif") as film:
        for number in range(3):
            film.seek(number)
            shown = np.asarray(film.convert("RGB")).astype(int)
            np.testing.assert_allclose(shown, frames[number], atol=3)
    if write_mp4(tmp_path / "a.mp4", frames):
        film = cv2.VideoCapture(str(tmp_path / "a.mp4"))
        _, first = film.read()
        film.release()
        np.testing.assert_allclose(first[20, 15, ::-1].astype(int), (200, 30, 60), atol=25)
