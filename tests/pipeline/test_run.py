"""The runner on small fake stages and a store in memory."""

import pytest

from shapemorph.config import MatchConfig, MorphConfig, Section, StrainConfig
from shapemorph.core.errors import ConfigError, StageError
from shapemorph.pipeline.run import (
    Results,
    Stage,
    dependents,
    fingerprints,
    outdated_stages,
    run_stages,
    stages_until,
)


class MemoryStore:
    def __init__(self):
        self.kept = {}
        self.loaded = []

    def fingerprint(self, name):
        return self.kept[name][0] if name in self.kept else None

    def load(self, name):
        self.loaded.append(name)
        return self.kept[name][1]

    def save(self, name, noun, *, fingerprint, seconds):
        assert seconds >= 0
        self.kept[name] = (fingerprint, noun)


class Texts:
    """Sources: texts by name, counting what is loaded."""

    def __init__(self, **texts):
        self.texts = texts
        self.loaded = []

    def fingerprint(self, name):
        return f"mark of {self.texts[name]}"

    def load(self, name):
        self.loaded.append(name)
        return self.texts[name]


STAGES = (
    Stage("match", lambda a, section: f"{a}|{section.ratio}", ("left",)),
    Stage("morph", lambda m, section: f"{m}|{section.images}", ("match",)),
    Stage("strain", lambda m, b, section: f"{m}+{b}|{section.window}", ("match", "right")),
)


class Bench:
    """One run after another over the same store."""

    def __init__(self):
        self.store = MemoryStore()
        self.sources = Texts(left="L", right="R")
        self.sections: dict[str, Section] = {
            "match": MatchConfig(),
            "morph": MorphConfig(),
            "strain": StrainConfig(),
        }

    def run(self, forced=(), stages=STAGES):
        events = []
        self.sources.loaded.clear()
        wanted = fingerprints(stages, self.sections, self.sources)
        outdated = outdated_stages(stages, wanted, self.store, set(forced))
        results = Results(self.sources, self.store, stages)
        run_stages(stages, self.sections, results, self.store, outdated, events.append)
        return [event.name for event in events if event.state == "finished"]


def test_results_flow_by_name_in_the_order_of_reads():
    bench = Bench()
    assert bench.run() == ["match", "morph", "strain"]
    assert bench.store.kept["strain"][1] == "L|0.85+R|5"


def test_a_second_run_runs_nothing_and_loads_nothing():
    bench = Bench()
    bench.run()
    bench.store.loaded.clear()
    assert bench.run() == []
    assert bench.sources.loaded == []
    assert bench.store.loaded == []


def test_a_changed_section_reruns_its_stage_and_what_reads_it():
    bench = Bench()
    bench.run()
    bench.sections["morph"] = MorphConfig(images=4)
    assert bench.run() == ["morph"]
    bench.sections["match"] = MatchConfig(ratio=0.7)
    assert bench.run() == ["match", "morph", "strain"]
    assert bench.store.kept["morph"][1] == "L|0.7|4"


def test_a_changed_source_reruns_only_what_depends_on_it():
    bench = Bench()
    bench.run()
    bench.sources.texts["right"] = "other"
    bench.store.loaded.clear()
    assert bench.run() == ["strain"]
    assert bench.store.loaded == ["match"]
    assert bench.sources.loaded == ["right"]


def test_going_back_to_an_earlier_section_runs_again_and_gives_the_same():
    bench = Bench()
    bench.run()
    before = dict(bench.store.kept)
    bench.sections["morph"] = MorphConfig(images=4)
    bench.run()
    bench.sections["morph"] = MorphConfig()
    assert bench.run() == ["morph"]
    assert bench.store.kept == before


def test_a_failed_stage_keeps_what_was_finished_and_is_tried_again():
    bench = Bench()

    def fail(*_):
        raise StageError("nothing valid")

    broken = (STAGES[0], Stage("morph", fail, ("match",)), STAGES[2])
    with pytest.raises(StageError):
        bench.run(stages=broken)
    assert set(bench.store.kept) == {"match"}
    assert bench.run() == ["morph", "strain"]


@pytest.mark.parametrize("name", ["match", "morph", "strain"])
def test_a_result_that_cannot_be_stored_ends_the_run(name):
    bench = Bench()
    save = bench.store.save

    def save_but_one(stage, *arguments, **named):
        if stage == name:
            raise OSError("disk full")
        save(stage, *arguments, **named)

    bench.store.save = save_but_one
    with pytest.raises(OSError, match="disk full"):
        bench.run()
    assert name not in bench.store.kept


def test_a_forced_stage_takes_along_what_reads_it():
    bench = Bench()
    bench.run()
    assert bench.run(forced=dependents(STAGES, "match")) == ["match", "morph", "strain"]
    assert bench.run(forced=dependents(STAGES, "morph")) == ["morph"]


def test_a_key_whose_content_is_read_elsewhere_does_not_count_twice():
    bench = Bench()
    stage = Stage("match", STAGES[0].run, ("left",), elsewhere=frozenset({"max_rounds"}))
    bench.run(stages=(stage,))
    bench.sections["match"] = MatchConfig(max_rounds=1)
    assert bench.run(stages=(stage,)) == []
    bench.sections["match"] = MatchConfig(ratio=0.5)
    assert bench.run(stages=(stage,)) == ["match"]


def test_an_unknown_stage_is_a_config_error_that_lists_the_known_ones():
    assert [stage.name for stage in stages_until(STAGES, "morph")] == ["match", "morph"]
    with pytest.raises(ConfigError, match=r"match, morph, strain.*'morhp'"):
        stages_until(STAGES, "morhp")
