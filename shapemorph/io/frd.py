"""CalculiX result files: nodes and the displacements of the last step, text form."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.io.images import read_bytes

_WIDTH = 12  # of a number
_LABEL = {"0": 5, "1": 10}  # width of a node number in the short and the long form

Values = dict[int, list[float]]


def read_frd(path: Path) -> tuple[Floats, Floats]:
    """Read nodes (N, 3) and their displacements (N, 3), in the unit of the file.

    Raises
    ------
    DataError
        If it is missing, binary or holds no displacements (``*NODE FILE`` with ``U``).
    """
    lines = read_bytes(path, what="result").decode("ascii", "replace").splitlines()
    nodes: Values = {}
    moved: Values = {}
    width = _LABEL["1"]
    walk = iter(lines)
    for line in walk:
        if line[:6].strip() == "2C":
            width = _label_width(path, line)
            nodes = _values(path, walk, width)
        elif line[:5].split() == ["-4"] and line.split()[1:2] == ["DISP"]:
            moved = _values(path, walk, width)
        elif line[:6].strip() == "100C":
            width = _label_width(path, line)
    if not nodes or not moved:
        raise DataError(
            f"{path.name}: expected nodes and displacements (DISP), got {len(nodes)} nodes and "
            f"{len(moved)} displacements: ask CalculiX for *NODE FILE, U"
        )
    both = sorted(nodes.keys() & moved.keys())
    return (
        np.array([nodes[label][:3] for label in both]),
        np.array([moved[label][:3] for label in both]),
    )


def _label_width(path: Path, line: str) -> int:
    form = line.rstrip()[-1:]
    if form not in _LABEL:
        raise DataError(
            f"{path.name}: expected a text file of form 0 or 1, got form {form!r} (binary?): write "
            "it as text"
        )
    return _LABEL[form]


def _values(path: Path, lines: Iterator[str], width: int) -> Values:
    """Numbers of the nodes up to the end of a block."""
    found: Values = {}
    for line in lines:
        if line[:3] == " -3":
            return found
        if line[:3] != " -1":
            continue
        start = 3 + width
        cells = [line[k : k + _WIDTH] for k in range(start, start + 3 * _WIDTH, _WIDTH)]
        try:
            found[int(line[3:start])] = [float(cell) for cell in cells]
        except ValueError:
            raise DataError(f"{path.name}: expected a node and 3 numbers in {line!r}") from None
    return found
