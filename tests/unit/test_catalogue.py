"""catalogue.py: names and paths find files, near misses are named, nothing else is opened."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import glmref
from glmref.catalogue.lookup import document, load, names, path_of
from glmref.catalogue.strict_json import read_json
from glmref.engine.ensemble import solve_ensemble
from glmref.errors import DataError, UsageError
from tests.build import refused


def test_a_shipped_name_wins_over_a_file_of_that_name(tmp_path, monkeypatch):
    (tmp_path / "rk4").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert path_of("rk4").name == "rk4.json"
    assert path_of("./rk4") == Path("rk4")


def test_a_near_miss_names_what_was_meant() -> None:
    refused(UsageError, "did you mean gauss-2", load, "gaus-2")
    refused(UsageError, "see `glmref list`", load, "completely-different")


def test_a_file_without_an_object_is_a_data_error(tmp_path: Path) -> None:
    file = tmp_path / "list.json"
    file.write_text("[]")
    refused(DataError, r"list.json: a method file must hold one JSON object", document, file)


@pytest.mark.slow
def test_documents_are_the_files_byte_for_byte() -> None:
    for name in names("all"):
        path = path_of(name)
        assert document(name) == read_json(path) == json.loads(path.read_bytes())


def test_what_is_wrong_on_purpose_is_named_only_where_it_is_asked_for() -> None:
    wrong = set(names("broken"))
    assert "yoshida-4-sign" in wrong and not wrong & set(glmref.names())
    with pytest.raises(UsageError, match=r"no method named 'yoshida-4-sgin'; .*") as refusal:
        load("yoshida-4-sgin")
    assert "yoshida-4-sign" not in str(refusal.value)
    for name in wrong:  # one letter less: no file that is wrong on purpose is proposed
        with pytest.raises(UsageError) as refusal:
            path_of(name[:-1] + "_")
        told = re.findall(r"[a-z0-9.-]+(?= or |\?)", str(refusal.value))
        assert not wrong & set(told)
    refused(UsageError, "did you mean broken", names, "brokn")


def test_a_method_that_is_wrong_on_purpose_is_refused_by_name_and_runs_as_an_object() -> None:
    with pytest.raises(
        UsageError, match=r"wrong on purpose; .* give glmref.load\('yoshida-4-sign'\)"
    ):
        glmref.solve("kepler", "yoshida-4-sign", h=0.01, steps=2)
    found = glmref.solve("kepler", load("yoshida-4-sign"), h=0.01, steps=2)
    why = document("yoshida-4-sign")["broken"]["why"]
    assert found.notices == (f"yoshida-4-sign is wrong on purpose: {why}",)
    assert glmref.solve("kepler", "yoshida-4", h=0.01, steps=2).notices == ()


@pytest.mark.slow
def test_an_ensemble_says_so_too() -> None:
    initial = [glmref.problem("kepler").y0] * 3
    with pytest.raises(UsageError, match="wrong on purpose"):
        solve_ensemble("kepler", "yoshida-4-sign", initial, h=0.01, steps=2)
    found = solve_ensemble("kepler", load("yoshida-4-sign"), initial, h=0.01, steps=2)
    assert found.notices[0].startswith("yoshida-4-sign is wrong on purpose: ")
    assert solve_ensemble("kepler", "yoshida-4", initial, h=0.01, steps=2).notices == ()


def test_the_nearest_problem_and_parameter_are_named() -> None:
    refused(UsageError, "did you mean kepler", glmref.problem, "keppler")
    with pytest.raises(UsageError, match="did you mean eccentricity"):
        glmref.problem("kepler", excentricity="1/2")  # codespell:ignore
