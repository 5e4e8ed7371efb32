"""What the interactive view of the report shows, packed small: numbers in one text."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.methods.colour_maps import DIVERGING, SEQUENTIAL, colour_table
from shapemorph.methods.thinning import thinned_quads
from shapemorph.view.camera import outer_view, second_view
from shapemorph.view.measures import FURTHER_MEASURES, Measure, measure_values, measures_in
from shapemorph.view.style import BARE, STATUS_COLOURS, STATUS_WORDS, colour_scale

MOST_QUADS = 40_000
"""More are joined into larger ones."""
MOST_LOST = 10_000
"""Points without a value that are shown."""
TILT = 0.75
"""Angle from the mean normal at which the view starts, radians."""


@dataclass(frozen=True, slots=True, eq=False)
class ViewerData:
    """The measured surface for the page.

    Attributes
    ----------
    about : dict
        JSON-able: fields with names, units and ranges, colours, first view, and where each
        array lies in `content`.
    content : str
        Arrays one after the other, little-endian, as base64.
    """

    about: dict[str, Any]
    content: str


@lru_cache(maxsize=1)
def viewer_data(measurement: Measurement) -> ViewerData | None:
    """Pack the surface between good points, and points that were lost.

    Numbers are 32-bit floats. A large surface gets larger quads where it is whole; all
    points that are left keep their own values. What was packed last is kept.

    Returns
    -------
    ViewerData or None
        None where there is no quad to show.
    """
    if not len(measurement.cells):
        return None
    quads = thinned_quads(measurement.cells, _apart(measurement), most=MOST_QUADS)
    used, corners = np.unique(quads, return_inverse=True)
    rows = np.concatenate([used, _lost_rows(measurement)])
    measures = [
        *measures_in(measurement),
        *(m for m in FURTHER_MEASURES if m.key in measurement.arrays),
    ]
    scalars = {m.key: measurement.arrays[m.key] for m in measures if _is_stored(measurement, m)}
    arrays = {
        "row": rows,
        "quads": corners.reshape(-1, 4),
        "reference": measurement.reference[rows],
        "displacement": measurement.arrays["displacement"][rows],
        **{f"value {key}": values[rows] for key, values in scalars.items()},
        "status": measurement.arrays["status"][rows],
    }
    places, content = _packed(arrays)
    about = {
        "shown": len(used),
        "points": len(measurement.reference),
        "is_thinned": len(quads) < len(measurement.cells),
        "arrays": places,
        "fields": [_field(measurement, measure) for measure in measures],
        "maps": {name: colour_table(name).ravel().tolist() for name in (SEQUENTIAL, DIVERGING)},
        "statuses": [_status(code, measurement.arrays["status"][rows]) for code in PointStatus],
        "bare": BARE,
        "view": _first_view(measurement, used, corners.reshape(-1, 4)),
    }
    return ViewerData(about, base64.b64encode(content).decode("ascii"))


def _apart(measurement: Measurement) -> Floats:
    """Places of the points in the reference picture (N, 2), those of its charts side by side."""
    places = measurement.arrays["reference_px"]
    chart = measurement.arrays["chart"][:, None]
    return np.asarray(places + chart * [np.ceil(places[:, 0].max()) + 1, 0], dtype=np.float64)


def _lost_rows(measurement: Measurement) -> Ints:
    """Rows of points without a value, evenly chosen where there are many."""
    status = measurement.arrays["status"]
    lost = np.flatnonzero((status != PointStatus.OK) & (status != PointStatus.OUTSIDE_MASK))
    return lost[:: max(1, -(-len(lost) // MOST_LOST))]


def _is_stored(measurement: Measurement, measure: Measure) -> bool:
    """Whether a measure has an array of its own; the page works the others out."""
    return measure.key in measurement.arrays and measurement.arrays[measure.key].ndim == 1


def _field(measurement: Measurement, measure: Measure) -> dict[str, Any]:
    """Describe a measure and its colours, which are those of its picture."""
    scale = colour_scale(measure_values(measurement, measure))
    return {
        "key": measure.key,
        "symbol": measure.symbol,
        "name": measure.name,
        "unit": "" if measure.unit == "–" else measure.unit,
        "note": measure.note,
        "map": scale.name,
        "range": [scale.low, scale.high],
    }


def _status(code: PointStatus, statuses: Floats) -> dict[str, Any]:
    """Name and colour of a status, and whether any of the points shown has it."""
    return {
        "word": STATUS_WORDS[code],
        "name": code.name,
        "colour": STATUS_COLOURS[code],
        "occurs": bool((statuses == code).any()),
    }


def _first_view(measurement: Measurement, used: Ints, corners: Ints) -> list[list[float]]:
    """Rows right, up and toward the viewer of the first view."""
    points = (measurement.reference + measurement.arrays["displacement"])[used]
    view = second_view(outer_view(points, corners), points, TILT)
    return [view.right.tolist(), view.up.tolist(), view.toward.tolist()]


def _packed(arrays: Mapping[str, NDArray[Any] | Floats]) -> tuple[dict[str, Any], bytes]:
    """Lay arrays one after the other, each at a multiple of four bytes.

    Returns
    -------
    places : dict
        Offset in bytes, number of values, and kind (f4, u4, u1) by name.
    content : bytes
    """
    places, parts, offset = {}, [], 0
    for name, values in arrays.items():
        kind = {"row": "u4", "quads": "u4", "status": "u1"}.get(name, "f4")
        data = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        places[name] = {"offset": offset, "count": int(values.size), "kind": kind}
        data += b"\0" * (-len(data) % 4)
        parts.append(data)
        offset += len(data)
    return places, b"".join(parts)
