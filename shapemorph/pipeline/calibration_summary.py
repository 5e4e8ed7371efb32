"""The figures of a calibration: what `summary.json` holds, and the verdict."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.calibration import Calibration
from shapemorph.core.camera import Rig
from shapemorph.io.rig_files import lens_fields
from shapemorph.methods.cameras.quality import (
    Drift,
    baseline_sigma,
    control_points,
    drift_since,
    residual_pattern,
)
from shapemorph.pipeline.verdict import FAIL, WARN

GOOD_RMS, SUSPICIOUS_RMS, USELESS_RMS = 0.1, 0.3, 2.0  # px
FEW_VIEWS = 5  # of a flat target
LOW_COVERAGE = 0.4
SYSTEMATIC = 0.5  # of the rms of a camera
MANY_REJECTED = 0.25
DRIFTED = 0.1  # px


def calibration_figures(found: Calibration, before: Rig | None) -> dict[str, Any]:
    """Collect rms, coverage, standard deviations, control points and drift; and judge them."""
    rig = found.rig
    drift = None if before is None else drift_since(found, before)
    sections: dict[str, Any] = {
        "rms_px": found.rms(),
        "cameras": {name: _camera(found, number) for number, name in enumerate(rig.names)},
        "pairs": [_pair(found, 0, number) for number in range(1, len(rig.cameras))],
        "control_points": [asdict(one) for one in control_points(found)],
        "views": [_view(found, number) for number in range(len(found.views))],
        "rejected": [{"what": what, "reason": reason} for what, reason in found.rejected],
        "dropped_points": found.dropped_points,
        "drift": None if drift is None else asdict(drift),
    }
    return {"verdict": judge_calibration(sections, found, drift), **sections}


def _camera(found: Calibration, number: int) -> dict[str, Any]:
    camera, sigma = found.rig.cameras[number], found.uncertainty[number]
    pattern = residual_pattern(found, number)
    mine = [seen for seen in found.sightings if seen.camera == number]
    return {
        "size_px": list(camera.size),
        **lens_fields(camera),
        "sigma": lens_fields(sigma),
        "rms_px": found.rms(camera=number),
        "views": len(mine),
        "points": sum(len(seen.ids) for seen in mine),
        "coverage": pattern.coverage,
        "systematic_px": pattern.systematic_px,
    }


def _pair(found: Calibration, first: int, second: int) -> dict[str, Any]:
    rig, sigma = found.rig, found.uncertainty[second]
    motion = rig.between(first, second)
    shared = [seen for seen in found.sightings if seen.camera in (first, second)]
    views = [seen.view for seen in shared]
    both = {view for view in views if views.count(view) == 2}
    squares = [
        (rest**2).sum(axis=1)
        for seen, rest in zip(found.sightings, found.residuals, strict=True)
        if seen.camera in (first, second) and seen.view in both
    ]
    return {
        "first": rig.names[first],
        "second": rig.names[second],
        "rotation": motion.rotation.tolist(),
        "translation_mm": motion.translation.tolist(),
        "sigma_rotation_rad": sigma.rotation.tolist(),
        "sigma_translation_mm": sigma.translation.tolist(),
        "baseline_mm": rig.baseline(first, second),
        "sigma_baseline_mm": baseline_sigma(found, second),
        "stereo_angle_deg": float(np.degrees(rig.stereo_angle(first, second))),
        "common_views": len(both),
        "rms_px": float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else None,
    }


def _view(found: Calibration, number: int) -> dict[str, Any]:
    seen = [one for one in found.sightings if one.view == number]
    return {
        "view": found.views[number].name,
        "target": found.views[number].target.name,
        "points": sum(len(one.ids) for one in seen),
        "rms_px": found.rms(view=number),
        "cameras": {
            found.rig.names[one.camera]: found.rms(camera=one.camera, view=number) for one in seen
        },
    }


def judge_calibration(
    sections: dict[str, Any], found: Calibration, drift: Drift | None
) -> dict[str, Any]:
    """Judge a calibration: PASS, WARN or FAIL, with reasons."""
    reasons: list[tuple[str, str]] = []
    for name, camera in sections["cameras"].items():
        reasons += _doubts_of(name, camera, found)
    rejected = {entry["what"] for entry in sections["rejected"]}
    total = len(rejected) + len(found.sightings)
    if len(rejected) > MANY_REJECTED * total:
        reasons.append((WARN, f"{len(rejected)} of {total} pictures were put aside"))
    if drift is not None and drift.epipolar_px > DRIFTED + sections["rms_px"]:
        reasons.append(
            (
                WARN,
                f"the rig has moved since the earlier calibration: with it points lie "
                f"{drift.epipolar_px:.2g} px off, shapes {drift.shape_mm:.2g} mm",
            )
        )
    levels = {level for level, _ in reasons}
    level = FAIL if FAIL in levels else WARN if WARN in levels else "PASS"
    return {"level": level, "reasons": [f"{level}: {text}" for level, text in reasons]}


def _doubts_of(name: str, camera: dict[str, Any], found: Calibration) -> list[tuple[str, str]]:
    doubts = []
    rms = camera["rms_px"]
    if rms > SUSPICIOUS_RMS:
        level = FAIL if rms > USELESS_RMS else WARN
        doubts.append((level, f"{name}: points lie {rms:.2g} px rms off; {GOOD_RMS} px is good"))
    if camera["coverage"] < LOW_COVERAGE:
        doubts.append(
            (WARN, f"{name}: the target was shown in {camera['coverage']:.0%} of the picture only")
        )
    if camera["systematic_px"] > max(SYSTEMATIC * rms, GOOD_RMS):
        doubts.append(
            (
                WARN,
                f"{name}: residuals show a pattern of {camera['systematic_px']:.2g} px: the lens "
                "or the target is not as described",
            )
        )
    if camera["views"] < FEW_VIEWS and all(view.target.is_flat for view in found.views):
        doubts.append((WARN, f"{name}: {camera['views']} pictures of a flat target are few"))
    return doubts


def write_residuals(path: Path, found: Calibration) -> None:
    """Write a row for each point that was seen: where, and how far from where it should be."""
    lines = ["camera,view,point,x_px,y_px,dx_px,dy_px"]
    for seen, rest in zip(found.sightings, found.residuals, strict=True):
        camera, view = found.rig.names[seen.camera], found.views[seen.view].name
        table = zip(seen.ids.tolist(), seen.pixels.tolist(), rest.tolist(), strict=True)
        lines += [
            f"{camera},{view},{point},{x:.4f},{y:.4f},{dx:.5f},{dy:.5f}"
            for point, (x, y), (dx, dy) in table
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
