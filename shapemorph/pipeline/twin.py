"""Write the pictures of a synthetic stereo experiment with its truth."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import yaml
from pydantic import Field

from shapemorph.config import Section, TwinConfig
from shapemorph.core.arrays import Greys
from shapemorph.core.errors import ConfigError
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.run import Listener


class TwinFile(Section):
    """The YAML file of a synthetic stereo experiment."""

    twin: TwinConfig = Field(TwinConfig(), description="the experiment")


def write_twin_case(config: TwinConfig, folder: Path, *, listener: Listener) -> list[Path]:
    """Make the experiment and write pictures, calibration, mask and ``truth.npz``.

    Raises
    ------
    ConfigError
        If the folder cannot be written or holds pictures of another origin.
    StageError
        If the shape of the sheet cannot be found. Nothing is written then.
    """
    from shapemorph.io.images import write_grey_png
    from shapemorph.io.rig_files import write_rig
    from shapemorph.io.twin_files import TRUTH, write_twin
    from shapemorph.stages.twin import (
        calibration_pictures,
        make_twin,
        region_of_first,
        twin_pictures,
    )

    check_writable(folder)
    pictures = sorted(folder.glob("*.png"))
    if pictures and not (folder / TRUTH).is_file():
        raise ConfigError(
            f"output {folder} holds {pictures[0].name} and is no synthetic experiment: choose "
            "another directory with -o"
        )
    clock = Clock(listener)
    twin = clock.run("shapes", lambda: make_twin(config))
    with scratch_folder(folder) as scratch:
        write_twin(scratch / TRUTH, twin)
        write_rig(scratch / "rig.json", twin.rig)
        mask = region_of_first(twin)
        write_grey_png(scratch / "mask_left.png", mask.astype(np.float32), np.ones_like(mask))
        clock.run("pictures", lambda: _write_all(scratch, twin_pictures(twin, config)))
        if config.views:
            plates = scratch / "calibration"
            plates.mkdir()
            clock.run("calibration", lambda: _write_all(plates, calibration_pictures(twin, config)))
            _write_rig(plates, twin.rig.names)
        return move_files(scratch, folder)


def _write_all(folder: Path, pictures: Iterable[tuple[str, int, Greys]]) -> None:
    from shapemorph.io.images import write_grey_png

    for camera, number, grey in pictures:
        whole = np.ones(grey.shape, dtype=np.bool_)
        write_grey_png(folder / f"{camera}_{number:02d}.png", grey, whole)


def _write_rig(folder: Path, cameras: tuple[str, ...]) -> None:
    """Say what the plates show, for the calibration."""
    from shapemorph.stages.twin import PLATE

    plate = {
        "kind": "dots",
        "columns": PLATE.columns,
        "rows": PLATE.rows,
        "spacing": PLATE.spacing,
        "dot_diameter": PLATE.diameter,
    }
    views = {"target": "plate", "pictures": {name: f"{name}_*.png" for name in cameras}}
    content = {"cameras": list(cameras), "targets": {"plate": plate}, "views": [views]}
    (folder / "rig.yaml").write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
