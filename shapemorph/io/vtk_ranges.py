"""Ranges in the headers of VTK's XML files that no reader could parse."""

import re
from pathlib import Path

_NOT_A_NUMBER = rb"[-+]?nan(?:\([^)]*\))?"
_NORM_RANGE = re.compile(rb'\s*<InformationKey name="L2_NORM_RANGE".*?</InformationKey>', re.DOTALL)
_RANGE = re.compile(rb' Range(?:Min|Max)="' + _NOT_A_NUMBER + rb'"', re.IGNORECASE)
_NAN = re.compile(rb">\s*" + _NOT_A_NUMBER + rb"\s*<", re.IGNORECASE)


def drop_nan_ranges(path: Path) -> None:
    """Take ranges that are no numbers out of the header of a VTK XML file.

    VTK writes the range of an array of vectors that are all NaN as ``-nan`` and complains
    when it reads that back; without it, readers find the range by themselves.
    """
    content = path.read_bytes()
    header, *appended = content.partition(b"<AppendedData")
    sound = _NORM_RANGE.sub(lambda key: b"" if _NAN.search(key[0]) else key[0], header)
    sound = _RANGE.sub(b"", sound)
    if sound != header:
        path.write_bytes(b"".join([sound, *appended]))
