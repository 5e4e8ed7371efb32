"""Configuration files: YAML to checked models, errors that a user can act on, templates."""

import difflib
import types
import typing
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from shapemorph.core.errors import ConfigError

Model = TypeVar("Model", bound=BaseModel)
Document = dict[str, Any]

_PLAIN_WORDS = {
    "model_type": "expected a section of keys",
    "path_type": "expected the path of a file",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
    "float_parsing": "expected a number",
    "bool_parsing": "expected true or false",
    "too_short": "expected {min_length} or more entries",
    "greater_than": "expected more than {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected less than {lt}",
    "less_than_equal": "expected {le} or less",
    "literal_error": "expected {expected}",
    "list_type": "expected a list",
    "tuple_type": "expected a list",
    "string_type": "expected text",
}


def read_config(path: Path, model: type[Model], settings: Sequence[str] = ()) -> Model:
    """Read a YAML file, apply ``section.key=value`` settings, check everything.

    Relative paths in the file are relative to the file, those in settings to the current
    directory.

    Raises
    ------
    ConfigError
        One line: where, what was expected, what came.
    """
    document, lines = read_yaml(path)
    document = absolute_paths(document, model, path.absolute().parent)
    return check_config(document, model, settings, source=str(path), lines=lines)


def check_config(
    document: Document,
    model: type[Model],
    settings: Sequence[str] = (),
    *,
    source: str = "configuration",
    lines: dict[tuple[str, ...], int] | None = None,
) -> Model:
    """Check a document after applying settings to it; errors as :func:`read_config`."""
    origins: dict[tuple[str, ...], str] = {}
    for setting in settings:
        keys, value = parse_setting(setting)
        value = absolute_paths(nested(keys, value), model, Path.cwd())
        document = laid_over(document, value)
        origins[keys] = f"--set {setting}"
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise ConfigError(_explain(error, model, source, lines or {}, origins)) from error


def parse_setting(setting: str) -> tuple[tuple[str, ...], Any]:
    """Split ``section.key=value``; the value is read as YAML.

    Raises
    ------
    ConfigError
        If it is not of that form.
    """
    name, equals, text = setting.partition("=")
    keys = tuple(part.strip() for part in name.split("."))
    if not equals or len(keys) < 2 or not all(keys):
        raise ConfigError(f"--set expects section.key=value, got {setting!r}")
    try:
        return keys, yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ConfigError(f"--set {name}: the value is not YAML: {text!r}") from error


def config_text(config: BaseModel) -> str:
    """Write a configuration as YAML that :func:`read_config` reads back to the same."""
    return yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False, allow_unicode=True)


def template_text(model: type[BaseModel]) -> str:
    """Write every key with its default and its description as a comment."""
    return "\n".join(_template_lines(model, "")) + "\n"


# --- reading -------------------------------------------------------------------------


def read_yaml(path: Path) -> tuple[Document, dict[tuple[str, ...], int]]:
    """Parse a file into a document and the line of every key."""
    try:
        text = path.read_text(encoding="utf-8")
        tree = yaml.compose(text, Loader=yaml.SafeLoader)
        document = yaml.safe_load(text)
    except FileNotFoundError as error:
        raise ConfigError(
            f"{path}: no such configuration file: `shapemorph init` writes one"
        ) from error
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not a text file in UTF-8, expected YAML") from error
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: is not YAML: {_yaml_problem(error)}") from error
    if document is None:
        return {}, {}
    if not isinstance(document, dict):
        raise ConfigError(
            f"{path}: expected sections (`inputs:`, ...), got {type(document).__name__}"
        )
    return document, dict(_key_lines(tree, (), path))


def _yaml_problem(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    problem = getattr(error, "problem", None) or "unreadable"
    return f"{problem} (line {mark.line + 1})" if mark is not None else str(problem)


def _key_lines(
    node: yaml.Node | None, at: tuple[str, ...], path: Path
) -> Iterator[tuple[tuple[str, ...], int]]:
    """Yield the line of every key; a key that stands twice is an error."""
    if not isinstance(node, yaml.MappingNode):
        return
    seen: set[str] = set()
    for key, value in node.value:
        name, line = str(key.value), key.start_mark.line + 1
        if name in seen:
            raise ConfigError(f"{path} line {line}: {'.'.join((*at, name))} is given twice")
        seen.add(name)
        yield (*at, name), line
        yield from _key_lines(value, (*at, name), path)


def nested(keys: tuple[str, ...], value: Any) -> Document:
    """Make the document that holds one value under keys below each other."""
    for key in reversed(keys):
        value = {key: value}
    return typing.cast(Document, value)


def laid_over(document: Document, change: Document) -> Document:
    """Lay `change` over `document`, section by section."""
    merged = dict(document)
    for key, value in change.items():
        below = merged.get(key)
        if isinstance(value, dict) and (below is None or isinstance(below, dict)):
            merged[key] = laid_over(below or {}, value)
        else:
            merged[key] = value
    return merged


def absolute_paths(document: Document, model: type[BaseModel], base: Path) -> Document:
    """Resolve every key that the model calls a path against `base`."""
    resolved: Document = {}
    for key, value in document.items():
        field = model.model_fields.get(str(key))
        kinds = _kinds(field.annotation) if field else []
        below = _section_in(kinds)
        if isinstance(value, dict) and below:
            resolved[key] = absolute_paths(value, below, base)
        elif value is None and below and type(None) not in kinds:
            resolved[key] = {}  # a section whose keys are all commented out
        elif isinstance(value, str) and Path in kinds:
            resolved[key] = str(base / Path(value).expanduser())
        else:
            resolved[key] = value
    return resolved


def _kinds(annotation: Any) -> list[Any]:
    """List the members of a union, or the one type."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        return [kind for part in typing.get_args(annotation) for kind in _kinds(part)]
    return [annotation]


def _section_in(kinds: Sequence[Any]) -> type[BaseModel] | None:
    for kind in kinds:
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
    return None


# --- explaining ----------------------------------------------------------------------


def _explain(
    error: ValidationError,
    model: type[BaseModel],
    source: str,
    lines: dict[tuple[str, ...], int],
    origins: dict[tuple[str, ...], str],
) -> str:
    """Say in one line where, what was expected and what came, for the first problem."""
    problems = error.errors(include_url=False)
    first = problems[0]
    at = tuple(str(part) for part in first["loc"])
    text = f"{_origin(at, source, lines, origins)}: {_problem(first, at, model)}"
    more = len(problems) - 1
    return f"{text} (and {more} more)" if more else text


def _origin(
    at: tuple[str, ...],
    source: str,
    lines: dict[tuple[str, ...], int],
    origins: dict[tuple[str, ...], str],
) -> str:
    for keys, origin in reversed(origins.items()):
        if at[: len(keys)] == keys or keys[: len(at)] == at:
            return origin
    for length in range(len(at), 0, -1):
        if at[:length] in lines:
            return f"{source} line {lines[at[:length]]}"
    return source


def _problem(problem: Any, at: tuple[str, ...], model: type[BaseModel]) -> str:
    name = ".".join(at) or "the configuration"
    if problem["type"] == "extra_forbidden":
        return f"unknown key {name}; {_suggestion(at, model)}"
    if problem["type"] in _PLAIN_WORDS:
        words = _PLAIN_WORDS[problem["type"]].format(**problem.get("ctx", {}))
        return f"{name}: {words}, got {problem['input']!r}"
    reason = str(problem["msg"]).removeprefix("Value error, ")
    reason = reason[:1].lower() + reason[1:]
    if problem["type"] == "value_error":
        return f"{name}: {reason}"
    return f"{name}: {reason}, got {problem['input']!r}"


def _suggestion(at: tuple[str, ...], model: type[BaseModel]) -> str:
    """Name the nearest key, at this level or in any section."""
    section: type[BaseModel] | None = model
    for key in at[:-1]:
        field = section.model_fields.get(key) if section else None
        section = _section_in(_kinds(field.annotation)) if field else None
    known = list(section.model_fields) if section else []
    near = difflib.get_close_matches(at[-1], known, n=1, cutoff=0.6)
    if near:
        return f"did you mean {'.'.join((*at[:-1], near[0]))}?"
    elsewhere = [full for full in _all_keys(model) if full.rpartition(".")[2] == at[-1]]
    if elsewhere:
        return f"did you mean {elsewhere[0]}?"
    return f"known keys: {', '.join(known)}"


def _all_keys(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        yield prefix + name
        section = _section_in(_kinds(field.annotation))
        if section:
            yield from _all_keys(section, f"{prefix}{name}.")


# --- templates -----------------------------------------------------------------------


def _template_lines(model: type[BaseModel], indent: str) -> Iterator[str]:
    for name, field in model.model_fields.items():
        section = _section_in(_kinds(field.annotation))
        default = field.get_default(call_default_factory=True)
        if section is None:
            yield f"{indent}{name}:{_inline(default)}  # {_comment(field)}"
        elif default is None:
            yield f"{indent}{name}:  # {field.description}; empty or"
            yield from (f"{indent}#  {line}" for line in _template_lines(section, ""))
        else:
            yield from _section_head(section, field, name, indent)
            yield from _template_lines(section, indent + "  ")


def _section_head(section: type[BaseModel], field: Any, name: str, indent: str) -> Iterator[str]:
    if not indent:
        yield ""
    first_line = (section.__doc__ or "").strip().splitlines()[0]
    summary = field.description or first_line.removeprefix(f"Section `{name}`: ")
    yield f"{indent}{name}:  # {summary}"


def _comment(field: Any) -> str:
    """Give the description, then what is allowed."""
    parts = [field.description or ""]
    choices = [
        str(choice)
        for kind in _kinds(field.annotation)
        if typing.get_origin(kind) is typing.Literal
        for choice in typing.get_args(kind)
    ]
    if len(choices) > 1:
        parts.append("one of " + ", ".join(choices))
    return "; ".join(part for part in parts if part)


def _inline(value: Any) -> str:
    """Write a default as YAML after the colon of its key; nothing for None."""
    if value is None:
        return ""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=10_000)
    return " " + text.removesuffix("\n").removesuffix("\n...").strip()
