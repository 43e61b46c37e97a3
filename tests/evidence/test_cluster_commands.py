"""Every command that takes ``--on`` gives the same here, in processes and on a Dask cluster."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from glmref.cli import main
from glmref.compute import Records
from glmref.conformance.generate import write as write_vectors
from tests.evidence.test_cluster_kills import Cluster

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("distributed") is None, reason="dask is not installed"),
]

ROOT = Path(__file__).parents[2]
#: What depends on the clock or the machine.
TIMES = {"sha256", "seconds", "start_seconds", "build_seconds", "where"}
CAMPAIGN = """\
format = "glmref-campaign-1"
name = "small"
title = "A small campaign"
question = "Is it the same?"
kind = "resonance"

[fixed]
steps = 200

[grid]
method = ["gsymplectic-p", "leapfrog-one-leg"]
h = [0.1, 0.2]

[sample]
count = 5
frequency = { from = 1, to = 4 }
"""
#: Two tables to audit: Heun's method, and the same with a wrong weight.
TABLES = """\
# Runge-Kutta methods
import numpy as np

class Heun:
    A = np.array([[0, 0], [1, 0]])
    b = np.array([1/2, 1/2])
    c = np.array([0, 1])

class Wrong:
    A = np.array([[0, 0], [1, 0]])
    b = np.array([1/2, 1/3])
    c = np.array([0, 1])
"""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    yield made
    made.kill()


@pytest.fixture
def places(cluster: Cluster) -> list[str]:
    return ["here", "local:2", f"dask:{cluster.file}"]


@pytest.mark.parametrize(
    "words",
    [
        ["verify", "rk4", "gauss-2", "gsymplectic-p", "--no-cache", "--format", "csv"],
        ["audit", "TABLES", "--all", "--fast"],
        ["derive", "search", "--ansatz", "ANSATZ", "--starts", "64"],
    ],
    ids=lambda words: words[0],
)
def test_a_command_says_the_same(words, places, tmp_path, capsys):
    (tmp_path / "tables.py").write_text(TABLES, encoding="utf-8")
    known = {"TABLES": str(tmp_path), "ANSATZ": str(ROOT / "tests" / "unit" / "three-stages.toml")}
    words, said = [known.get(x, x) for x in words], []
    for on in places:
        code = main([*words, "--on", on])
        said.append((code, capsys.readouterr().out))
    assert said[0] == said[1] == said[2]
    assert said[0][0] in (0, 1) and said[0][1].count("\n") > 1


def test_runs_of_a_scene_have_the_same_records(places: list[str], tmp_path: Path) -> None:
    records = []
    for on in places:
        folder = tmp_path / on[:4]
        assert main(["run", "no-field", "--quick", "--output", str(folder), "--on", on]) == 0
        (file,) = folder.glob("*.sqlite")
        found = Records(file)
        records.append({x["key"]: {k: y for k, y in x.items() if k not in TIMES} for x in found})
    assert records[0] == records[1] == records[2] and len(records[0]) > 10


def test_a_campaign_has_the_same_records(places: list[str], tmp_path: Path) -> None:
    file, records = tmp_path / "small.toml", []
    file.write_text(CAMPAIGN, encoding="utf-8")
    for on in places:
        folder = tmp_path / on[:4]
        assert main(["campaign", str(file), "--output", str(folder), "--on", on]) == 0
        records.append({x["key"]: x for x in Records(folder / "small" / "records.sqlite")})
    assert records[0] == records[1] == records[2] and len(records[0]) == 20


def test_conformance_vectors_are_the_same_to_the_byte(places: list[str], tmp_path: Path) -> None:
    files = []
    for on in places:
        folder = tmp_path / on[:4]
        folder.mkdir()
        write_vectors(folder, ["rk4", "leapfrog-one-leg"], on=on)
        files.append({x.name: x.read_bytes() for x in folder.iterdir()})
    assert files[0] == files[1] == files[2] and len(files[0]) == 3
