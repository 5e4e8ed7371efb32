"""Configuration files: round trips, and one clear line for every mistake."""

from pathlib import Path

import pytest
import yaml

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.config_files import (
    check_config,
    config_text,
    parse_setting,
    read_config,
    template_text,
)


def _write(folder, text):
    path = folder / "case.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_template_is_the_defaults_and_explains_every_key(tmp_path):
    text = template_text(RunConfig)
    assert read_config(_write(tmp_path, text), RunConfig) == RunConfig()
    for section in RunConfig.model_fields.values():
        fields = getattr(section.annotation, "model_fields", {})
        for name, field in fields.items():
            assert f"  {name}:" in text
            assert field.description in text


def test_a_config_as_used_reads_back_to_the_same(tmp_path):
    document = {"inputs": {"region": {"centre": [1, 2, 3], "radius": 0.5}, "units": "cm"}}
    config = RunConfig.model_validate(document)
    assert read_config(_write(tmp_path, config_text(config)), RunConfig) == config


def test_paths_are_relative_to_the_file_and_settings_to_the_current_directory(
    tmp_path, monkeypatch
):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    text = "inputs:\n  reference: a.obj\n  region: {mask: m.png}\n"
    config = read_config(_write(tmp_path, text), RunConfig, ["inputs.deformed=b.obj"])
    assert config.inputs.reference == tmp_path / "a.obj"
    assert config.inputs.region.mask == tmp_path / "m.png"
    assert config.inputs.deformed == tmp_path / "elsewhere" / "b.obj"


def test_settings_come_over_the_file_and_leave_the_rest(tmp_path):
    path = _write(tmp_path, "correlate: {spacing: 4, order: 2}\n")
    config = read_config(path, RunConfig, ["correlate.spacing=6", "correlate.subset_size=31"])
    assert (config.correlate.spacing, config.correlate.order) == (6, 2)
    assert config.correlate.subset_size == 31


def test_a_section_with_all_keys_commented_out_is_the_defaults(tmp_path):
    assert read_config(_write(tmp_path, "strain:\n  # window: 7\n"), RunConfig) == RunConfig()


def test_an_empty_file_is_the_defaults(tmp_path):
    assert read_config(_write(tmp_path, ""), RunConfig) == RunConfig()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "strain:\n  windw: 5\n",
            r"case\.yaml line 2: unknown key strain\.windw; did you mean strain\.window\?",
        ),
        ("strian: {window: 5}\n", r"unknown key strian; did you mean strain\?"),
        ("flatten: {subset_size: 21}\n", r"did you mean correlate\.subset_size\?"),
        ("strain: {foo: 1}\n", r"unknown key strain\.foo; known keys: window"),
        ("strain: {window: wide}\n", r"strain\.window: expected a whole number, got 'wide'"),
        ("strain: 5\n", r"strain: expected a section of keys, got 5"),
        ("strain: {window: 4}\n", r"strain: window must be odd, got 4"),
        ("flatten: {method: arapp}\n", r"flatten\.method: expected 'auto'.* got 'arapp'"),
        ("strain: {window: 1}\n", r"strain\.window: expected 3 or more, got 1"),
        (
            "inputs: {region: {polygon: [[0, 0], [9, 9]]}}\n",
            r"polygon: expected 3 or more entries, got",
        ),
        (
            "align: {method: landmarks, rigid_region: {centre: [0, 0, 0], radius: 1}}\n",
            r"rigid_region is for method icp.*got method landmarks",
        ),
        ("strain: {window: 5}\nstrain: {window: 7}\n", r"line 2: strain is given twice"),
        ("strain: [\n", r"is not YAML: .*line"),
        ("- a\n- b\n", r"expected sections .* got list"),
        ("strain: {foo: 1, bar: 2}\n", r"\(and 1 more\)"),
    ],
)
def test_a_mistake_is_one_line_that_says_where_and_what(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message) as caught:
        read_config(_write(tmp_path, text), RunConfig)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("strain.window", "section.key=value"),
        ("window=5", "section.key=value"),
        ("strain.window=[", "not YAML"),
        ("strain.windw=5", r"--set strain.windw=5: .*strain\.window"),
        ("strain.window=4", r"--set strain.window=4: strain: window must be odd"),
    ],
)
def test_a_mistaken_setting_is_named(setting, message):
    with pytest.raises(ConfigError, match=message):
        check_config({}, RunConfig, [setting])


@pytest.mark.parametrize(
    ("text", "value"),
    [("a.b=1", 1), ("a.b=[1, 2]", [1, 2]), ("a.b=", None), ("a.b=x=y", "x=y"), ("a.b=true", True)],
)
def test_values_of_settings_are_yaml(text, value):
    assert parse_setting(text) == (("a", "b"), value)


def test_exponents_without_a_point_are_numbers():
    assert check_config({}, RunConfig, ["correlate.tolerance=1e-4"]).correlate.tolerance == 1e-4


def test_a_missing_file_and_a_file_that_is_no_text_are_config_errors(tmp_path):
    with pytest.raises(ConfigError, match="no such configuration"):
        read_config(Path("absent.yaml"), RunConfig)
    (tmp_path / "case.yaml").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ConfigError, match="UTF-8"):
        read_config(tmp_path / "case.yaml", RunConfig)


def test_yaml_that_would_make_objects_is_refused(tmp_path):
    text = "inputs: !!python/object/apply:os.getcwd []\n"
    with pytest.raises(ConfigError, match="not YAML"):
        read_config(_write(tmp_path, text), RunConfig)
    assert yaml.safe_load(template_text(RunConfig))["version"] == 1
