"""The doctor finds what is missing and names one command."""

import numba
import pytest

from shapemorph.pipeline import doctor


def test_a_package_that_does_not_load_comes_with_its_reason_and_pip():
    finding = doctor._package("no_such_module", "no-such-package")
    assert not finding.ok
    assert "no_such_module" in finding.detail
    assert finding.remedy.endswith("-m pip install no-such-package")


def test_a_package_that_loads_has_its_version():
    assert doctor._package("yaml", "PyYAML").ok


@pytest.mark.parametrize(("user", "command"), [(0, "apt-get"), (1000, "sudo apt-get")])
def test_a_missing_library_comes_with_the_command_of_this_user(monkeypatch, user, command):
    monkeypatch.setattr(doctor.os, "geteuid", lambda: user)
    finding = doctor._library("libnosuch.so.1", "libnosuch1", "VTK")
    assert not finding.ok
    assert finding.remedy == f"{command} install --no-install-recommends -y libnosuch1"


def test_a_picture_that_is_blank_is_not_rendering(monkeypatch):
    monkeypatch.setattr(doctor, "_RENDER", "assert False, 'the picture is blank'")
    finding = doctor._rendering()
    assert not finding.ok
    assert "blank" in finding.detail
    assert "libegl1" in finding.remedy


def test_a_process_that_dies_without_words_is_a_finding():
    assert doctor._try("import os; os._exit(11)") == "ended with code 11"


def test_a_kernel_cache_that_cannot_be_written_is_a_finding(monkeypatch):
    import shapemorph.kernels  # noqa: F401 - it sets the place of the cache

    monkeypatch.setattr(numba.config, "CACHE_DIR", "/proc/no/cache")
    finding = doctor._kernel_cache()
    assert not finding.ok
    assert "NUMBA_CACHE_DIR" in finding.remedy
