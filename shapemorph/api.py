"""The package as a library: measure a pair, open a finished run, strain of known triangles."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from shapemorph.core.errors import ConfigError, DataError

if TYPE_CHECKING:
    from PIL.Image import Image

    from shapemorph.core.arrays import Floats, Ints
    from shapemorph.core.measurement import Measurement

State = Literal["reference", "deformed"]

_COMPONENTS = {"u": 0, "v": 1, "w": 2}


class Result:
    """A measurement: its arrays by name, its summary, its folder.

    Every array of ``measurement.vtp`` is an attribute (``r.E1``, ``r.displacement``) and
    an item (``r["E1"]``); docs/outputs.md lists them with units and formulas.

    Attributes
    ----------
    folder : Path
        The run. Without an output of its own it is gone with this object.
    points : (N, 3) float64
        Reference positions, mm, in the frame of the reference file.
    cells : (M, 4) int64
        Quads between neighbours that are all OK, as row numbers.
    summary : dict
        Content of ``summary.json``.
    arrays : mapping of str to (N, ...) array
        Point arrays by name.
    """

    def __init__(
        self,
        folder: Path,
        measurement: "Measurement",
        summary: dict[str, Any],
    ) -> None:
        self.folder = folder
        self.points: Floats = measurement.reference
        self.cells: Ints = measurement.cells
        self.summary = summary
        self.arrays: Mapping[str, Floats] = measurement.arrays

    def __getitem__(self, name: str) -> "Floats":
        try:
            return self.arrays[name]
        except KeyError:
            raise KeyError(f"{name!r}: expected one of {', '.join(self.arrays)}") from None

    def __getattr__(self, name: str) -> "Floats":
        arrays: Mapping[str, Floats] = self.__dict__.get("arrays", {})
        if name in arrays:
            return arrays[name]
        raise AttributeError(f"a result has no {name!r}: its arrays are {', '.join(arrays)}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.arrays})

    def __repr__(self) -> str:
        verdict = self.summary["verdict"]["level"]
        good = self.summary["points"]["ok"]
        return f"<Result {verdict}: {good} of {len(self.points)} points, {self.folder}>"

    def to_pyvista(self, state: State = "deformed") -> Any:
        """Make a pyvista surface with all arrays.

        Parameters
        ----------
        state : {"deformed", "reference"}
            Shape that its points show, both in the frame of the reference file. Lost
            points of the deformed shape stay where they were; no cell uses them.

        Returns
        -------
        pyvista.PolyData
        """
        import numpy as np
        import pyvista

        quads = np.insert(self.cells, 0, 4, axis=1).ravel()
        surface = pyvista.PolyData(self._shape(state), faces=quads if len(quads) else None)
        for name, values in self.arrays.items():
            surface.point_data.set_array(values, name)
        return surface

    def plot(
        self, name: str = "E1", path: str | Path | None = None, *, state: State = "deformed"
    ) -> "Image":
        """Draw a scalar on the shape, from two sides.

        Parameters
        ----------
        name : str
            A scalar array, ``u``, ``v``, ``w``, or ``displacement`` for its length.
        path : path, optional
            Picture file to write too; its suffix says the format.
        state : {"deformed", "reference"}

        Returns
        -------
        PIL.Image.Image
            Notebooks show it.

        Raises
        ------
        ConfigError
            If there is no such scalar.
        DataError
            If there is no cell to draw on.
        StageError
            If this machine has nothing to draw with.
        """
        from io import BytesIO

        from PIL import Image

        from shapemorph.view.figures import encoded

        picture = self._figure(name, state)
        ((_, content),) = encoded(iter([(name, picture)]))
        image = Image.open(BytesIO(content)).convert("RGB")
        if path is not None:
            image.save(path)
        return image

    def _figure(self, name: str, state: State) -> Any:
        from shapemorph.io.quantities import QUANTITIES
        from shapemorph.view.layout import Heading
        from shapemorph.view.measures import measure_of
        from shapemorph.view.one_measure import field_figure

        values = self._scalar(name)
        if not len(self.cells):
            raise DataError("expected a cell of four OK neighbours to draw on, got none")
        measure = measure_of(name)
        if measure is not None:
            title, note, label = measure.title, measure.note, measure.label
        else:
            known = {q.name: (q.symbol, q.unit, q.formula) for q in QUANTITIES}
            symbol, unit, note = known.get(name, (name, "1", ""))
            unit = unit.replace("1", "–")
            title, label = name, f"{name if symbol == '–' else symbol}  [{unit}]"
        heading = Heading(f"{title} on the {state} shape", note)
        return field_figure(self._shape(state), self.cells, values, heading=heading, label=label)

    def _scalar(self, name: str) -> "Floats":
        import numpy as np

        if name in _COMPONENTS:
            return self.arrays["displacement"][:, _COMPONENTS[name]]
        if name == "displacement":
            return np.asarray(np.linalg.norm(self.arrays[name], axis=1))
        scalars = [key for key, values in self.arrays.items() if values.ndim == 1]
        if name not in scalars:
            names = ", ".join((*_COMPONENTS, "displacement", *scalars))
            raise ConfigError(f"expected a scalar ({names}), got {name!r}")
        return np.asarray(self.arrays[name], dtype=np.float64)

    def _shape(self, state: State) -> "Floats":
        import numpy as np

        if state not in ("reference", "deformed"):
            raise ConfigError(f"expected state reference or deformed, got {state!r}")
        if state == "reference":
            return self.points
        return self.points + np.nan_to_num(self.arrays["displacement"])


def measure(
    reference: str | Path,
    deformed: str | Path,
    *,
    output: str | Path | None = None,
    **overrides: Any,
) -> Result:
    """Measure a pair of textured meshes.

    Parameters
    ----------
    reference, deformed : path
        Textured meshes before and after the deformation.
    output : path, optional
        Folder for the run, which is brought up to date if it is one already. Without it
        the run lives in a temporary folder as long as the result, and draws no figures.
    **overrides
        Sections of the configuration, as ``strain={"window": 7}``, or single keys, as
        ``**{"strain.window": 7}``. Relative paths start from the current folder.

    Returns
    -------
    Result

    Raises
    ------
    ConfigError, DataError, StageError
        Each says what was expected, what came, and what to change.
    """
    from functools import partial
    from shutil import rmtree
    from tempfile import mkdtemp
    from weakref import finalize

    inputs = {"reference": str(reference), "deformed": str(deformed)}
    if output is not None:
        return _measured(Path(output), overrides, inputs)
    home = Path(mkdtemp(prefix="shapemorph-"))
    remove = partial(rmtree, home, ignore_errors=True)
    try:
        result = _measured(home / "run", {"report.figures": False, **overrides}, inputs)
    except BaseException:
        remove()
        raise
    finalize(result, remove)
    return result


def load(run: str | Path) -> Result:
    """Open a finished run.

    Parameters
    ----------
    run : path
        Its folder.

    Raises
    ------
    DataError
        If there is no finished run.
    """
    import json

    from shapemorph.io.measurement_files import read_vtp

    folder = Path(run)
    field, summary = folder / "measurement.vtp", folder / "summary.json"
    for path in (field, summary):
        if not path.is_file():
            raise DataError(f"expected a finished run in {folder}, found no {path.name}")
    measurement, _ = read_vtp(field)
    return Result(folder, measurement, json.loads(summary.read_text(encoding="utf-8")))


def facet_strain(reference: "Floats", deformed: "Floats", faces: "Ints") -> dict[str, "Floats"]:
    """Measure the strain of every triangle of a mesh whose vertices are known twice.

    For correspondences that need no pictures: finite elements, tracked markers.

    Parameters
    ----------
    reference, deformed : (V, 3)
        Positions of the same vertices, each state in any frame; NaN where unknown.
    faces : (F, 3)
        Rows of the three corners, from 0.

    Returns
    -------
    dict of str to (F,) float64
        Every measure by the name of its array in facets.vtp (docs/outputs.md); NaN where a
        corner is unknown or the triangle has no area.

    Raises
    ------
    DataError
        If the shapes do not fit.
    """
    import numpy as np

    from shapemorph.methods.facet_strain import triangle_strain
    from shapemorph.methods.measures import principal_measures
    from shapemorph.methods.principal import principal

    before, after = (np.asarray(state, dtype=np.float64) for state in (reference, deformed))
    corners = np.asarray(faces)
    if before.ndim != 2 or before.shape[1] != 3 or before.shape != after.shape:
        raise DataError(f"expected two arrays (V, 3), got {before.shape} and {after.shape}")
    if corners.ndim != 2 or corners.shape[1] != 3 or corners.dtype.kind not in "iu":
        raise DataError(f"expected faces (F, 3) of whole numbers, got {corners.shape}")
    if corners.size and not 0 <= corners.min() <= corners.max() < len(before):
        raise DataError(f"expected faces of vertices 0 to {len(before) - 1}, got {corners.max()}")
    values, _ = principal(triangle_strain(before, after, corners.astype(np.int64)))
    return principal_measures(values[:, 0], values[:, 1])


def _measured(folder: Path, overrides: Mapping[str, Any], inputs: dict[str, str]) -> Result:
    """Bring a run up to date and open it."""
    from shapemorph.config import RunConfig
    from shapemorph.io.batch_files import unfolded
    from shapemorph.io.config_files import absolute_paths, check_config, laid_over
    from shapemorph.pipeline.measure import measure as bring_up_to_date

    document = laid_over(unfolded(overrides), {"inputs": inputs})
    config = check_config(absolute_paths(document, RunConfig, Path.cwd()), RunConfig)
    bring_up_to_date(config, folder, listener=lambda event: None)  # noqa: ARG005
    return load(folder)
