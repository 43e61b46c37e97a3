"""Extended phase space: two copies move as the system does; the page says what was measured."""

from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.extended import METHODS, doubled, evaluations
from glmref import solve
from glmref.problems import problem

PAGE = Path(__file__).parents[2] / "docs" / "nonseparable.md"
RECORD = measured("nonseparable")
ROWS = {x["problem"]: x["methods"] for x in RECORD["extended"] if x["tolerance"] == 1e-9}


@pytest.mark.slow
def test_both_copies_follow_the_system() -> None:
    one = problem("swinging-atwood")
    m, two = one.dimension // 2, doubled(one)
    assert two.separable
    expected = solve(one, "gauss-6", h=0.01, steps=100).y[-1]
    q, y, p, x = solve(two, "kahan-li-8", h=0.01, steps=100).y[-1].reshape(4, m)
    assert np.abs(np.r_[q, p] - expected).max() < 1e-12
    assert np.abs(np.r_[-x, y] - expected).max() < 1e-12


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    found = evaluations(problem("uneven-plane"), 30.0, "kahan-li-8")
    assert found[1e-9] == ROWS["uneven-plane"]["kahan-li-8"]


def test_the_page_gives_the_means() -> None:
    multistep = {
        x["problem"]: x["methods"] for x in RECORD["evaluations"] if x["tolerance"] == 1e-9
    }
    assert ROWS.keys() == multistep.keys()
    means = []
    for name in ("multistep-general-8b", "multistep-general-8"):
        ratios = [multistep[k][name] / min(x.values()) for k, x in ROWS.items()]
        means.append(f"{np.exp(np.mean(np.log(ratios))):.2f}")
    assert all(set(x) == set(METHODS) for x in ROWS.values())
    assert (
        f"`-8b` and `-8` need {means[0]} and {means[1]} of the best of five splittings"
        in PAGE.read_text("utf-8")
    )
