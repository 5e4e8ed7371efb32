"""Results as a few lines of text."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any


def describe_run(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what a measurement found."""
    points, coverage = summary["points"], summary["coverage"]
    displacement, strain = summary["displacement_mm"], summary["strain"]
    yield (
        f"points      {points['ok']} of {points['total']} ({points['ok_share']:.1%}), "
        f"{coverage['share_of_surface']:.1%} of the surface"
    )
    yield (
        f"displaced   median {_number(displacement['median'])} mm, "
        f"largest {_number(displacement['max'])} mm "
        f"(1 sigma {_number(summary['sigma_displacement_mm']['median'])} mm)"
    )
    for name in ("E1", "E2"):
        found = strain[name]
        yield (
            f"{name}          median {_number(found['median'])}, "
            f"p1 {_number(found['p1'])}, p99 {_number(found['p99'])} (Green-Lagrange; 1 sigma "
            f"{_number(strain['sigma_' + name]['median'])})"
        )
    yield (
        f"gauge       {_number(strain['gauge_px'])} px = {_number(strain['gauge_mm'])} mm; "
        f"subset {summary['correlate']['subset_size_px']} px, "
        f"spacing {summary['correlate']['spacing_px']} px"
    )
    yield f"aligned     {summary['align']['note']}"
    yield from _describe_forming(summary.get("forming", {}))
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def _describe_forming(forming: dict[str, Any]) -> Iterator[str]:
    """Say what was asked for beyond the field."""
    diagram, dome = forming.get("diagram", {}), forming.get("dome")
    point = diagram.get("critical_point")
    if point:
        place = ", ".join(_number(value) for value in point["reference_mm"])
        yield (
            f"critical    eps1 {_number(point['hencky_1'])}, eps2 {_number(point['hencky_2'])} "
            f"(Hencky), thinning {point['thinning']:.1%}, at ({place}) mm of the reference"
        )
        if "limit_margin" in point:
            yield (
                f"limit       margin {_number(point['limit_margin'])} there (1 sigma "
                f"{_number(point['sigma_limit_margin'])}); {diagram['points_above_curve']} points "
                "above the curve"
            )
    for caveat in diagram.get("caveats", ()):
        yield f"            caveat: {caveat}"
    if dome:
        stress, sigma = dome.get("membrane_stress_MPa"), dome["sigma_pole_radius_mm"]
        yield (
            f"dome        height {_number(dome['height_mm'])} mm, radius at the pole "
            f"{_number(dome['pole_radius_mm'])} mm (1 sigma {_number(sigma)} mm)"
            f"{'' if stress is None else f', membrane stress {_number(stress)} MPa'}"
        )


def describe_correlation(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what the correlation of two pictures found."""
    points, correlate = summary["points"], summary["correlate"]
    yield f"points      {points['ok']} of {points['total']} ({points['ok_share']:.1%})"
    yield f"subset      {correlate['subset_reason']}; spacing {correlate['spacing_px']} px"
    yield (
        f"zncc        median {_number(correlate['zncc']['median'])}, "
        f"p5 {_number(correlate['zncc']['p5'])}; 1 sigma "
        f"{_number(correlate['sigma_px']['median'])} px"
    )
    strain = summary["strain"]
    yield (
        f"strain      E1 median {_number(strain['E1']['median'])}, p99 "
        f"{_number(strain['E1']['p99'])} (Green-Lagrange; gauge {_number(strain['gauge_px'])} px)"
    )
    if correlate["points_per_second"]:
        yield f"speed       {correlate['points_per_second']:.0f} points/s"
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def describe_frames(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what the correlation of a sequence found."""
    rows = summary["frames"]
    width = max(len(str(row["frame"])) for row in rows) + 2
    heads = "".join(f"{head:>10s}" for head in ("u px", "v px", "E1"))
    yield f"{'':{width}s}{'points':>8s}{'share':>8s}{'zncc':>8s}{heads}"
    for row in rows:
        numbers = "".join(
            f"{_number(row[name]):>10s}" for name in ("u_median_px", "v_median_px", "E1_median")
        )
        zncc = _number(row["zncc_median"])
        yield (
            f"{row['frame']:{width}s}{row['ok']:8d}{row['ok_share']:8.1%}{zncc:>8s}{numbers}"
            f"{'  ' + row['reason'] if row['reason'] else ''}"
        )
    drift = summary["drift"]
    if drift is not None:
        yield (
            f"drift       u {_number(drift['mean_u_px'])}, v {_number(drift['mean_v_px'])}, rms "
            f"{_number(drift['rms_px'])} px at {drift['points']} points"
        )
    yield from describe_verdict(summary)
    yield f"results     {folder}"


def describe_assessment(found: dict[str, Any]) -> Iterator[str]:
    """Say how well pictures can be correlated."""
    for side in ("reference", "deformed"):
        if side in found:
            yield from _describe_picture(side, found[side])
    yield f"noise       {_number(found['grey_noise'])} levels, from {found['grey_noise_source']}"
    figures = found["reference"]
    yield (
        f"predicted   sigma u {_number(figures['predicted_sigma_u_px'])}, v "
        f"{_number(figures['predicted_sigma_v_px'])} px; where the pattern is poor "
        f"{_number(figures['predicted_sigma_poor_px'])} px"
    )
    yield f"subset      {figures['subset_reason']}"
    yield f"spacing     {figures['spacing_px']} px: {figures['spacing_reason']}"
    if "star" in found:
        star = found["star"]
        yield (
            f"star        resolution {_number(star['resolution_px'])} px, sigma "
            f"{_number(star['sigma_px'])} px ({star['sigma_source']}), MEI "
            f"{_number(star['mei_px2'])} px^2; subset {star['subset_size_px']} px, order "
            f"{star['order']}"
        )
    yield from (f"advice      {sentence}" for sentence in found["advice"])
    yield from (f"  {word}: {meaning}" for word, meaning in found["definitions"].items())


def _describe_picture(side: str, figures: dict[str, Any]) -> Iterator[str]:
    yield (
        f"{side:11s} {figures['width_px']} x {figures['height_px']} px, speckle "
        f"{_number(figures['speckle_px'])} px, contrast {_number(figures['contrast'])} levels, "
        f"{figures['clipped_share']:.2%} clipped"
    )
    yield (
        f"            mean gradient {_number(figures['mean_gradient'])} levels/px; SSSIG x "
        f"{_number(figures['sssig_x'])}, y {_number(figures['sssig_y'])} (subset "
        f"{figures['subset_size_px']} px)"
    )


def describe_morph(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say what matching two pictures found."""
    match = summary["match"]
    yield f"matches     {match['pairs']}, {_number(match['residual_px'])} px about the warp"
    yield f"folded      {match['fold_share']:.2%} of the matched area"
    yield f"sequence    {summary['morph']['images']} pictures; {summary['morph']['reason']}"
    yield f"results     {folder}"


def describe_flattening(folder: Path, summary: dict[str, Any]) -> Iterator[str]:
    """Say how a mesh was laid flat."""
    found = summary["flatten"]
    stretch, scale = found["anisotropy"], found["local_px_per_mm"]
    yield f"method      {found['method']}: {found['reason']}"
    yield (
        f"picture     {found['width_px']} x {found['height_px']} px, "
        f"{_number(found['px_per_mm'])} px/mm, speckle {_number(found['speckle_px'])} px"
    )
    yield f"anisotropy  median {_number(stretch['median'])}, p99 {_number(stretch['p99'])}"
    yield f"local scale p1 {_number(scale['p1'])}, p99 {_number(scale['p99'])} px/mm"
    yield f"flips       {found['flips']}"
    yield from (f"cleaned     {note}" for note in summary["inputs"]["notes"])
    yield f"results     {folder}"


def describe_check(found: dict[str, Any]) -> Iterator[str]:
    """Say what a run would read."""
    for side in ("reference", "deformed"):
        report, size = found["inputs"][side], found["inputs"][f"{side}_size"]
        yield (
            f"{side:11s} {report['name']}: {report['faces']} faces, {_number(size)} mm, grey from "
            f"{report['grey_source']}"
        )
        yield from (f"            {note}" for note in report["notes"])
    if found["inputs"]["channel"] != "luma":
        yield f"grey        {found['inputs']['channel']}: {found['inputs']['channel_reason']}"
    if found["landmarks"]:
        yield f"landmarks   {', '.join(found['landmarks'])}"
    yield "ready to run"


def describe_batch(
    folder: Path, rows: Sequence[dict[str, Any]], notes: Sequence[str]
) -> Iterator[str]:
    """Say what became of each case."""
    width = max(len(row["case"]) for row in rows) + 2
    for row in rows:
        kept = ", kept" if row["state"] == "kept" else ""
        reason = f": {row['reason']}" if row["reason"] else ""
        yield f"{row['case']:{width}s}{row['verdict'] or row['state']}{kept}{reason}"
    good = sum(row["state"] in ("done", "kept") for row in rows)
    yield f"{good} of {len(rows)} cases have a result"
    yield from notes
    yield f"summary     {folder / 'index.html'}"


def describe_noise(folder: Path, found: dict[str, Any]) -> Iterator[str]:
    """Say how large noise and bias are, and what these words mean."""
    figures = found["figures"]
    columns = ("mean", "std", "robust_std", "predicted", "ratio")
    heads = ("mean", "std", "robust", "predicted", "ratio")
    yield f"{figures['points']} points; {found['alignment']}"
    yield f"{'':8s}" + "".join(f"{head:>12s}" for head in heads)
    for name, unit in (("u", " mm"), ("v", " mm"), ("w", " mm"), ("E1", ""), ("E2", "")):
        yield f"{name + unit:8s}" + "".join(f"{_number(figures[name][c]):>12s}" for c in columns)
    yield from (f"{word:12s}{meaning}" for word, meaning in found["definitions"].items())
    yield from found["notes"]
    yield f"results     {folder}"


def describe_verdict(summary: dict[str, Any]) -> Iterator[str]:
    """Give the verdict and its reasons."""
    yield f"verdict     {summary['verdict']['level']}"
    yield from (f"            {reason}" for reason in summary["verdict"]["reasons"])


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
