"""Look at everything that a run would read, without running it."""

from dataclasses import asdict
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.pipeline.inputs import Inputs


def check_inputs(config: RunConfig) -> dict[str, Any]:
    """Read meshes, landmarks and regions and say what was found.

    Returns
    -------
    dict
        JSON-able: mesh reports, sizes in mm, names of landmarks.

    Raises
    ------
    ConfigError, DataError
        As the run would.
    """
    inputs = Inputs(config)
    files = inputs.files()
    inputs.check_beside_meshes()
    reports = inputs.load("reports")
    landmarks = inputs.load("landmarks")
    return {
        "files": [str(path) for path in files],
        "inputs": asdict(reports),
        "landmarks": [] if landmarks is None else list(landmarks.names),
    }
