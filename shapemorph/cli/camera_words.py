"""Calibrations and reconstructions as a few lines of text."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from shapemorph.cli.words import describe_verdict

MOST_REJECTED = 8


def describe_calibration(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what a calibration found."""
    for name, camera in summary["cameras"].items():
        sigma = camera["sigma"]
        yield (
            f"{name:11s} f {camera['fx']:.2f}, {camera['fy']:.2f} px (1 sigma {sigma['fx']:.2g}), "
            f"centre {camera['cx']:.2f}, {camera['cy']:.2f} px ({sigma['cx']:.2g}), "
            f"k1 {camera['k1']:.4g} ({sigma['k1']:.1g})"
        )
        yield (
            f"{'':11s} rms {camera['rms_px']:.3g} px over {camera['points']} points in "
            f"{camera['views']} pictures, {camera['coverage']:.0%} of the picture"
        )
    for pair in summary["pairs"]:
        yield (
            f"{pair['second']:11s} {pair['baseline_mm']:.4f} mm from {pair['first']} (1 sigma "
            f"{pair['sigma_baseline_mm']:.2g}), {pair['stereo_angle_deg']:.3f} degrees apart, "
            f"{pair['common_views']} common views"
        )
    for control in summary["control_points"]:
        yield (
            f"points      of {control['target']} in space: {control['mean_mm']:.4g} mm off in the "
            f"mean, at most {control['max_mm']:.3g} mm ({control['points']} points)"
        )
    yield from _rejected(summary)
    drift = summary["drift"]
    if drift is not None:
        yield (
            f"drift       points lie {drift['epipolar_px']:.3g} px off with the earlier "
            f"calibration, shapes {drift['shape_mm']:.3g} mm, size {drift['scale']:+.2e}"
        )
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def _rejected(summary: dict[str, Any]) -> Iterator[str]:
    rejected = summary["rejected"]
    for entry in rejected[:MOST_REJECTED]:
        yield f"put aside   {entry['what']}: {entry['reason']}"
    if len(rejected) > MOST_REJECTED:
        yield f"            and {len(rejected) - MOST_REJECTED} more, see summary.json"
    if summary["dropped_points"]:
        yield f"put aside   {summary['dropped_points']} single points"


def describe_reconstruction(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what a reconstruction found."""
    points, found, rig = summary["points"], summary["reconstruct"], summary["rig"]
    yield f"points      {points['ok']} of {points['total']} ({points['ok_share']:.1%})"
    yield (
        f"cameras     {rig['baseline_mm']:.3f} mm and {rig['stereo_angle_deg']:.2f} degrees apart; "
        f"{found['distance_mm']['median']:.4g} mm from {rig['names'][0]}"
    )
    sigma = found["sigma_mm"]
    yield (
        f"sigma       x {sigma['x']['median']:.2g}, y {sigma['y']['median']:.2g}, "
        f"z {sigma['z']['median']:.2g} mm (median of the random part)"
    )
    yield f"epipolar    {found['epipolar_px']['rms']:.3g} px rms"
    if found["smoothed_px"] is not None:
        yield f"smoothed    by {found['smoothed_px']:.3g} px rms"
    mesh = summary["mesh"]
    yield f"mesh        {mesh['vertices']} vertices, {mesh['faces']} triangles"
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def describe_turn(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what a reconstruction from many views found."""
    rows = summary["patches"]
    for row in rows:
        pair = " and ".join(row["pair"])
        if row["reason"]:
            yield f"patch       {pair}: {row['reason']}"
        else:
            yield f"patch       {pair}: {row['points']} points, {row['epipolar_px']:.3g} px off"
    gap = summary["overlap_rms_mm"]
    overlap = (
        "nothing overlaps" if gap is None or math.isnan(gap) else f"they agree to {gap:.3g} mm rms"
    )
    yield f"points      {summary['points']} of {len(rows)} patches; {overlap}"
    mesh = summary["mesh"]
    yield (
        f"mesh        {mesh['vertices']} vertices, {mesh['faces']} triangles, texture of "
        f"{summary['texture_px_per_mm']:.4g} px/mm from {summary['views']} views"
    )
    yield from describe_verdict(summary)
    yield f"results     {folder}"
