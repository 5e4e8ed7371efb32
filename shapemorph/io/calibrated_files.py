"""Calibrated images as VTI files (for ParaView and scripts) and as pictures."""

from pathlib import Path

import numpy as np

from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.io.images import write_grey_png
from shapemorph.io.vtk_files import write_image_data
from shapemorph.methods.charts.mosaic import take_page
from shapemorph.methods.surface_lookup import pixel_positions


def write_pages(stem: Path, mesh: TexturedMesh, image: CalibratedImage) -> None:
    """Write a calibrated image, or each of its pages: ``stem_0.vti``, ``stem_0.png``, ...

    Parameters
    ----------
    stem : Path
        Path without suffix; its folder must exist.
    mesh : TexturedMesh
    image : CalibratedImage
        Of that mesh.
    """
    if image.chart.page_count == 1:
        write_calibrated(stem, mesh, image)
        return
    for number in range(image.chart.page_count):
        write_calibrated(stem.with_name(f"{stem.name}_{number}"), mesh, take_page(image, number))


def write_calibrated(stem: Path, mesh: TexturedMesh, image: CalibratedImage) -> None:
    """Write ``stem.vti`` and ``stem.png``.

    The VTI has its first row at the bottom, spacing and origin in mm (the lower left
    pixel is the origin), and point arrays `gray` (0 to 1), `X`, `Y`, `Z` (mm, in the
    frame of the mesh) and `face` (of the mesh). Outside the mask they are NaN, and -1 for
    `face`. The picture has row 0 on top, 8 bits, and is transparent outside the mask.

    Parameters
    ----------
    stem : Path
        Path without suffix; its folder must exist.
    mesh : TexturedMesh
    image : CalibratedImage
        Of that mesh.
    """
    _write_vti(stem.with_name(f"{stem.name}.vti"), mesh, image)
    write_grey_png(stem.with_name(f"{stem.name}.png"), image.image.grey, image.image.mask)


def _write_vti(path: Path, mesh: TexturedMesh, image: CalibratedImage) -> None:
    mask = image.image.mask
    places = pixel_positions(mesh, image)
    face = np.where(mask, image.chart.face_ids[image.triangle], -1).astype(np.int32)
    arrays = {
        "gray": np.where(mask, image.image.grey, np.float32(np.nan)),
        "X": places[..., 0],
        "Y": places[..., 1],
        "Z": places[..., 2],
        "face": face,
    }
    write_image_data(
        path,
        image.image.shape,
        1.0 / image.chart.px_per_mm,
        {name: values[::-1] for name, values in arrays.items()},
        {"px_per_mm": image.chart.px_per_mm, "length_unit": "mm"},
    )
