"""Cases of a batch from each of their sources."""

import pytest

from shapemorph.config import BatchConfig, RunConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.batch_files import read_cases
from shapemorph.io.config_files import check_config, read_config


@pytest.fixture
def write(tmp_path):
    def write_file(name, text):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    return write_file


def _cases(path):
    cases = read_cases(read_config(path, BatchConfig), path)
    return {case.name: check_config(case.document, RunConfig) for case in cases}


def test_a_case_lies_over_the_base_as_sections_or_dotted_keys(write, tmp_path):
    path = write(
        "lab/batch.yaml",
        """
base: {strain: {window: 7}, correlate: {spacing: 9}, inputs: {units: cm}}
cases:
  - {name: a, reference: x/a.obj, deformed: /far/b.obj, strain.window: 9}
  - name: b
    inputs: {reference: r.obj, deformed: d.obj, reference_units: m}
    correlate: {order: 2}
""",
    )
    found = _cases(path)
    assert list(found) == ["a", "b"]
    assert (found["a"].strain.window, found["b"].strain.window) == (9, 7)
    assert found["a"].inputs.reference == tmp_path / "lab" / "x" / "a.obj"
    assert str(found["a"].inputs.deformed) == "/far/b.obj"
    assert found["b"].inputs.reference == tmp_path / "lab" / "r.obj"
    assert (found["b"].inputs.units, found["b"].inputs.reference_units) == ("cm", "m")
    assert (found["b"].correlate.order, found["b"].correlate.spacing) == (2, 9)


def test_a_base_file_has_its_own_relative_paths(write, tmp_path):
    write("settings/base.yaml", "inputs: {landmarks: marks.csv}\nmatch: {ratio: 0.7}\n")
    path = write(
        "batch.yaml",
        "base: settings/base.yaml\ncases: [{name: a, reference: r.obj, deformed: d.obj}]\n",
    )
    (case,) = _cases(path).values()
    assert case.inputs.landmarks == tmp_path / "settings" / "marks.csv"
    assert case.inputs.reference == tmp_path / "r.obj"
    assert case.match.ratio == 0.7


def test_a_table_has_a_case_a_line_and_empty_cells_say_nothing(write, tmp_path):
    write(
        "tables/specimens.csv",
        "name,reference,deformed,strain.window,flatten.method\n"
        "007,a/1.obj,a/2.obj,9,\n"
        "008,b/1.obj,b/2.obj,,bff\n",
    )
    path = write("batch.yaml", "base: {strain: {window: 11}}\ntable: tables/specimens.csv\n")
    found = _cases(path)
    assert list(found) == ["007", "008"]
    assert (found["007"].strain.window, found["008"].strain.window) == (9, 11)
    assert (found["007"].flatten.method, found["008"].flatten.method) == ("auto", "bff")
    assert found["008"].inputs.deformed == tmp_path / "tables" / "b" / "2.obj"


def test_folders_are_cases_and_pictures_beside_the_mesh_are_no_mesh(write, tmp_path):
    for name in ("s2", "s10"):
        for file in ("before.obj", "before.mtl", "before.png", "after.glb"):
            write(f"scans/{name}/{file}", "")
    write("scans/notes.txt", "")
    path = write(
        "batch.yaml", 'folders: {pattern: "scans/*", reference: "before.*", deformed: "after.*"}\n'
    )
    found = _cases(path)
    assert set(found) == {"s2", "s10"}
    assert found["s10"].inputs.reference == tmp_path / "scans" / "s10" / "before.obj"
    assert found["s10"].inputs.deformed == tmp_path / "scans" / "s10" / "after.glb"


def test_a_folder_without_its_mesh_is_still_a_case(write):
    write("scans/s1/deformed.obj", "")
    path = write("batch.yaml", 'folders: {pattern: "scans/*"}\n')
    assert _cases(path)["s1"].inputs.reference.name == "reference.*"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("cases: []\n", "at least one case"),
        ("workers: 2\n", "unknown key workers; did you mean cluster.workers"),
        ("base: {}\n", "one of cases, table and folders, got none"),
        ("table: t.csv\nfolders: {pattern: x}\n", "got table and folders"),
        ("cases: [{name: a}, {name: b}, {name: a}]\n", "one case of each name, got a twice"),
        ("cases: [{reference: a.obj}]\n", "case 1: expected a name"),
        ("cases: [{name: ../a}]\n", r"got '\.\./a'"),
        ("cases: [{name: .hidden}]\n", r"got '\.hidden'"),
        ("base: nowhere.yaml\ncases: [{name: a}]\n", "no such configuration file"),
    ],
)
def test_a_batch_file_that_is_wrong_is_refused_in_one_line(write, text, message):
    with pytest.raises(ConfigError, match=message):
        _cases(write("batch.yaml", text))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("name,reference\na,b,c\n", "line 2: more cells"),
        ("name,strain.window\na,[\n", "line 2: strain.window is not YAML"),
        (None, "expected a CSV table"),
    ],
)
def test_a_table_that_is_wrong_is_an_error_of_data(write, table, message):
    if table:
        write("t.csv", table)
    with pytest.raises(DataError, match=message):
        _cases(write("batch.yaml", "table: t.csv\n"))
