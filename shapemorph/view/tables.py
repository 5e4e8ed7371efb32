"""A summary as tables that people read: labels with units, numbers with sense."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

_UNITS = {
    "_mm2": "mm²",
    "_px_per_mm": "px/mm",
    "_mm": "mm",
    "_px": "px",
    "_mb": "MB",
    "_seconds": "s",
}
_SPREAD = ("p1", "p5", "median", "p95", "p99", "max")
_LONG = 12


@dataclass(frozen=True, slots=True)
class Cell:
    """A value as people read it, and where it comes from.

    Attributes
    ----------
    text : str
    path : str
        Keys of the summary (in lists: places, from 0) that lead to the value, joined by
        slashes; empty: no value.
    exact : str
        The value in full, as JSON.
    """

    text: str
    path: str = ""
    exact: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text.

    Attributes
    ----------
    title : str
    columns : tuple of str
        Headings of the value columns; empty where there is one without a heading.
    rows : tuple of (str, tuple of Cell)
        Label and values.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]


def section_table(name: str, title: str, section: Any) -> Table:
    """Lay out one section of a summary.

    A section that consists of a reference and a deformed part becomes two columns;
    anything beside them follows in rows of its own.
    """
    if not isinstance(section, Mapping) or _is_spread(section):
        return Table(title, (), ((label_of(name), (cell(name, section, name),)),))
    sides = [name for name in ("reference", "deformed") if isinstance(section.get(name), Mapping)]
    if len(sides) < 2:
        return Table(title, (), tuple((label, (one,)) for label, one in _rows(section, name)))
    columns = [dict(_rows(section[side], f"{name}/{side}")) for side in sides]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    rows = [(label, tuple(column.get(label, Cell("")) for column in columns)) for label in labels]
    rest = {key: value for key, value in section.items() if key not in sides}
    rows += [(label, (one, Cell(""))) for label, one in _rows(rest, name)]
    return Table(title, tuple(sides), tuple(rows))


def cell(key: str, value: Any, path: str) -> Cell:
    """Write a value, and keep it in full."""
    return Cell(text_of(key, value), path, json.dumps(value, ensure_ascii=False))


def _rows(section: Mapping[str, Any], path: str, prefix: str = "") -> list[tuple[str, Cell]]:
    """Flatten a nested section into labels and cells."""
    rows: list[tuple[str, Cell]] = []
    for key, value in section.items():
        here = f"{path}/{key}"
        part = f"{prefix}{key.replace('_', ' ')}: "
        if isinstance(value, Mapping) and not _is_spread(value):
            rows += _rows(value, here, part)
        elif _are_parts(value):
            for number, member in enumerate(value):
                name = member.get("name", number + 1)
                rows += _rows(member, f"{here}/{number}", f"{part}{name}: ")
        else:
            rows.append((prefix + label_of(key), cell(key, value, here)))
    return rows


def _are_parts(value: Any) -> bool:
    """Whether a value is a list of sections."""
    return isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)


def label_of(key: str) -> str:
    """Make words of a key, with the unit that its ending names; codes stay as they are."""
    if key.isupper():
        return key
    for ending, unit in _UNITS.items():
        if key == ending[1:]:
            return unit
        if key.endswith(ending) and not key.endswith(f"_per{ending}"):
            return f"{key.removesuffix(ending).replace('_', ' ')}, {unit}"
    return key.replace("_", " ")


def text_of(key: str, value: Any) -> str:
    """Write a value as people read it; a dash where there is none."""
    if value is None or value == "" or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return _number(key, value)
    if isinstance(value, Mapping):
        return _spread_text(key, value) if _is_spread(value) else str(dict(value))
    if isinstance(value, Sequence) and not isinstance(value, str):
        return _list_text(key, value)
    return str(value)


def _number(key: str, value: float) -> str:
    """Shares in percent, whole numbers whole, the rest with four figures."""
    if "share" in key and 0 <= value <= 1:
        return f"{100 * value:.4g} %"
    if isinstance(value, int) or (value.is_integer() and abs(value) < 1e6):
        return f"{int(value)}"
    return f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def _is_spread(value: Mapping[str, Any]) -> bool:
    """Whether a mapping holds percentiles of something."""
    return "median" in value and set(value) <= set(_SPREAD)


def _spread_text(key: str, value: Mapping[str, Any]) -> str:
    """Median first, then the percentiles."""
    names = {"p1": "1 %", "p5": "5 %", "p95": "95 %", "p99": "99 %", "max": "max"}
    parts = [f"{names[name]}: {text_of(key, value[name])}" for name in names if name in value]
    return f"median {text_of(key, value['median'])}  ({', '.join(parts)})"


def _list_text(key: str, values: Sequence[Any]) -> str:
    """Write a short list in full, a long one with its ends; rows and sentences apart."""
    apart = any(isinstance(value, Sequence) and " " in text_of(key, value) for value in values)
    texts = [text_of(key, value) for value in values]
    if len(texts) > _LONG:
        texts = [*texts[: _LONG // 2], f"… ({len(texts)} in all) …", *texts[-2:]]
    return ("; " if apart else ", ").join(texts) or "none"
