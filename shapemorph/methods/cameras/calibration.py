"""From points seen in pictures to calibrated cameras, with what does not fit put aside."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.calibration import Calibration, CameraUncertainty, Sighting, View
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.bundle import adjust
from shapemorph.methods.cameras.bundle_model import LENS, PLACE, Arrangement, observations_of
from shapemorph.methods.cameras.one_camera import calibrate_one, place_target
from shapemorph.methods.cameras.relative import Tied, compose, tie

_ROUGH = 1.0  # px: scale of residuals that count less while contradicting views may be among them
_BAD_VIEW = 4.0  # times what is usual among the views
_BAD_POINT = 6.0  # robust standard deviations
_NEGLIGIBLE = 0.05  # px: nothing is put aside for less
_RAYLEIGH = 1.1774  # median of the length of two normal components


@dataclass(slots=True, eq=False)
class _Work:
    """What is still believed while calibrating."""

    sightings: list[Sighting]
    views: tuple[View, ...]
    names: tuple[str, ...]
    rejected: list[tuple[str, str]]
    dropped: int = 0

    def of(self, camera: int) -> list[Sighting]:
        return [seen for seen in self.sightings if seen.camera == camera]

    def label(self, seen: Sighting) -> str:
        return f"{self.views[seen.view].name} in {self.names[seen.camera]}"

    def used_views(self) -> list[int]:
        return sorted({seen.view for seen in self.sightings})

    def reject(self, bad: Sequence[Sighting], reason: str) -> None:
        names = {id(seen) for seen in bad}
        self.sightings = [seen for seen in self.sightings if id(seen) not in names]
        self.rejected += [(self.label(seen), reason) for seen in bad]


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """Cameras, places of views by their number, and what was left unexplained."""

    cameras: tuple[Camera, ...]
    poses: dict[int, RigidTransform]
    residuals: tuple[Floats, ...] = ()
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))


def calibrate_rig(
    sightings: Sequence[Sighting],
    views: Sequence[View],
    sizes: Sequence[tuple[int, int]],
    *,
    names: Sequence[str],
    lens: Bools,
    rejected: Sequence[tuple[str, str]],
) -> Calibration:
    """Calibrate one, two or many cameras; the world is the frame of the first.

    Each camera is calibrated by itself, cameras are tied by views that two of them saw, then
    all cameras and all places are adjusted together. Views and points that contradict all
    others are put aside, and named.

    Parameters
    ----------
    sightings : sequence of Sighting
    views : sequence of View
    sizes : sequence of (int, int)
        Width and height of the pictures of each camera, px.
    names : sequence of str
        Of the cameras.
    lens : (10,) bool
        Which unknowns of the lenses are sought: fx, fy, cx, cy, k1, k2, k3, p1, p2, skew.
    rejected : sequence of (str, str)
        Pictures that were put aside before, and why.

    Raises
    ------
    DataError
        If a camera saw nothing, no view ties a camera to the others, or views contradict.
    StageError
        If the pictures do not settle the unknowns.
    """
    work = _Work(list(sightings), tuple(views), tuple(names), list(rejected))
    alone = [_calibrate_alone(work, number, sizes[number], lens) for number in range(len(names))]
    cameras = _placed(work, alone)
    state = _adjust(work, _State(cameras, _places(work, cameras)), lens, _ROUGH)
    _reject_views(work, state.residuals)
    state = _adjust(work, state, lens, None)
    if _drop_points(work, state.residuals):
        state = _adjust(work, state, lens, None)
    return _result(work, state)


def _result(work: _Work, state: _State) -> Calibration:
    count = len(work.names)
    blocks = state.covariance.reshape(count, LENS + PLACE, count, LENS + PLACE)
    spread = np.sqrt(np.maximum(np.einsum("cici->ci", blocks), 0.0))
    used = work.used_views()
    order = {view: number for number, view in enumerate(used)}
    return Calibration(
        rig=Rig(state.cameras, work.names),
        uncertainty=tuple(_uncertainty(row) for row in spread),
        views=tuple(work.views[view] for view in used),
        poses=tuple(state.poses[view] for view in used),
        sightings=tuple(replace(seen, view=order[seen.view]) for seen in work.sightings),
        residuals=state.residuals,
        rejected=tuple(work.rejected),
        dropped_points=work.dropped,
        covariance=state.covariance,
    )


def _uncertainty(row: Floats) -> CameraUncertainty:
    return CameraUncertainty(
        focal=row[:2],
        centre=row[2:4],
        radial=row[4:7],
        tangential=row[7:9],
        skew=float(row[9]),
        rotation=row[LENS : LENS + 3],
        translation=row[LENS + 3 :],
    )


def _calibrate_alone(work: _Work, number: int, size: tuple[int, int], lens: Bools) -> Camera:
    mine = work.of(number)
    if not mine:
        raise DataError(f"camera {work.names[number]}: no target was found in any of its pictures")
    try:
        camera, _, residuals = calibrate_one(mine, work.views, size, lens)
        bad = _outstanding([_typical(rest) for rest in residuals])
        if bad.any():
            work.reject(
                [seen for seen, is_bad in zip(mine, bad, strict=True) if is_bad],
                "its points do not fit a picture of the target",
            )
            camera, _, _ = calibrate_one(work.of(number), work.views, size, lens)
    except StageError as error:
        raise StageError(f"camera {work.names[number]}: {error}") from error
    return camera


def _typical(residuals: Floats) -> float:
    """Median distance between seen and predicted, px: a few wrong points do not count."""
    return float(np.median(np.linalg.norm(residuals, axis=1)))


def _outstanding(sizes: Sequence[float]) -> Bools:
    values = np.array(sizes)
    return values > max(_BAD_VIEW * float(np.median(values)), _NEGLIGIBLE)


def _placed(work: _Work, cameras: list[Camera]) -> tuple[Camera, ...]:
    """Place the cameras about the first one, the best tied first."""
    placed: dict[int, Camera] = {0: cameras[0]}
    while len(placed) < len(cameras):
        near, far = _next_pair(work, placed, len(cameras))
        try:
            tied = tie(work.of(near), work.of(far), (cameras[near], cameras[far]), work.views)
        except DataError as error:
            pair = f"{work.names[near]} and {work.names[far]}"
            raise DataError(f"cameras {pair}: {error}") from error
        _take(work, far, tied)
        pose = compose(tied.second_from_first, placed[near].pose)
        placed[far] = cameras[far].placed(pose)
    return tuple(placed[number] for number in range(len(cameras)))


def _next_pair(work: _Work, placed: dict[int, Camera], count: int) -> tuple[int, int]:
    seen = [{sighting.view for sighting in work.of(number)} for number in range(count)]
    pairs = [
        (len(seen[a] & seen[b]), a, b) for a in placed for b in range(count) if b not in placed
    ]
    common, near, far = max(pairs)
    if not common:
        raise DataError(
            f"camera {work.names[far]}: no view ties it to the others: show a target, or a 3D "
            "target, to two cameras at once"
        )
    return near, far


def _take(work: _Work, far: int, tied: Tied) -> None:
    work.sightings = [
        tied.renumbered.get(seen.view, seen) if seen.camera == far else seen
        for seen in work.sightings
    ]
    bad = [s for s in work.sightings if s.camera == far and s.view in tied.contradicting]
    work.reject(bad, "the cameras saw the target in different places: not the same moment?")


def _places(work: _Work, cameras: tuple[Camera, ...]) -> dict[int, RigidTransform]:
    """Place every view by the camera that saw most of it."""
    poses: dict[int, RigidTransform] = {}
    for seen in sorted(work.sightings, key=lambda one: len(one.ids)):
        camera = cameras[seen.camera]
        own = place_target(camera, seen, work.views[seen.view])
        poses[seen.view] = compose(camera.pose.inverse(), own)
    return poses


def _adjust(work: _Work, state: _State, lens: Bools, cauchy: float | None) -> _State:
    """Adjust the cameras and the views that are still believed."""
    used = work.used_views()
    order = {view: number for number, view in enumerate(used)}
    sightings = [replace(seen, view=order[seen.view]) for seen in work.sightings]
    start = Arrangement(state.cameras, tuple(state.poses[view] for view in used))
    seen = observations_of(sightings, [work.views[view] for view in used])
    found = adjust(seen, start, lens=lens, fixed=0, cauchy=cauchy)
    ends = np.cumsum([len(one.ids) for one in sightings])[:-1]
    return _State(
        found.arrangement.cameras,
        dict(zip(used, found.arrangement.poses, strict=True)),
        tuple(np.split(found.residuals, ends)),
        found.covariance,
    )


def _reject_views(work: _Work, residuals: tuple[Floats, ...]) -> None:
    """Put aside the views that do not fit one arrangement of the cameras."""
    parts: dict[int, list[Floats]] = {}
    for seen, rest in zip(work.sightings, residuals, strict=True):
        parts.setdefault(seen.view, []).append(rest)
    size = {view: _typical(np.concatenate(rest)) for view, rest in parts.items()}
    for view, is_bad in zip(size, _outstanding(list(size.values())), strict=True):
        if is_bad:
            reason = f"contradicts the other views: its points are {size[view]:.2g} px off"
            work.reject([seen for seen in work.sightings if seen.view == view], reason)


def _drop_points(work: _Work, residuals: tuple[Floats, ...]) -> int:
    """Put aside single points far beyond the noise of all; return how many."""
    lengths = [np.linalg.norm(rest, axis=1) for rest in residuals]
    noise = float(np.median(np.concatenate(lengths))) / _RAYLEIGH
    limit = max(_BAD_POINT * noise, _NEGLIGIBLE)
    kept = [length <= limit for length in lengths]
    pairs = zip(work.sightings, kept, strict=True)
    work.sightings = [seen.only(good) for seen, good in pairs]
    dropped = sum(int((~good).sum()) for good in kept)
    work.dropped += dropped
    return dropped
