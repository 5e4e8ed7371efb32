"""Whether a result can be trusted at a glance: PASS, WARN or FAIL, with the reasons."""

from collections.abc import Iterator, Mapping
from typing import Any

WARN, FAIL = "WARN", "FAIL"
MOST_SHEAR = 3.0
"""Anisotropy of a flattening beyond which strain along one direction is coarser than it looks."""
Finding = tuple[str, str]

_MOST_RANDOM = 0.1  # px, of the points that are least certain; a few are off by four times as much

_SMALLEST_MM, _LARGEST_MM = 1.0, 10_000.0
_MOST_INSTEAD = 0.5  # of the matches: a law is crude, but not half of it lost
_LONGEST_GAUGE = 0.2  # of the object: fewer than five gauges across show no field
_LARGEST_MOTION = 0.5  # of the object, in the middle: landmarks of another unit or frame


def judge(sections: Mapping[str, Any]) -> dict[str, Any]:
    """Weigh the figures of a run.

    Parameters
    ----------
    sections : mapping
        Sections of the summary; those of later stages may be missing.

    Returns
    -------
    dict
        ``level`` (PASS, WARN or FAIL) and ``reasons``, a sentence for each finding.
    """
    findings = [finding for rule in _RULES for finding in rule(sections)]
    levels = {level for level, _ in findings}
    level = FAIL if FAIL in levels else WARN if WARN in levels else "PASS"
    return {"level": level, "reasons": [f"{level}: {reason}" for level, reason in findings]}


def _enough_points(sections: Mapping[str, Any]) -> Iterator[Finding]:
    points = sections["points"]
    share = points["ok_share"]
    if share >= 0.9:
        return
    lost = {k: n for k, n in points["statuses"].items() if k not in ("OK", "OUTSIDE_MASK")}
    worst = max(lost, key=lost.__getitem__)
    yield (
        FAIL if share < 0.5 else WARN,
        f"{share:.1%} of {points['total']} points have a value; most others are {worst} "
        f"({lost[worst]})",
    )


def _sound_warp(sections: Mapping[str, Any]) -> Iterator[Finding]:
    match = sections.get("match", {})
    if match.get("fold_share", 0.0) > 1e-3:
        yield WARN, f"the warp folds over on {match['fold_share']:.2%} of the matched area"
    if match.get("doubt"):
        yield WARN, match["doubt"]


def _close_matches(sections: Mapping[str, Any]) -> Iterator[Finding]:
    residual = sections.get("match", {}).get("residual_px", 0.0)
    subset = sections["correlate"]["subset_size_px"]
    if residual > subset / 4:
        yield WARN, f"matches scatter by {residual:.1f} px about the warp (subset {subset} px)"


def _lawful(sections: Mapping[str, Any]) -> Iterator[Finding]:
    """Doubt a law that most matches contradict."""
    instead = sections.get("morph", {}).get("matches_instead_of_law", 0)
    pairs = sections.get("match", {}).get("pairs", 0)
    if instead > _MOST_INSTEAD * pairs:
        yield (
            WARN,
            f"law {sections['morph']['law']} leads nowhere at {instead} of {pairs} matches, which "
            "took over: check its file, its units and its frame, or leave morph.law at warp",
        )


def _alike(sections: Mapping[str, Any]) -> Iterator[Finding]:
    zncc = sections["correlate"]["zncc"]["median"]
    if zncc < 0.85:
        yield WARN, f"the patterns agree poorly: median ZNCC {zncc:.2f}, expected 0.85 or more"


def _certain(sections: Mapping[str, Any]) -> Iterator[Finding]:
    sigma = sections["correlate"]["sigma_px"]["p95"]
    if sigma > _MOST_RANDOM:
        yield (
            WARN,
            f"5 % of the points have random errors of {sigma:.2f} px or more of the deformed side: "
            "noise, blur or a very large stretch leave too little pattern in a subset; a larger "
            "correlate.subset_size or a finer texture helps",
        )


def _flat(sections: Mapping[str, Any]) -> Iterator[Finding]:
    for side, surface in sections.get("flatten", {}).items():
        if surface["flips"]:
            yield WARN, f"{surface['flips']} triangles of the {side} are upside down when flattened"
        shear = surface["anisotropy"]["p95"]
        if shear > MOST_SHEAR:
            yield (
                WARN,
                f"5 % of the {side}'s triangles are sheared by {shear:.1f} : 1 or more where it is "
                f"laid flat ({surface['method']}): the subset is that much longer there one way "
                "than the other; flatten.method=auto shears least",
            )
        if surface["texels_per_px"] < 0.7:
            yield (
                WARN,
                f"the flattened {side} is finer than its texture "
                f"({surface['texels_per_px']:.2f} texels per px): lower flatten.px_per_mm",
            )


def _aligned(sections: Mapping[str, Any]) -> Iterator[Finding]:
    if "align" not in sections:
        return
    align, size = sections["align"], sections["inputs"]["reference_size"]
    if align["rms_mm"] > 0.01 * size:
        yield (
            WARN,
            f"the alignment leaves {align['rms_mm']:.3g} mm rms (object {size:.3g} mm): "
            "displacement depends on it, strain does not",
        )
    if align["method"] == "points" and align["carried_share"] < 0.1:
        yield (
            WARN,
            f"only {align['carried_share']:.1%} of the points carry the alignment: give landmarks "
            "or align.rigid_region if displacement matters; strain does not depend on it",
        )


def _likely_size(sections: Mapping[str, Any]) -> Iterator[Finding]:
    """Doubt the unit where an object of this size is rarely measured."""
    size = sections.get("inputs", {}).get("reference_size")
    if size is not None and not _SMALLEST_MM <= size <= _LARGEST_MM:
        shown = f"{size:.0f}" if size > _LARGEST_MM else f"{size:.3g}"
        yield WARN, f"the object measures {shown} mm across: check inputs.units"


def _short_gauge(sections: Mapping[str, Any]) -> Iterator[Finding]:
    gauge = sections.get("strain", {}).get("gauge_mm", 0.0)
    size = sections.get("inputs", {}).get("reference_size", float("inf"))
    if gauge > _LONGEST_GAUGE * size:
        yield (
            WARN,
            f"strain is averaged over {gauge:.3g} mm, on an object of {size:.3g} mm: measure with "
            "a finer pattern, a finer texture or denser coloured vertices",
        )


def _likely_landmarks(sections: Mapping[str, Any]) -> Iterator[Finding]:
    """Doubt landmarks that fit each other but carry the two shapes apart."""
    if not sections.get("align", {}).get("method", "").startswith("landmarks"):
        return
    moved, size = sections["displacement_mm"]["median"], sections["inputs"]["reference_size"]
    if moved > _LARGEST_MOTION * size:
        yield (
            WARN,
            f"with these landmarks half of the points moved by {moved:.3g} mm or more, on an "
            f"object of {size:.3g} mm: check that they are in the frames and units of the files",
        )


_RULES = (
    *(_likely_size, _enough_points, _sound_warp, _close_matches, _lawful, _alike, _certain),
    *(_flat, _short_gauge, _aligned, _likely_landmarks),
)
