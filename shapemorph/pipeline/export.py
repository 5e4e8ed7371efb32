"""A finished measurement in the formats of other programs."""

from dataclasses import replace
from pathlib import Path

from shapemorph.core.errors import DataError


def export(run: Path, file_format: str) -> Path:
    """Write RUN/measurement.npz or RUN/measurement.mat from RUN/measurement.vtp.

    Parameters
    ----------
    run : Path
        Folder of a finished run.
    file_format : str
        "npz" or "mat".

    Raises
    ------
    ConfigError
        If there is no such format.
    DataError
        If the run holds no measurement.
    """
    from shapemorph.io.exports import write_export
    from shapemorph.io.measurement_files import FACETS, read_facets, read_vtp

    field = run / "measurement.vtp"
    if not field.is_file():
        raise DataError(f"expected a finished run in {run}, found no {field.name}: run measure")
    measurement, fields = read_vtp(field)
    if (run / FACETS).is_file():
        measurement = replace(measurement, facets=read_facets(run / FACETS))
    return write_export(run / "measurement", measurement, fields, file_format)
