"""What a run reads: meshes, landmarks, regions, laws; fingerprints first, content when needed."""

from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import Law, RegionConfig, RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.forming import LimitCurve
from shapemorph.core.inputreports import InputReports
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import LawInputs
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.meshreport import MeshReport
from shapemorph.core.region import Region
from shapemorph.io.mesh_sources import mesh_sources
from shapemorph.pipeline.fingerprints import file_fingerprint, files_fingerprint, fingerprint
from shapemorph.pipeline.law_inputs import law_files, law_fingerprint, read_law_inputs

_SIDES = ("reference", "deformed")
_LIMITS = ("region", "rigid_region")
_CURVES = ("meridian", "limit_curve")
_LAW_SOURCES = ("law_inputs", "all_law_inputs")
_SAME_OBJECT = 6.0  # a rubber balloon grows threefold; units differ tenfold or more


class Inputs:
    """Sources of a run by name.

    They are reference, deformed, reports, landmarks, region, rigid_region, law_inputs (what
    the main morph law reads), all_law_inputs (what all listed laws read), and limit_curve and
    noise, which no stage reads.
    Each is loaded once, when a stage first asks for it.
    """

    def __init__(self, config: RunConfig) -> None:
        self._config = config
        self._loaded: dict[str, Any] = {}
        self._fingerprints: dict[str, str] = {}

    def fingerprint(self, name: str) -> str:
        """Digest of the content of a source and of how it is read."""
        if name not in self._fingerprints:
            self._fingerprints[name] = self._take_fingerprint(name)
        return self._fingerprints[name]

    def load(self, name: str) -> Any:
        """Read a source; errors as its reader raises them."""
        if name not in self._loaded:
            self._loaded[name] = self._read(name)
        return self._loaded[name]

    def unit(self, side: str) -> str:
        """Length unit of one file."""
        inputs = self._config.inputs
        own = inputs.reference_units if side == "reference" else inputs.deformed_units
        return own or inputs.units

    def _mm_per_unit(self, side: str) -> float:
        from shapemorph.io.meshes import MM_PER_UNIT

        return float(MM_PER_UNIT[self.unit(side)])

    def path(self, side: str) -> Path:
        """Path of one mesh.

        Raises
        ------
        ConfigError
            If the configuration names none.
        """
        inputs = self._config.inputs
        path = inputs.reference if side == "reference" else inputs.deformed
        if path is None:
            raise ConfigError(f"inputs.{side} is empty: expected the path of a textured mesh")
        return path

    def files(self) -> tuple[Path, ...]:
        """Every file that is read.

        Raises
        ------
        DataError
            If one does not exist.
        """
        regions = (self._config.inputs.region, self._config.align.rigid_region)
        optional = [
            self._config.inputs.landmarks,
            self._config.flatten.profile,
            self._config.report.noise,
            self._config.forming.limit_curve,
            *(r.mask for r in regions if r is not None),
        ]
        others = [path for path in optional if path is not None]
        others += law_files(self._config.morph, self._config.morph.all_laws)
        meshes = [*mesh_sources(self.path("reference")), *mesh_sources(self.path("deformed"))]
        for path in others:
            if not path.is_file():
                raise DataError(f"{path} does not exist: expected a file")
        return (*meshes, *others)

    def check_beside_meshes(self) -> None:
        """Read all but the meshes, so that what is wrong with it shows before any work.

        Raises
        ------
        ConfigError
            If landmarks are needed and none are given.
        DataError
            If a mask, a meridian, a limit curve, a noise floor or a file of a morph law is
            missing or not what it should be; if landmarks cannot be read, or if they are to
            carry the rigid motion and are fewer than three, lie on one line or are mirrored.
        """
        for source in (*_LIMITS, *_CURVES, "all_law_inputs", "noise"):
            self.load(source)
        landmarks, method = self.load("landmarks"), self._config.align.method
        if landmarks is None:
            if "landmarks" in method:
                raise ConfigError(
                    f"align.method {method} needs landmarks, got none: set inputs.landmarks, or "
                    "choose points"
                )
            return
        if method == "auto" or "landmarks" in method:
            _check_they_carry_a_motion(landmarks)

    def _take_fingerprint(self, name: str) -> str:
        if name in _SIDES:
            sources = files_fingerprint(mesh_sources(self.path(name)))
            return fingerprint(self.unit(name), self._config.inputs.channel, sources)
        if name == "reports":
            return fingerprint(self.fingerprint("reference"), self.fingerprint("deformed"))
        if name == "landmarks":
            path = self._config.inputs.landmarks
            content = None if path is None else file_fingerprint(path)
            return fingerprint(content, self.unit("reference"), self.unit("deformed"))
        if name in _CURVES:
            return self._curve_fingerprint(name)
        if name in _LAW_SOURCES:
            return law_fingerprint(
                self._config.morph,
                self._laws(name),
                self.unit("reference"),
                lambda: self.fingerprint("landmarks"),
            )
        return self._region_fingerprint(self._region_config(name))

    def _curve_fingerprint(self, name: str) -> str:
        if name == "meridian":
            profile = self._config.flatten.profile
            return fingerprint(profile and (file_fingerprint(profile), self.unit("deformed")))
        curve = self._config.forming.limit_curve
        return fingerprint(curve and file_fingerprint(curve))

    def _region_fingerprint(self, region: RegionConfig | None) -> str:
        if region is None:
            return fingerprint(None)
        mask = None if region.mask is None else file_fingerprint(region.mask)
        limits = region.model_dump(mode="json", exclude={"mask"})
        return fingerprint(limits, mask, self.unit("reference"))

    def _region_config(self, name: str) -> RegionConfig | None:
        if name == "region":
            return self._config.inputs.region
        return self._config.align.rigid_region

    def _read(self, name: str) -> Any:
        if name in _SIDES:
            return self._read_mesh(name)[0]
        if name == "reports":
            return self._read_reports()
        if name in _CURVES:
            return self._read_meridian() if name == "meridian" else self._read_limit_curve()
        if name == "noise":
            return self._read_noise()
        if name in _LAW_SOURCES:
            return self._read_law_inputs(name)
        return self._read_landmarks() if name == "landmarks" else self._read_region(name)

    def _read_mesh(self, side: str) -> tuple[TexturedMesh, MeshReport]:
        return self._read_mesh_as(side, self._channel()[0])

    def _read_mesh_as(self, side: str, channel: str) -> tuple[TexturedMesh, MeshReport]:
        from shapemorph.io.meshes import read_mesh

        key = f"{side} and report, {channel}"
        if key not in self._loaded:
            self._loaded[key] = read_mesh(self.path(side), unit=self.unit(side), channel=channel)
        found: tuple[TexturedMesh, MeshReport] = self._loaded[key]
        return found

    def _read_both(self, channel: str) -> list[tuple[TexturedMesh, MeshReport]]:
        """Read reference and deformed at once."""
        from shapemorph.methods.threads import run_at_once

        return run_at_once(lambda side: self._read_mesh_as(side, channel), _SIDES)

    def _channel(self) -> tuple[str, str]:
        """Channel of the colours that becomes grey, and why."""
        if "channel" not in self._loaded:
            self._loaded["channel"] = self._choose_channel()
        found: tuple[str, str] = self._loaded["channel"]
        return found

    def _choose_channel(self) -> tuple[str, str]:
        """Ask both files, which are read as luma for that.

        The fingerprint of one leaves out what the other has to say: every stage that reads
        one reads both.
        """
        if self._config.inputs.channel != "auto":
            return self._config.inputs.channel, "as inputs.channel says"
        from shapemorph.methods.colour_content import best_channel

        best, reason = best_channel([report.content for _, report in self._read_both("luma")])
        if best != "luma":
            for side in _SIDES:
                del self._loaded[f"{side} and report, luma"]
        return best, reason

    def _read_reports(self) -> InputReports:
        (reference, report), (deformed, other) = self._read_both(self._channel()[0])
        check_sizes(reference.size, deformed.size)
        return InputReports(report, other, reference.size, deformed.size, *self._channel())

    def _read_landmarks(self) -> Landmarks | None:
        from shapemorph.io.landmarks import read_landmarks

        path = self._config.inputs.landmarks
        if path is None:
            return None
        return read_landmarks(
            path,
            reference_scale=self._mm_per_unit("reference"),
            deformed_scale=self._mm_per_unit("deformed"),
        )

    def _laws(self, name: str) -> tuple[Law, ...]:
        morph = self._config.morph
        return (morph.law,) if name == "law_inputs" else morph.all_laws

    def _read_law_inputs(self, name: str) -> LawInputs:
        from shapemorph.io.meshes import MM_PER_UNIT

        return read_law_inputs(
            self._config.morph,
            self._laws(name),
            lambda unit: float(MM_PER_UNIT[unit or self.unit("reference")]),
            lambda: self.load("landmarks"),
        )

    def _read_meridian(self) -> Floats | None:
        from shapemorph.io.meridian_files import read_meridian

        path = self._config.flatten.profile
        return None if path is None else read_meridian(path, scale=self._mm_per_unit("deformed"))

    def _read_noise(self) -> dict[str, dict[str, float]] | None:
        from shapemorph.io.noise_files import read_noise

        path = self._config.report.noise
        return None if path is None else read_noise(path)

    def _read_limit_curve(self) -> LimitCurve | None:
        from shapemorph.io.limit_curves import read_limit_curve

        path = self._config.forming.limit_curve
        return None if path is None else read_limit_curve(path)

    def _read_region(self, name: str) -> Region | None:
        config = self._region_config(name)
        return None if config is None else region_in_mm(config, self._mm_per_unit("reference"))


def _check_they_carry_a_motion(landmarks: Landmarks) -> None:
    """Raise DataError where landmarks do not settle the rigid motion between the files."""
    from shapemorph.methods.rigid import fit_rigid, refuse_mirrored

    try:
        fit_rigid(landmarks.deformed, landmarks.reference, np.ones(len(landmarks.names)))
    except DataError as error:
        raise DataError(
            f"landmarks, which carry the rigid motion between the files: {error}, or set "
            "align.method=points, so that they serve the match and the morph law only"
        ) from None
    refuse_mirrored(landmarks.deformed, landmarks.reference)


def region_in_mm(config: RegionConfig, scale: float) -> Region:
    """Make a region from its section; `scale` is mm per unit of the reference file."""
    from shapemorph.io.images import read_white

    polygons = [*([config.polygon] if config.polygon else []), *(config.polygons or [])]
    return Region(
        polygons=tuple(np.array(each, dtype=np.float64) for each in polygons) or None,
        holes=tuple(np.array(each, dtype=np.float64) for each in config.holes or ()),
        mask=None if config.mask is None else read_white(config.mask),
        centre=None if config.centre is None else np.array(config.centre) * scale,
        radius=None if config.radius is None else config.radius * scale,
    )


def check_sizes(reference_size: float, deformed_size: float) -> None:
    """Refuse two meshes that can only be one object if their units differ.

    Parameters
    ----------
    reference_size, deformed_size : float
        Diagonals of the bounding boxes in mm, if the configured units are right.

    Raises
    ------
    ConfigError
        If one is at least six times as large as the other.
    """
    ratio = deformed_size / reference_size
    if 1 / _SAME_OBJECT < ratio < _SAME_OBJECT:
        return
    factors = {10.0: "mm and cm", 25.4: "mm and in", 100.0: "cm and m", 1000.0: "mm and m"}
    nearest = min(factors, key=lambda f: abs(np.log(f) - abs(np.log(ratio))))
    raise ConfigError(
        f"reference is {reference_size:.4g} mm large and deformed {deformed_size:.4g} mm: expected "
        f"one object, got a factor of {max(ratio, 1 / ratio):.3g} (as between "
        f"{factors[nearest]}): set inputs.reference_units, inputs.deformed_units or inputs.units"
    )
