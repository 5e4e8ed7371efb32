"""The YAML file of a batch."""

from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section


class FoldersConfig(Section):
    """Specimens found on the disk, one in each folder."""

    pattern: str = Field(description="glob of folders; the name of a folder names the case")
    reference: str = Field("reference.*", description="glob of the reference file in each")
    deformed: str = Field("deformed.*", description="glob of the deformed file in each")


class ClusterConfig(Section):
    """Where the cases of a batch run."""

    workers: int | None = Field(
        None, ge=1, description="cases at a time on this machine; empty: one for each core"
    )
    threads: int | None = Field(
        None, ge=1, description="threads of each; empty: the cores divided by the workers"
    )
    memory_gb: float | None = Field(
        None, gt=0, description="most memory of each; empty: nine tenths divided by the workers"
    )
    attempts: int = Field(2, ge=1, description="times a case is tried whose worker dies")


class BatchConfig(Section):
    """The YAML file of a batch."""

    version: Literal[1] = Field(1, description="of this file format")
    base: Path | dict[str, Any] = Field({}, description="sections of a run, or the path of a run's")
    cases: list[dict[str, Any]] | None = Field(
        None, description="name, reference, deformed and any other keys of each case"
    )
    table: Path | None = Field(None, description="CSV with one column for each such key")
    folders: FoldersConfig | None = Field(None, description="cases found on the disk")
    cluster: ClusterConfig = ClusterConfig()

    @model_validator(mode="after")
    def _cases_come_from_one_place(self) -> Self:
        given = [n for n in ("cases", "table", "folders") if getattr(self, n) is not None]
        if len(given) != 1:
            raise ValueError(
                "expected one of cases, table and folders, got "
                f"{' and '.join(given) if given else 'none'}"
            )
        return self
