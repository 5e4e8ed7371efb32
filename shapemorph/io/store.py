"""Results of stages on disk: ``RUN/<stage>/result.npz`` and ``result.json``."""

import contextlib
import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.core.errors import DataError
from shapemorph.io.codec import put_together, take_apart
from shapemorph.io.safe_files import remove_folder, whole_folder


class RunStore:
    """The cache of one run.

    A result counts only when its fingerprint is the wanted one; a folder that is
    incomplete for any reason counts as absent.

    Parameters
    ----------
    folder : Path
        The run; made when the first result is saved.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def fingerprint(self, name: str) -> str | None:
        """Fingerprint of the stored result; None where there is no whole one."""
        header = self._header(name)
        return None if header is None else str(header["fingerprint"])

    def seconds(self, name: str) -> float | None:
        """Time that the stage took when its result was made."""
        header = self._header(name)
        return None if header is None else float(header["seconds"])

    def load(self, name: str) -> Any:
        """Read a result.

        Raises
        ------
        DataError
            If it is absent or damaged, with the way out.
        """
        header = self._header(name)
        if header is None:
            raise DataError(f"{self.folder} holds no result of {name}: run it first")
        try:
            with np.load(self._archive(name), allow_pickle=False) as archive:
                arrays = {key: archive[key] for key in archive.files}
            return put_together(arrays, header["result"])
        except (OSError, ValueError, zipfile.BadZipFile, KeyError) as error:
            raise DataError(
                f"the stored result of {name} in {self.folder} is damaged ({error}): make it "
                f"again with --force {name}"
            ) from error

    def save(self, name: str, noun: object, *, fingerprint: str, seconds: float) -> None:
        """Store a result; until it is whole, the stage counts as not done."""
        arrays, tree = take_apart(noun)
        with whole_folder(self.folder / name) as partial:
            archive = partial / "result.npz"
            with archive.open("wb") as stream:
                np.savez(stream, **arrays)  # type: ignore[arg-type]
            header = {
                "stage": name,
                "fingerprint": fingerprint,
                "seconds": seconds,
                "archive_bytes": archive.stat().st_size,
                "result": tree,
            }
            (partial / "result.json").write_text(
                json.dumps(header, indent=1, allow_nan=False), encoding="utf-8"
            )

    def discard(self, name: str) -> None:
        """Forget a result."""
        remove_folder(self.folder / name)

    def sweep(self) -> None:
        """Remove what a killed run left half done."""
        if self.folder.is_dir():
            for pattern in (".partial-*", ".old-*"):
                for path in self.folder.glob(pattern):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()

    def _archive(self, name: str) -> Path:
        return self.folder / name / "result.npz"

    def _header(self, name: str) -> dict[str, Any] | None:
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            text = (self.folder / name / "result.json").read_text(encoding="utf-8")
            header: dict[str, Any] = json.loads(text)
            if self._archive(name).stat().st_size == header["archive_bytes"]:
                return header
        return None
