"""One surface over time: a file for each state and a PVD that names them."""

from pathlib import Path
from xml.etree import ElementTree as ET

import shapemorph
from shapemorph.core.measurement import Measurement
from shapemorph.io.measurement_files import write_vtp
from shapemorph.io.safe_files import whole_file

FRAMES = "frames"


def add_to_series(path: Path, measurement: Measurement, time: float) -> Path:
    """Write a state beside a PVD file, and enter it there; the file is made where it is missing.

    Parameters
    ----------
    path : Path
        Of the PVD file; surfaces go into a folder `frames` beside it.
    measurement : Measurement
        Points lie at their reference positions, the same rows in every state.
    time : float

    Returns
    -------
    Path
        Of the surface.
    """
    root = ET.parse(path).getroot() if path.is_file() else _empty()
    entries = root[0]
    folder = path.parent / FRAMES
    folder.mkdir(parents=True, exist_ok=True)
    surface = folder / f"state_{len(entries) + 1:03d}.vtp"
    fields = {"units": "mm", "version": shapemorph.__version__}
    write_vtp(surface, measurement, fields)
    name = surface.relative_to(path.parent).as_posix()
    ET.SubElement(entries, "DataSet", timestep=f"{time:g}", group="", part="0", file=name)
    ET.indent(root)
    with whole_file(path) as partial:
        ET.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)
    return surface


def _empty() -> ET.Element:
    root = ET.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    ET.SubElement(root, "Collection")
    return root
