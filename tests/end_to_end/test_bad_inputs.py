"""What users get wrong: one clear line, the right exit code, nothing left behind."""

import shutil

import numpy as np
import pytest

from shapemorph.cli import main
from shapemorph.core.mesh import textured_mesh
from shapemorph.io.images import write_grey_png
from shapemorph.io.mesh_writers import write_mesh

pytestmark = pytest.mark.slow


@pytest.fixture
def copy(pair, tmp_path):
    """Copies of both meshes that may be spoilt."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    for side in ("reference", "deformed"):
        for suffix in ("obj", "mtl", "png"):
            shutil.copy(pair / f"{side}.{suffix}", folder)
    return folder


def _measure(folder, output, capsys):
    """Exit code and the one line on stderr; nothing on stdout."""
    words = ["measure", folder / "reference.obj", folder / "deformed.obj", "-o", output, "--quiet"]
    settings = ["--set", "report.figures=false"]
    code = main([str(word) for word in (*words, *settings)])
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1, said.err
    assert said.err.startswith("shapemorph: ")
    assert "Traceback" not in said.err
    return code, said.err


def _missing(folder):
    (folder / "deformed.obj").unlink()


def _missing_texture(folder):
    (folder / "deformed.png").unlink()


def _empty(folder):
    (folder / "deformed.obj").write_text("")


def _no_faces(folder):
    (folder / "deformed.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")


def _nan(folder):
    path = folder / "deformed.obj"
    lines = path.read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("v "))
    path.write_text("\n".join([*lines[:first], "v nan 0 0", *lines[first + 1 :]]))


def _truncated_picture(folder):
    path = folder / "deformed.png"
    path.write_bytes(path.read_bytes()[:20_000])


def _truncated_mesh(folder):
    path = folder / "deformed.obj"
    text = path.read_text()
    path.write_text(text[: text.index("vt ") + 100] + "\nf 1/1 2/2 99999999/3\n")


def _blank(folder):
    grey = np.full((1024, 1024), 0.5, "f4")
    write_grey_png(folder / "deformed.png", grey, np.ones(grey.shape, bool))


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (_missing, r"deformed.obj does not exist"),
        (_missing_texture, r"deformed.png"),
        (_empty, r"deformed.obj"),
        (_no_faces, r"deformed.obj"),
        (_nan, r"deformed.obj"),
        (_truncated_mesh, r"deformed.obj"),
        (_truncated_picture, r"deformed.png"),
        (_blank, r"blank"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_damaged_input_is_exit_3_names_the_file_and_leaves_nothing(
    copy, tmp_path, capsys, spoil, says
):
    spoil(copy)
    code, line = _measure(copy, tmp_path / "run", capsys)
    assert code == 3
    assert says in line
    assert not (tmp_path / "run").exists()


def _speckle(seed, size=1024):
    """A random pattern of blobs about 8 px wide."""
    from scipy.ndimage import gaussian_filter

    noise = gaussian_filter(np.random.default_rng(seed).normal(size=(size, size)), 3.0, mode="wrap")
    return np.clip(0.5 + 0.25 * noise / noise.std(), 0, 1).astype("f4")


def _another_texture(folder):
    grey = _speckle(5)
    write_grey_png(folder / "deformed.png", grey, np.ones(grey.shape, bool))


def _another_object(folder):
    """A wavy sheet of 60 x 45 mm with a pattern of its own."""
    rows, columns = np.mgrid[0:31, 0:41]
    uv = np.stack([columns / 40, rows / 30], axis=-1).reshape(-1, 2)
    vertices = np.column_stack([60 * uv[:, 0], 45 * uv[:, 1], 4 * np.sin(7 * uv[:, 0])])
    corner = (41 * np.arange(30)[:, None] + np.arange(40)).ravel()
    lower = np.column_stack([corner, corner + 1, corner + 41])
    upper = np.column_stack([corner + 1, corner + 42, corner + 41])
    faces = np.concatenate([lower, upper])
    zeros = np.zeros(len(faces), int)
    mesh = textured_mesh(vertices, faces, uv[faces], zeros, (_speckle(9),), name="sheet")
    write_mesh(folder / "deformed.obj", mesh)


@pytest.mark.parametrize("spoil", [_another_texture, _another_object])
def test_what_does_not_belong_together_is_exit_4_and_gives_no_result(copy, tmp_path, capsys, spoil):
    spoil(copy)
    code, line = _measure(copy, tmp_path / "run", capsys)
    assert code == 4, line
    assert "expected" in line or "needed" in line
    made = {path.name for path in (tmp_path / "run").rglob("*")}
    assert not made & {"measurement.vtp", "measurement.csv", "summary.json", "match"}
    assert not [name for name in made if name.startswith(".")]


def test_units_that_differ_are_exit_2_and_name_the_keys(copy, tmp_path, capsys):
    path = copy / "deformed.obj"
    lines = [
        "v " + " ".join(str(float(x) * 10) for x in line.split()[1:4])
        if line.startswith("v ")
        else line
        for line in path.read_text().splitlines()
    ]
    path.write_text("\n".join(lines) + "\n")
    code, line = _measure(copy, tmp_path / "run", capsys)
    assert code == 2
    assert "inputs.deformed_units" in line
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("place", ["/proc/shapemorph/run", "file/run"])
def test_a_directory_that_cannot_be_written_is_exit_2(copy, tmp_path, capsys, monkeypatch, place):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    code, line = _measure(copy, place, capsys)
    assert code == 2
    assert "choose another place with -o" in line


def test_somebodys_folder_is_exit_2(copy, capsys):
    code, line = _measure(copy, copy, capsys)
    assert code == 2
    assert "no run of shapemorph" in line
    assert len(list(copy.iterdir())) == 6
