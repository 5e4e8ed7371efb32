"""Measurements for other programs: NPZ for Python, MAT for MATLAB and Octave."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from shapemorph.core.errors import ConfigError
from shapemorph.core.measurement import Measurement
from shapemorph.io.quantities import REFERENCE
from shapemorph.io.safe_files import whole_file

Arrays = dict[str, np.ndarray[Any, np.dtype[Any]]]


def write_export(
    stem: Path, measurement: Measurement, fields: Mapping[str, str], file_format: str
) -> Path:
    """Write every array of a measurement under its name in ``measurement.vtp``.

    Parameters
    ----------
    stem : Path
        Path without suffix.
    measurement : Measurement
    fields : mapping of str to str
        Texts beside the arrays: units, version, configuration.
    file_format : str
        "npz" or "mat".

    Returns
    -------
    Path
        What was written: whole or not there.

    Raises
    ------
    ConfigError
        If there is no such format.
    """
    if file_format not in FORMATS:
        raise ConfigError(f"expected a format ({', '.join(FORMATS)}), got {file_format!r}")
    path = stem.with_name(f"{stem.name}.{file_format}")
    with whole_file(path) as partial, partial.open("wb") as stream:
        FORMATS[file_format](stream, exported_arrays(measurement), fields)
    return path


def exported_arrays(measurement: Measurement) -> Arrays:
    """Points, cells (row numbers from 0), all point arrays and those of the facets, by name."""
    arrays = {
        REFERENCE.name: measurement.reference,
        "cells": measurement.cells,
        **measurement.arrays,
    }
    if measurement.facets is not None:
        arrays["facets"] = measurement.facets.corners
        arrays |= {f"facet_{k}": values for k, values in measurement.facets.arrays.items()}
    return arrays


def _write_npz(stream: BinaryIO, arrays: Arrays, fields: Mapping[str, str]) -> None:
    texts = {name: np.array(text) for name, text in fields.items()}
    np.savez(stream, **arrays, **texts)  # type: ignore[arg-type]


def _write_mat(stream: BinaryIO, arrays: Arrays, fields: Mapping[str, str]) -> None:
    from scipy.io import savemat

    savemat(stream, {**arrays, **fields}, do_compression=True, oned_as="column")  # type: ignore[arg-type]


FORMATS: dict[str, Callable[[BinaryIO, Arrays, Mapping[str, str]], None]] = {
    "npz": _write_npz,
    "mat": _write_mat,
}
"""Writers by format."""
