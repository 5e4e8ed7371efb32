"""The configuration refuses what it cannot do."""

import pytest
from pydantic import ValidationError

from shapemorph.config import CorrelateConfig, RegionConfig, ReportConfig, RunConfig, StrainConfig


def test_unknown_keys_are_errors():
    with pytest.raises(ValidationError, match="subset_radius"):
        RunConfig.model_validate({"correlate": {"subset_radius": 10}})


def test_every_default_is_valid_and_survives_a_round_trip():
    config = RunConfig()
    assert RunConfig.model_validate(config.model_dump(mode="json")) == config


@pytest.mark.parametrize(
    ("section", "values", "message"),
    [
        (CorrelateConfig, {"subset_size": 20}, "odd"),
        (CorrelateConfig, {"subset_size": 15, "spacing": 16}, "gaps"),
        (StrainConfig, {"window": 4}, "odd"),
        (RegionConfig, {"centre": (0, 0, 0)}, "both or neither"),
        (RegionConfig, {"radius": -1.0, "centre": (0, 0, 0)}, "greater than 0"),
        (CorrelateConfig, {"order": True}, "no true"),
        (CorrelateConfig, {"min_zncc": False}, "no false"),
    ],
)
def test_impossible_values_say_why(section, values, message):
    with pytest.raises(ValidationError, match=message):
        section.model_validate(values)


def test_switches_take_true_and_false():
    assert not ReportConfig.model_validate({"figures": False}).figures


def test_sections_cannot_be_changed_after_they_were_made():
    config = CorrelateConfig()
    with pytest.raises(ValidationError, match="frozen"):
        config.order = 2


def test_a_limit_of_random_errors_that_is_given_stays():
    assert CorrelateConfig().with_certainty().max_sigma == 0.06
    assert CorrelateConfig(max_sigma=2.0).with_certainty().max_sigma == 2.0


def test_paper_mode_has_its_own_defaults_and_keeps_what_is_given():
    paper = CorrelateConfig(mode="paper")
    sizes = (paper.subset_size, paper.spacing, paper.search, paper.tolerance, paper.refinements)
    assert sizes == (21, 8, 41, 0.1, 0)
    given = CorrelateConfig(mode="paper", subset_size=31, spacing=None, refinements=2)
    assert (given.subset_size, given.spacing, given.refinements) == (31, 8, 2)
    assert CorrelateConfig().tolerance < 0.1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"order": 2}, "order must be 1"),
        ({"subset_size": 51}, "no room"),
        ({"search": 40}, "odd"),
        ({"seeds": "propagate"}, "leave seeds out"),
        ({"interpolation": "quintic"}, "interpolation must be cubic"),
    ],
)
def test_what_paper_mode_cannot_do_is_refused(change, words):
    with pytest.raises(ValidationError, match=words):
        CorrelateConfig(**({"mode": "paper"} | change))


def test_islands_are_not_morphed_through_one_warp_unless_that_is_asked_for():
    assert CorrelateConfig(seeds="propagate").refinements == 0
    assert CorrelateConfig(seeds="propagate", refinements=1).refinements == 1
