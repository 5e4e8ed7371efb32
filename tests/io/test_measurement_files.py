import json
import struct
from dataclasses import replace

import numpy as np
import pytest

import shapemorph
from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Facets, Measurement
from shapemorph.io.measurement_files import (
    read_csv,
    read_facets,
    read_vtp,
    write_csv,
    write_glb,
    write_measurement,
    write_vtp,
)
from shapemorph.io.quantities import FACET_ARRAYS, QUANTITIES

COLUMNS = (
    "x_ref_mm,y_ref_mm,z_ref_mm,x_def_mm,y_def_mm,z_def_mm,u_mm,v_mm,w_mm,x_ref_px,y_ref_px,"
    "x_def_px,y_def_px,chart,status,E1,E2,hencky_1,hencky_2,stretch_1,stretch_2,"
    "thickness_strain,anisotropy,zncc,iterations,sigma_displacement_mm,sigma_E1,sigma_E2"
)


@pytest.fixture
def measurement() -> Measurement:
    """Six points in two rows; the last one is lost."""
    rng = np.random.default_rng(17)
    arrays = {
        quantity.name: rng.random(6)
        if quantity.components == 1
        else rng.normal(size=(6, quantity.components)) * 30
        for quantity in QUANTITIES
    }
    for name, values in arrays.items():
        if name not in ("reference_px", "zncc"):
            values[5] = np.nan
    arrays["iterations"] = np.array([3.0, 4, 5, 6, 7, 0])
    arrays["status"] = np.array([0, 0, 0, 0, 0, 6], dtype=np.uint8)
    arrays["chart"] = np.zeros(6, dtype=np.int64)
    return Measurement(rng.normal(size=(6, 3)) * 50, np.array([[0, 1, 4, 3]]), arrays)


def test_vtp_comes_back_bit_for_bit_with_its_field_data(tmp_path, measurement):
    path = tmp_path / "a folder" / "measurement.vtp"
    fields = {"config": '{"strain": {"window": 5}}', "units": "mm"}
    write_vtp(path, measurement, fields)
    found, texts = read_vtp(path)
    np.testing.assert_array_equal(found.reference, measurement.reference)
    np.testing.assert_array_equal(found.cells, measurement.cells)
    assert set(found.arrays) == set(measurement.arrays)
    for name, values in measurement.arrays.items():
        np.testing.assert_array_equal(found.arrays[name], values, err_msg=name)
        assert found.arrays[name].dtype == values.dtype
    assert texts == fields


def test_csv_has_the_columns_of_the_contract_and_nan_where_nothing_is_known(tmp_path, measurement):
    path = tmp_path / "measurement.csv"
    write_csv(path, measurement)
    header, *lines = path.read_text().splitlines()
    assert header.startswith(COLUMNS + ",")  # what is newer stands behind
    assert len(lines) == 6
    assert lines[5].split(",")[13:16] == ["0", "6", "nan"]
    found = read_csv(path)
    np.testing.assert_allclose(found["v_mm"], measurement.arrays["displacement"][:, 1], rtol=1e-9)
    np.testing.assert_allclose(found["z_ref_mm"], measurement.reference[:, 2], rtol=1e-9)
    np.testing.assert_allclose(
        found["sigma_displacement_mm"], measurement.arrays["sigma_displacement"], rtol=1e-9
    )


def parts_of(path) -> tuple[dict, bytes]:
    content = path.read_bytes()
    magic, version, length = struct.unpack("<4sII", content[:12])
    assert (magic, version, length) == (b"glTF", 2, len(content))
    size, kind = struct.unpack("<I4s", content[12:20])
    assert kind == b"JSON"
    document = json.loads(content[20 : 20 + size])
    binary_size, binary_kind = struct.unpack("<I4s", content[20 + size : 28 + size])
    assert binary_kind == b"BIN\0"
    return document, content[28 + size : 28 + size + binary_size]


def values_of(document: dict, binary: bytes, accessor: int) -> np.ndarray:
    described = document["accessors"][accessor]
    view = document["bufferViews"][described["bufferView"]]
    kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[described["componentType"]]
    data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return np.frombuffer(data, kind).reshape(described["count"], -1)


def test_glb_holds_the_deformed_shape_in_metres_with_e1_as_scalar_and_colour(tmp_path, measurement):
    path = tmp_path / "measurement.glb"
    write_glb(path, measurement)
    document, binary = parts_of(path)
    primitive = document["meshes"][0]["primitives"][0]
    used = [0, 1, 3, 4]
    positions = values_of(document, binary, primitive["attributes"]["POSITION"])
    expected = measurement.arrays["deformed_position"][used] / 1000
    np.testing.assert_allclose(positions, expected, rtol=1e-6)
    scalar = values_of(document, binary, primitive["attributes"]["_E1"])[:, 0]
    e1 = measurement.arrays["E1"][used]
    np.testing.assert_allclose(scalar, e1, rtol=1e-6)
    colours = values_of(document, binary, primitive["attributes"]["COLOR_0"])
    lowest = colours[e1.argmin(), :3] / 65535
    encoded = np.where(lowest <= 0.0031308, 12.92 * lowest, 1.055 * lowest ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(encoded, [0.267, 0.005, 0.329], atol=1e-3)  # viridis begins here
    luminance = colours[:, :3] @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_array_equal(np.argsort(luminance), np.argsort(e1))  # a map of lightness
    extras = document["meshes"][0]["extras"]
    assert extras["scalar"] == "_E1"
    assert extras["length_unit"] == "m"
    assert extras["range"] == [e1.min(), e1.max()]
    faces = values_of(document, binary, primitive["indices"]).reshape(-1, 3)
    assert faces.tolist() == [[0, 1, 3], [0, 3, 2]]


def test_other_readers_find_the_scalar_in_the_glb(tmp_path, measurement):
    import trimesh

    path = tmp_path / "measurement.glb"
    write_glb(path, measurement)
    (mesh,) = trimesh.load(path, process=False).geometry.values()
    e1 = measurement.arrays["E1"][[0, 1, 3, 4]]
    np.testing.assert_allclose(np.ravel(mesh.vertex_attributes["_E1"]), e1, rtol=1e-6)


def test_all_files_are_written_with_config_units_and_version(tmp_path, measurement):
    paths = write_measurement(tmp_path, measurement, '{"version": 1}')
    assert [path.name for path in paths] == [
        "measurement.vtp",
        "measurement.csv",
        "measurement.glb",
    ]
    _, texts = read_vtp(tmp_path / "measurement.vtp")
    assert texts == {
        "config": '{"version": 1}',
        "units": "mm",
        "version": shapemorph.__version__,
    }
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(p.name for p in paths)


def test_scattered_points_without_a_cell_have_tables_but_no_surface(tmp_path, measurement):
    alone = Measurement(measurement.reference, np.zeros((0, 4), dtype=np.int64), measurement.arrays)
    assert len(write_measurement(tmp_path, alone, "{}")) == 2
    found, _ = read_vtp(tmp_path / "measurement.vtp")
    assert found.cells.shape == (0, 4)
    assert len(found.reference) == 6
    with pytest.raises(DataError, match="at least one cell"):
        write_glb(tmp_path / "measurement.glb", alone)


def test_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, measurement):
    path = tmp_path / "measurement.csv"
    path.write_text("old")
    del measurement.arrays["sigma_E2"]
    with pytest.raises(KeyError):
        write_csv(path, measurement)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["measurement.csv"]


def test_missing_or_foreign_files_are_refused_in_one_line(tmp_path):
    with pytest.raises(DataError, match="does not exist"):
        read_vtp(tmp_path / "measurement.vtp")
    (tmp_path / "measurement.csv").write_text("a,b\n1,x\n")
    with pytest.raises(DataError, match=r"expected a measurement\.csv"):
        read_csv(tmp_path / "measurement.csv")


def test_arrays_without_a_single_value_read_back_without_a_complaint(tmp_path, measurement, capfd):
    for name in ("E1", "displacement", "direction_1"):
        measurement.arrays[name][:] = np.nan
    path = tmp_path / "measurement.vtp"
    write_vtp(path, measurement, {"units": "mm"})
    header = path.read_bytes()
    assert b'"nan"' not in header
    assert b'"-nan"' not in header
    found, _ = read_vtp(path)  # VTK's complaint would be a warning, and warnings are errors
    assert capfd.readouterr().err == ""
    for name, values in measurement.arrays.items():
        np.testing.assert_array_equal(found.arrays[name], values, err_msg=name)


def test_facets_come_back_bit_for_bit(tmp_path, measurement):
    values = np.random.default_rng(3).random((len(FACET_ARRAYS), 2))
    corners = np.array([[0, 1, 4], [0, 4, 3]])
    facets = Facets(corners, dict(zip(FACET_ARRAYS, values, strict=True)))
    paths = write_measurement(tmp_path, replace(measurement, facets=facets), "{}")
    assert paths[3] == tmp_path / "facets.vtp"
    found = read_facets(paths[3])
    np.testing.assert_array_equal(found.corners, corners)
    for name in FACET_ARRAYS:
        np.testing.assert_array_equal(found.arrays[name], facets.arrays[name])
    with pytest.raises(DataError, match="holds no facets"):
        read_facets(paths[0])
