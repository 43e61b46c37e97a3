"""Exact coefficients beyond double precision: what rounds them refuses them in one sentence."""

import json
from pathlib import Path

import pytest

import glmref
from glmref.cli import main
from glmref.errors import DataError

LARGE = "1" + "0" * 400
METHODS = {
    "rk": {"A": [["0", "0"], [LARGE, "0"]], "b": ["1/2", "1/2"]},
    "implicit": {"A": [[LARGE]], "b": ["1"]},
    "lmm": {"alpha": ["-1", f"1/{LARGE}"], "beta": ["0", "1"]},
    "splitting": {"class": "splitting", "a": [LARGE, "1"], "b": ["1", "0"], "first": "q"},
}


@pytest.mark.parametrize("kind", METHODS)
@pytest.mark.parametrize("command", ["analyze", "export", "plot", "solve"])
def test_a_coefficient_beyond_doubles_is_no_internal_error(kind, command, tmp_path, capsys):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(METHODS[kind]))
    if command == "solve":
        with pytest.raises(DataError, match="beyond double precision"):
            glmref.solve("kepler", glmref.load(path), h=0.1, t_end=1)
        return
    given = {"analyze": ["analyze"], "export": ["export", "--to", "c"],
             "plot": ["show", "--plot", str(tmp_path / "x.svg")]}[command]  # fmt: skip
    code = main([*given, str(path)])
    said = capsys.readouterr().err
    assert "internal" not in said and (code in (0, 3) if command == "analyze" else code == 2)


def test_an_error_norm_beyond_doubles_is_infinite(tmp_path: Path) -> None:
    method = glmref.from_rk([["0", "0"], ["1" + "0" * 200, "0"]], ["1/2", "1/2"])
    assert glmref.analyze(method).error_norm == float("inf")
