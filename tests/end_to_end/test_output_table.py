"""docs/outputs.md against the files of a real run."""

import numpy as np
import pytest
import pyvista

from shapemorph.cli import main
from shapemorph.io.measurement_files import read_csv, read_facets, read_vtp
from shapemorph.io.quantities import (
    CALIBRATED,
    FACET_ARRAYS,
    FLATTENED,
    MATCHES,
    QUANTITIES,
    REFERENCE,
    WARP,
)

ALWAYS = [quantity for quantity in QUANTITIES if not quantity.only_with]


@pytest.fixture(scope="session")
def field(measured):
    return read_vtp(measured / "measurement.vtp")[0]


def test_the_vtp_holds_exactly_the_listed_arrays(field):
    listed = {q.name: (q.kind, q.components) for q in ALWAYS}
    found = {
        name: (values.dtype.name, values.shape[1] if values.ndim > 1 else 1)
        for name, values in field.arrays.items()
    }
    assert found == listed


def test_the_csv_holds_exactly_the_listed_columns_with_their_values(measured, field):
    columns = read_csv(measured / "measurement.csv")
    assert list(columns) == [c for q in (REFERENCE, *ALWAYS) for c in q.columns]
    values = {REFERENCE.name: field.reference, **field.arrays}
    for quantity in (REFERENCE, *ALWAYS):
        for number, column in enumerate(quantity.columns):
            expected = values[quantity.name].reshape(len(field.reference), -1)[:, number]
            if quantity.name == "iterations":
                expected = np.nan_to_num(expected)
            np.testing.assert_allclose(columns[column], expected, rtol=1e-9, err_msg=column)


def test_the_facets_hold_exactly_the_listed_arrays(measured, field):
    facets = read_facets(measured / "facets.vtp")
    assert set(facets.arrays) == set(FACET_ARRAYS)
    assert len(facets.corners) == 2 * len(field.cells)
    assert facets.corners.max() < len(field.reference)
    around = field.arrays["area_ratio"][facets.corners].mean(axis=1)  # fit and facet agree
    assert np.median(np.abs(facets.arrays["area_ratio"] - around)) < 0.02


def test_formulas_of_derived_arrays_hold(field):
    a = field.arrays
    np.testing.assert_allclose(a["stretch_1"], np.sqrt(1 + 2 * a["E1"]), rtol=1e-12)
    np.testing.assert_allclose(a["hencky_2"], np.log(a["stretch_2"]), atol=1e-12)
    np.testing.assert_allclose(a["thickness_strain"], -(a["hencky_1"] + a["hencky_2"]), atol=1e-12)
    clear = np.abs(a["E2"]) > 3 * a["sigma_E2"]
    np.testing.assert_array_equal(np.isfinite(a["anisotropy"]), clear)
    np.testing.assert_allclose(a["anisotropy"][clear], (a["E1"] / a["E2"])[clear], rtol=1e-12)


def test_the_calibrated_images_hold_exactly_the_listed_arrays(measured):
    image = pyvista.read(measured / "flatten" / "reference.vti")
    assert set(image.point_data) == {name for name, *_ in CALIBRATED}


def test_export_writes_the_arrays_of_the_vtp_beside_it(measured, field, capsys):
    assert main(["export", str(measured), "--format", "npz"]) == 0
    path = measured / "measurement.npz"
    assert capsys.readouterr().out.strip() == str(path)
    with np.load(path, allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["points"], field.reference)
        np.testing.assert_array_equal(archive["E1"], field.arrays["E1"])
        assert len(archive["facets"]) == len(archive["facet_E1"]) == 2 * len(field.cells)
    path.unlink()


def test_export_of_what_is_no_run_is_an_error_of_data(tmp_path, capsys):
    assert main(["export", str(tmp_path), "--format", "mat"]) == 3
    assert "measurement.vtp" in capsys.readouterr().err


def test_the_arrays_of_one_flattened_mesh_are_listed(pair, tmp_path):
    words = ["-o", str(tmp_path), "--set", "report.figures=false", "--quiet"]
    assert main(["flatten", str(pair / "reference.obj"), *words]) == 0
    with np.load(tmp_path / "reference.npz", allow_pickle=False) as archive:
        assert set(archive.files) - {"chart_home"} == {name for name, *_ in FLATTENED}


def test_the_files_of_a_morph_are_listed(measured, tmp_path):
    pictures = [str(measured / "flatten" / f"{side}.png") for side in ("reference", "deformed")]
    assert main(["morph", *pictures, "--steps", "2", "-o", str(tmp_path), "--quiet"]) == 0
    header = (tmp_path / "matches.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.split(",") == [name for name, *_ in MATCHES]
    with np.load(tmp_path / "warp_backward.npz", allow_pickle=False) as archive:
        assert set(archive.files) == {name for name, *_ in WARP}
