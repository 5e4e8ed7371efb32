"""VTK's XML files, written through VTK itself: pyvista takes half a second to load.

They are packed with LZ4: zlib takes ten times as long.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.safe_files import whole_file
from shapemorph.io.vtk_ranges import drop_nan_ranges

Arrays = Mapping[str, np.ndarray]
Fields = Mapping[str, str | float]


def write_image_data(
    path: Path, shape: tuple[int, int], spacing: float, arrays: Arrays, fields: Fields
) -> None:
    """Write a picture as VTI.

    Parameters
    ----------
    path : Path
    shape : (rows, columns)
    spacing : float
        Of pixels; the first row lies at y = 0, the first column at x = 0.
    arrays : mapping
        Name to values (rows, columns), first row first.
    fields : mapping
        Name to text or number: field data.
    """
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    image = vtkImageData()
    image.SetDimensions(shape[1], shape[0], 1)
    image.SetSpacing(spacing, spacing, spacing)
    for name, values in arrays.items():
        image.GetPointData().AddArray(_array(name, values.ravel()))
    _add_fields(image, fields)
    writer = vtkXMLImageDataWriter()
    writer.SetCompressorTypeToLZ4()
    writer.EncodeAppendedDataOff()  # as text it takes six times as long and a third more room
    with whole_file(path) as partial:
        _write(writer, image, partial)


def write_surface(
    path: Path,
    points: Floats,
    cells: Ints,
    arrays: Arrays,
    fields: Fields,
    *,
    of_cells: bool = False,
) -> None:
    """Write points (N, 3), cells (M, corners), arrays of either, and field data as VTP.

    Without cells every point is a cell of its own.
    """
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    surface = vtkPolyData()
    places = vtkPoints()
    places.SetData(_array("Points", points))
    surface.SetPoints(places)
    if len(cells):
        surface.SetPolys(_cells(cells))
    else:
        surface.SetVerts(_cells(np.arange(len(points))[:, None]))
    target = surface.GetCellData() if of_cells else surface.GetPointData()
    for name, values in arrays.items():
        target.AddArray(_array(name, values))
    _add_fields(surface, fields)
    writer = vtkXMLPolyDataWriter()
    writer.SetCompressorTypeToLZ4()
    with whole_file(path) as partial:
        _write(writer, surface, partial)
        drop_nan_ranges(partial)


def _array(name: str, values: np.ndarray) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(values))
    array.SetName(name)
    return array


def _cells(corners: Ints) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    indices = np.ascontiguousarray(corners.ravel(), dtype=np.int64)
    cells.SetData(corners.shape[1], numpy_to_vtkIdTypeArray(indices))
    return cells


def _add_fields(data: Any, fields: Fields) -> None:
    from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkStringArray

    for name, value in fields.items():
        array: Any = vtkStringArray() if isinstance(value, str) else vtkDoubleArray()
        array.SetName(name)
        array.InsertNextValue(value)
        data.GetFieldData().AddArray(array)


def _write(writer: Any, data: Any, path: Path) -> None:
    """Write a file.

    Raises
    ------
    DataError
        If VTK could not write.
    """
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    if not writer.Write():
        raise DataError(f"VTK could not write {path}: is the disk full?")
