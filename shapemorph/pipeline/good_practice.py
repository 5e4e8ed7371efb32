"""What a report of digital image correlation has to state.

The rows are those of the reporting tables of "A Good Practices Guide for Digital Image
Correlation", International Digital Image Correlation Society, Edition 1 (2018),
doi:10.32720/idics/gpg.ed1, with further ones for what this program does beyond.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from shapemorph.config import RunConfig

NOT_PROVIDED = "NOT PROVIDED"
Rows = dict[str, str]
_Sections = Mapping[str, Any]

_DEFINITIONS = {
    "virtual strain gauge": "(window - 1) * spacing + subset size, window in points, the rest in px"
    "; in mm at the median scale",
    "noise floor": "spatial standard deviation of a quantity over all points of two scans of one "
    "state; bias: its mean there",
    "predicted": "one standard deviation of the random part, median over the points",
    "percentiles": "1 %, median and 99 % of the points or triangles",
}
_CRITERIA = {
    "icgn": "zero-mean normalised sum of squared differences (ZNSSD)",
    "paper": "zero-mean normalised cross-correlation (ZNCC)",
}
_SPLINES = {"cubic": "bicubic", "quintic": "biquintic"}
_SHAPES = ("0 (shift)", "1 (affine)", "2 (quadratic)")


def good_practice(
    sections: _Sections, config: RunConfig, noise: Mapping[str, Mapping[str, float]] | None
) -> dict[str, Any]:
    """Fill the tables with what is known.

    Parameters
    ----------
    sections : mapping
        Of the summary.
    config : RunConfig
    noise : mapping or None
        Mean and standard deviation of u, v, w, E1, E2 by name; None: not measured.

    Returns
    -------
    dict
        ``hardware``, ``analysis`` and ``flattening and matching`` (row to text,
        NOT PROVIDED where only the user knows), and ``definitions``.
    """
    return {
        "hardware": _hardware(sections, config),
        "analysis": _analysis(sections, config, noise),
        "flattening and matching": _flattening(sections, config),
        "definitions": _DEFINITIONS,
    }


def _hardware(sections: _Sections, config: RunConfig) -> Rows:
    """Say what was in front of the specimen, mostly in the user's words."""
    given = config.report.equipment.model_dump()
    told = {name: text or NOT_PROVIDED for name, text in given.items()}
    sides, correlate = sections["flatten"], sections["correlate"]
    return {
        "camera or scanner": told["camera"],
        "image resolution": told["resolution"],
        "lens and focal length": told["lens"],
        "aperture": told["aperture"],
        "filters": told["filters"],
        "lighting": told["lighting"],
        "field of view": told["field_of_view"],
        "stereo angle": told["stereo_angle"],
        "stand-off distance": told["stand_off"],
        "acquisition rate": told["frame_rate"],
        "exposure": told["exposure"],
        "patterning technique": told["pattern"],
        "pattern materials": told["pattern_materials"],
        "calibration target": told["calibration_target"],
        "calibration score": told["calibration_score"],
        "image scale": _both(sides, lambda side: f"{side['px_per_mm']:.4g} px/mm"),
        "texture scale": _both(sides, lambda side: f"{side['texels_per_px']:.3g} texels per px"),
        "image noise": f"{100 * correlate['grey_noise']:.3g} % of the grey range, estimated from "
        "the flattened reference",
        "pattern feature size": f"{correlate['speckle_px']:.3g} px in the flattened reference "
        f"({correlate['speckle_px'] / sides['reference']['px_per_mm']:.3g} mm)",
    }


def _analysis(
    sections: _Sections, config: RunConfig, noise: Mapping[str, Mapping[str, float]] | None
) -> Rows:
    correlate, strain = sections["correlate"], sections["strain"]
    scale = sections["flatten"]["reference"]["local_px_per_mm"]
    subset, spacing = correlate["subset_size_px"], correlate["spacing_px"]
    return {
        "software": f"shapemorph {sections['versions']['shapemorph']}",
        "image filtering": "none but what makes both sides alike (the sharper one blurred, light "
        "that varies over one evened out); both are resampled from the textures",
        "subset size": f"{subset} px; {_lengths(subset, scale)} mm on the reference (percentiles)",
        "step": f"{spacing} px; {_lengths(spacing, scale)} mm on the reference (percentiles)",
        "subset shape function": f"order {_SHAPES[correlate['order']]}",
        "matching criterion": _CRITERIA[config.correlate.mode],
        "interpolant": f"{_SPLINES[config.correlate.interpolation]} B-spline with exact prefilter",
        "strain window": f"{strain['window_points']} x {strain['window_points']} points",
        "virtual strain gauge": f"{strain['gauge_px']:.4g} px, {strain['gauge_mm']:.4g} mm",
        "strain formulation": "Green-Lagrange on the tangent plane of the reference; quadratic fit "
        "of the positions over the strain window, with cubic terms where a rim cuts it and they "
        "say more than noise",
        "filtering of displacement and strain": "none before or after the fit over the window",
        "displacement noise floor and bias": _floor(noise, "uvw", " mm"),
        "displacement noise, predicted": f"{sections['sigma_displacement_mm']['median']:.3g} mm, "
        "each component",
        "strain noise floor and bias": _floor(noise, ("E1", "E2"), ""),
        "strain noise, predicted": f"E1 {strain['sigma_E1']['median']:.3g}, "
        f"E2 {strain['sigma_E2']['median']:.3g}",
    }


def _flattening(sections: _Sections, config: RunConfig) -> Rows:
    """Rows of what other programs do not do."""
    sides, match, points = sections["flatten"], sections["match"], sections["points"]
    lost = {
        name: count
        for name, count in points["statuses"].items()
        if name not in ("OK", "OUTSIDE_MASK")
    }
    counts = match["counts"]
    return {
        "flattening": _both(sides, lambda side: str(side["method"])),
        "anisotropy": _both(sides, lambda side: _percentiles(side["anisotropy"])),
        "local scale": _both(sides, lambda side: f"{_percentiles(side['local_px_per_mm'])} px/mm"),
        "flipped triangles": _both(sides, lambda side: str(side["flips"])),
        "first matches": match["manner"],
        "matches": ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in counts.items()),
        "distance of the matches from the warp": f"{match['residual_px']:.3g} px",
        "morph law": ", ".join(config.morph.all_laws),
        "points with a value": f"{points['ok']} of {points['total']} ({points['ok_share']:.1%})",
        "points lost": ", ".join(f"{name} {count}" for name, count in lost.items()) or "none",
        "ZNCC": _percentiles(sections["correlate"]["zncc"]),
        "alignment": f"{sections['align']['method']}, {sections['align']['rms_mm']:.3g} mm rms",
    }


def _floor(noise: Mapping[str, Mapping[str, float]] | None, names: Iterable[str], unit: str) -> str:
    """Give standard deviation and mean of some quantities."""
    if noise is None:
        return f"{NOT_PROVIDED} (shapemorph noise A B measures it; report.noise names its result)"
    return "; ".join(
        f"{name}: {noise[name]['std']:.3g}{unit}, bias {noise[name]['mean']:.2g}{unit}"
        for name in names
    )


def _lengths(length_px: float, scale: Mapping[str, float]) -> str:
    """Percentiles in mm of a length in px; the scale is the finer where lengths are the smaller."""
    return " / ".join(f"{length_px / scale[name]:.3g}" for name in ("p99", "median", "p1"))


def _percentiles(spread: Mapping[str, float]) -> str:
    return " / ".join(f"{spread[name]:.4g}" for name in ("p1", "median", "p99"))


def _both(sides: _Sections, text: Callable[[Any], str]) -> str:
    """Text of both sides, once where they are alike."""
    reference, deformed = text(sides["reference"]), text(sides["deformed"])
    if reference == deformed:
        return reference
    return f"reference {reference}, deformed {deformed}"
