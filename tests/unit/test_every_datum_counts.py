"""Every datum of a method file is used: a run or a verdict that fails where one is ignored.

Expected values are computed here from the documents, in a few lines of plain Python each.
"""

import copy
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from glmref import Problem, solve
from glmref.catalogue.files import document
from glmref.catalogue.lookup import load, names
from glmref.catalogue.reader import load_document
from glmref.engine.solve import ENGINES
from glmref.findings import Verdict
from glmref.prove.verifier import verify

H = 0.5
RIGHT = Problem(f=("y[1] - t*t", "-y[0] + t"), y0=("3/4", "1/3"), t_span=(0.25, 2.0))


def f(t: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1] - t * t, -y[0] + t])


def numbers(texts: Any) -> np.ndarray:
    return np.vectorize(lambda x: float(Fraction(x)))(np.array(texts))


def explicit_step(A: Any, c: Any, t: float, y: np.ndarray) -> list[np.ndarray]:
    """Slopes of an explicit Runge-Kutta step from y."""
    slopes: list[np.ndarray] = []
    for row, time in zip(numbers(A), numbers(c), strict=True):
        at = y + H * sum((a * k for a, k in zip(row, slopes, strict=False)), np.zeros(2))
        slopes.append(f(t + time * H, at))
    return slopes


def step_of(method: Any, engine: str, **options: Any) -> Any:
    return solve(RIGHT, method, h=H, steps=1, engine=engine, **options)


OWN_C = {
    "format": "glmref-method-2",
    "name": "own-c",
    "class": "rk",
    "A": [["0", "0"], ["1/2", "0"]],
    "b": ["1/4", "3/4"],
    "c": ["1/5", "2/3"],  # A 1 is (0, 1/2)
}


@pytest.mark.parametrize("engine", ENGINES)
def test_the_abscissae_of_the_file_are_those_at_which_f_is_evaluated(engine: str) -> None:
    y = np.array([0.75, 1 / 3])
    slopes = explicit_step(OWN_C["A"], OWN_C["c"], 0.25, y)
    wanted = y + H * (slopes[0] / 4 + 3 * slopes[1] / 4)
    found = step_of(load_document(OWN_C), engine)
    np.testing.assert_allclose(found.y[-1], wanted, rtol=1e-15)
    plain = step_of(load_document({k: x for k, x in OWN_C.items() if k != "c"}), engine)
    assert np.abs(plain.y[-1] - wanted).max() > 0.01


@pytest.mark.parametrize("engine", ENGINES)
def test_the_output_of_the_file_is_the_solution(engine: str) -> None:
    keys = {"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["0"]], "V": [["1", "0"], ["1", "0"]]}
    late = {"format": "glmref-method-1", "name": "late", "class": "glm", **keys}
    found = step_of(load_document({**late, "output": ["0", "1"]}), engine, start="zero")
    np.testing.assert_allclose(found.y[-1], found.values[1], rtol=1e-15)
    assert np.abs(found.values[0] - found.values[1]).max() > 0.01
    first = step_of(load_document(late), engine, start="zero")
    np.testing.assert_allclose(first.y[-1], first.values[0], rtol=1e-15)


def explicit_block(name: str, key: str) -> Any:
    """The block of a file, ``None`` where it has none that is computed here."""
    block = document(name).get(key)
    try:
        A = None if block is None else numbers(block["A"])
        return None if A is None or np.triu(A).any() else block
    except ValueError:  # radicals or decimals of other blocks
        return None


def with_block(key: str) -> list[str]:
    found = [n for n in names("methods") if explicit_block(n, key) and load(n).parts == 1]
    return [n for n in found if all(map(_is_plain, document(n)[key].values()))][:4]


def _is_plain(block: Any) -> bool:
    try:
        numbers(block if isinstance(block, list) else "0")
    except ValueError:
        return False
    return True


def slopes_of(A: Any, t: float, y: np.ndarray) -> Any:
    """Slopes at the stages of a block, whose c is A 1."""
    return explicit_step(A, [str(sum(map(Fraction, row))) for row in A], t, y)


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("engine", ENGINES)
def test_the_start_of_the_file_makes_the_first_values(engine: str) -> None:
    chosen = with_block("starting")
    assert chosen
    for name in chosen:
        start = document(name)["starting"]
        slopes = np.array(slopes_of(start["A"], 0.25, y := np.array([0.75, 1 / 3])))
        u, B = numbers(start["u"]), numbers(start["B"])
        wanted = np.outer(u, y) + H * B @ slopes
        found = step_of(name, engine, history=True, every=1)
        # each sum of n products is rounded n times, the slopes twice more, by its terms' size
        size = np.outer(np.abs(u), np.abs(y)) + H * np.abs(B) @ np.abs(slopes)
        assert (np.abs(found.history[0] - wanted) <= (len(slopes) + 4) * 2.0**-53 * size).all()
        assert np.abs(wanted[1:] - step_of(name, engine, start="zero", history=True, every=1)
                      .history[0][1:]).max() > 1e-6  # fmt: skip


@pytest.mark.sampled(0)
@pytest.mark.parametrize("engine", ENGINES)
def test_the_finish_of_the_file_makes_the_solution(engine: str) -> None:
    chosen = with_block("finishing")
    assert chosen
    for name in chosen:
        end = document(name)["finishing"]
        found = step_of(name, engine, history=True)
        z = found.history[-1][0]
        slopes = slopes_of(end["A"], 0.25 + H, z)
        wanted = z + H * numbers(end["b"]) @ np.array(slopes)
        np.testing.assert_allclose(found.y[-1], wanted, rtol=1e-14)
        assert np.abs(wanted - z).max() > 1e-6


@pytest.mark.parametrize("engine", ENGINES)
def test_a_row_of_embedded_replaces_the_weights(engine: str) -> None:
    doc = document("bogacki-shampine-3-2")
    slopes = explicit_step(doc["A"], doc["c"], 0.25, y := np.array([0.75, 1 / 3]))
    method = load("bogacki-shampine-3-2")
    results = []
    for weights, chosen in (
        (doc["b"], method),
        (doc["embedded"][0]["b"], method.with_row(method.embedded[0])),
    ):
        results.append(step_of(chosen, engine).y[-1])
        wanted = y + H * numbers(weights) @ np.array(slopes)
        np.testing.assert_allclose(results[-1], wanted, rtol=1e-15)
    assert np.abs(results[0] - results[1]).max() > 1e-4


@pytest.mark.parametrize("name", ["bogacki-shampine-3-2", "dormand-prince-5-4"])
def test_a_coefficient_of_the_dense_output_counts(name: str) -> None:
    doc = copy.deepcopy(document(name))
    claims = {k: x for k, x in doc["claims"].items() if k.startswith("dense")}
    assert len(claims) == 2
    doc["claims"] = claims
    assert {x.verdict for x in verify(load_document(doc))} == {Verdict.HOLDS}
    row = next(i for i, x in enumerate(doc["dense"]) if set(x) != {"0"})
    doc["dense"][row][-1] = str(Fraction(doc["dense"][row][-1]) + Fraction(1, 1000))
    assert {x.verdict for x in verify(load_document(doc))} == {Verdict.FAILS}
