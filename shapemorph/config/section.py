"""What all sections of the YAML file have in common."""

from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator

Unit = Literal["mm", "um", "cm", "m", "in"]
Vector3 = tuple[float, float, float]


class Section(BaseModel):
    """Base of every section: immutable, unknown keys are errors, `yes` is no number.

    What checks a section is built when it is first used: most commands use few of them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _truth_is_no_number(cls, given: Any, info: ValidationInfo) -> Any:
        if isinstance(given, bool) and not _may_be_bool(cls.model_fields[info.field_name or ""]):
            word = "true (yes, on)" if given else "false (no, off)"
            raise ValueError(f"expected no {word}: give a value, in quotes if it is a word")
        return given


def _may_be_bool(field: Any) -> bool:
    return bool in {field.annotation, *get_args(field.annotation)}
