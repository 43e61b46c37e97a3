"""Error constants as a file: right on textbook methods, and stored as they are computed."""

import json
import math

import pytest

from campaigns.driver import fingerprint
from campaigns.error_constants import LARGEST, along_paths, forest_sums, main, row
from glmref.catalogue.lookup import data_root, load, names
from glmref.theory.trees import MAX_ORDER

FILE = data_root() / "measurements" / "error-constants.json"
ROWS = {x["method"]: x for x in json.loads(FILE.read_text(encoding="utf-8"))["methods"]}
RENEW = f"python -m campaigns.error_constants data/measurements/{FILE.name}"
SAMPLE = (
    *("rk4", "gauss-3", "bdf-3", "g6245", "gsymplectic-n", "stormer-verlet", "pair-rkn-6-8b"),
    "multistep-kinetic-8",
)


def test_residuals_are_those_of_the_textbooks():
    # the implicit midpoint rule: 1/4 - 1/3 for the bushy tree, 1/4 - 1/6 for the tall one
    found = row({"method": "implicit-midpoint"})
    assert (found["order"], found["trees"], found["nonzero"]) == (2, 2, 2)
    assert dict(map(tuple, found["largest"])) == {"[oo]": -0.0833333, "[[o]]": 0.0833333}
    # principal error norm of the classical method of order 4
    found = row({"method": "rk4"})
    assert (found["order"], found["trees"]) == (4, 9)
    assert found["norm"] == pytest.approx(0.0145, abs=5e-4)


def test_no_residual_is_listed_where_none_is():
    for name, stored in ROWS.items():
        sizes = [abs(x) for _, x in stored["largest"]]
        if stored["order"] >= MAX_ORDER:  # trees of the next order are not compared
            assert (stored["trees"], stored["nonzero"], stored["norm"], sizes) == (0, 0, 0, []), (
                name
            )
            continue
        assert sizes == sorted(sizes, reverse=True) and all(sizes), name
        assert len(sizes) == min(stored["nonzero"], LARGEST) and sizes, name
        # residual over symmetry is at most the residual, and the symmetry of p + 1 nodes at most p!
        most = math.sqrt(stored["nonzero"]) * sizes[0]
        assert sizes[0] / math.factorial(stored["order"]) <= 1.001 * stored["norm"], name
        assert stored["norm"] <= 1.001 * most, name


def test_paths_give_what_the_comparison_of_all_trees_gives():
    stored = ROWS["multistep-general-8"]  # of 89,894 trees one by one
    found = along_paths(load("multistep-general-8"), 8)
    assert found == {key: stored[key] for key in found}
    assert [2 * x for x in forest_sums(6, 0)] == [2, 4, 14, 52, 214, 916]


def test_every_method_is_stored_for_the_coefficients_as_they_are():
    stored = {name: x["fingerprint"] for name, x in ROWS.items()}
    assert stored == {name: fingerprint(name) for name in names("methods")}, RENEW


@pytest.mark.parametrize("name", SAMPLE)
def test_what_is_stored_is_what_is_computed(name):
    stored = {k: x for k, x in ROWS[name].items() if k not in ("method", "fingerprint")}
    assert row({"method": name}) == stored
    assert row({"method": "ab-4"}) != stored


def test_only_what_has_changed_is_computed_again(tmp_path, monkeypatch):
    import campaigns.error_constants as module

    monkeypatch.setattr(module, "names", lambda kind: ["euler", "heun-2"])
    rows = [dict(ROWS["euler"]), dict(ROWS["heun-2"])]
    rows[0] |= {"fingerprint": "of another tableau", "norm": 7.0}
    path = tmp_path / "constants.json"
    path.write_text(json.dumps({"methods": rows}), encoding="utf-8")
    assert main(path) == 1
    assert json.loads(path.read_text("utf-8"))["methods"] == [ROWS["euler"], ROWS["heun-2"]]
    assert main(path) == 0
