"""Write the pictures of a synthetic sheet on a turntable with its truth."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from shapemorph.config import TwinConfig
from shapemorph.core.turn_twin import TurnTwin
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.run import Listener

STATES = ("before", "after")
TRUTH, TURN, RIG = "truth.npz", "turn.yaml", "rig.yaml"
STEP, MOST_STEP = 20.0, 45.0  # degrees of the turn between the views of a pair; most, with few
PATCHES = 21
SLANTED = 0.6  # of the diameter of a dot: smaller ones are not looked for


def write_turntable_case(
    config: TwinConfig, folder: Path, *, listener: Listener
) -> tuple[TurnTwin, list[Path]]:
    """Make the experiment and write a folder of pictures for each state.

    Parameters
    ----------
    config : TwinConfig
    folder : Path
        Gets before/ and after/ with frame_*.png, mask_*.png, rig.yaml for the calibration and
        turn.yaml for the reconstruction; cone.csv, landmarks.csv, dots.csv, law.csv, truth.npz.

    Returns
    -------
    TurnTwin
    list of Path

    Raises
    ------
    ConfigError
        If the folder cannot be written.
    StageError
        If the shape of the sheet cannot be found. Nothing is written then.
    """
    from shapemorph.io.target_files import write_target
    from shapemorph.io.turn_twin_files import write_marks, write_radial_law, write_turn_twin
    from shapemorph.stages.turntable import (
        dots_on_diameter,
        landmarks,
        make_turn_twin,
        marks,
        other_law,
    )

    check_writable(folder)
    clock = Clock(listener)
    twin = clock.run("shapes", lambda: make_turn_twin(config))
    with scratch_folder(folder) as scratch:
        write_turn_twin(scratch / TRUTH, twin)
        write_target(scratch / "cone.csv", twin.target)
        write_marks(scratch / "landmarks.csv", *landmarks(twin, config))
        write_marks(scratch / "dots.csv", *marks(twin, dots_on_diameter(twin)))
        write_radial_law(scratch / "law.csv", clock.run("law", lambda: other_law(config)))
        for state, name in enumerate(STATES):
            (scratch / name).mkdir()
            _write_settings(scratch / name, twin, config)
            clock.run(
                f"pictures {name}",
                lambda state=state, name=name: _write_pictures(  # type: ignore[misc]
                    scratch / name, twin, config, state
                ),
            )
        return twin, move_files(scratch, folder)


def _write_pictures(folder: Path, twin: TurnTwin, config: TwinConfig, state: int) -> None:
    from shapemorph.io.images import write_grey_png
    from shapemorph.stages.turntable import turn_pictures

    for frame in turn_pictures(twin, config, state):
        whole = np.ones_like(frame.mask)
        write_grey_png(folder / f"frame_{frame.number:03d}.png", frame.grey, whole)
        write_grey_png(
            folder / f"mask_{frame.number:03d}.png", frame.mask.astype(np.float32), whole
        )


def _write_settings(folder: Path, twin: TurnTwin, config: TwinConfig) -> None:
    """Say what the pictures show, for the calibration and for the reconstruction."""
    from shapemorph.methods.synthetic.stereo_rig import MM_PER_PX
    from shapemorph.methods.synthetic.turntable import LEAN

    dot = 2 * twin.target.dot_radius
    cone = {
        "kind": "points",
        "points": "../cone.csv",
        "dot_diameter": dot,
        "least_px": round(SLANTED * dot / MM_PER_PX * config.scale, 1),
    }
    rig: dict[str, Any] = {
        "cameras": ["cam"],
        "targets": {"cone": cone},
        "views": [{"target": "cone", "pictures": {"cam": "frame_*.png"}}],
        "report": {"figures": False},
    }
    step = min(max(STEP, 360.0 / config.frames), MOST_STEP)
    half = np.sin(np.radians(step / 2)) * np.sin(LEAN)
    turn: dict[str, Any] = {
        "calibration": "calibration/calibration.json",
        "target": "cone",
        "pictures": {"cam": "frame_*.png"},
        "masks": {"cam": "mask_*.png"},
        "angle": round(float(np.degrees(2 * np.arcsin(half))), 2),
        "patches": PATCHES,
        "correlate": {"order": 2},
    }
    for name, content in ((RIG, rig), (TURN, turn)):
        (folder / name).write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
