import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.picture_sets import named_pictures


@pytest.fixture
def folder(tmp_path):
    for name in ("left2.png", "left10.png", "left1.png", "right1.png", "other.txt"):
        (tmp_path / name).touch()
    return tmp_path


def test_the_star_names_the_view_and_numbers_count(folder):
    found = named_pictures(folder, "left*.png")
    assert list(found) == ["1", "2", "10"]
    assert found["10"] == folder / "left10.png"


def test_a_star_may_stand_for_a_folder(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "left.png").touch()
    assert list(named_pictures(tmp_path, "*/left.png")) == ["a", "b"]


def test_one_file_and_an_absolute_pattern(folder):
    assert named_pictures(folder, "right1.png") == {"": folder / "right1.png"}
    assert list(named_pictures(folder, str(folder / "r*.png"))) == ["ight1"]


@pytest.mark.parametrize(
    ("pattern", "message"),
    [("top*.png", "no file in"), ("top.png", "no such file"), ("*1.*", "expected one star")],
)
def test_says_what_is_missing(folder, pattern, message):
    with pytest.raises(DataError, match=message):
        named_pictures(folder, pattern)


def test_a_whole_path_that_matches_nothing_is_said_with_its_folder(tmp_path):
    with pytest.raises(DataError, match=f"no file in {tmp_path} matches"):
        named_pictures(tmp_path / "elsewhere", str(tmp_path / "top*.png"))
    with pytest.raises(DataError, match=f"no file in {tmp_path} matches"):
        named_pictures(tmp_path, "view*/top.png")
