"""The noise floor that `shapemorph noise` has written."""

import json
from pathlib import Path
from typing import Any

from shapemorph.core.errors import DataError

NOISE_FILE = "noise.json"
QUANTITIES = ("u", "v", "w", "E1", "E2")


def read_noise(path: Path) -> dict[str, dict[str, float]]:
    """Read mean and standard deviation of u, v, w (mm), E1, E2 from noise.json.

    Raises
    ------
    DataError
        If the file is not there or holds something else.
    """
    try:
        found: Any = json.loads(path.read_text(encoding="utf-8"))
        return {
            name: {part: float(found["figures"][name][part]) for part in ("mean", "std")}
            for name in QUANTITIES
        }
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, LookupError, TypeError) as error:
        raise DataError(
            f"{path} holds no noise floor: expected the {NOISE_FILE} that `shapemorph noise` writes"
        ) from error
