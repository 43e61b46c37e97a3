"""Search and Newton: reproducible, resumable, and honest about where they stop."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from glmref.derive.ansatz import Ansatz, Value
from glmref.derive.parameters import RankError, fix_parameters, pivots
from glmref.derive.polish import ConvergenceError, polish
from glmref.derive.search import evaluate, levenberg_marquardt, search
from glmref.errors import DataError, UsageError
from glmref.exact import Exact
from glmref.exact.judging import as_number, consulted, coordinates, rounded
from glmref.prove.enclosure import conditions_of, gaps_of
from tests.build import refused

S3 = Ansatz("x", 3, 6, stage_order=2)


def test_complex_step_gives_the_jacobian_of_the_gradients() -> None:
    document = S3.document()
    point = [0.4, 0.3, -0.2, 0.7, 0.5, -0.6]
    values, jacobian = evaluate(gaps_of(document), np.array([point, [2 * x for x in point]]))
    with consulted():
        at = coordinates([rounded(as_number(Exact(Fraction(x)))) for x in point])
        exactly = conditions_of(document).residuals(at)
        expected = [[float(x.by[k]) if k in x.by else 0 for k in range(6)] for x in exactly]
        # Round-off of some hundred operations on numbers of size 1.
        assert np.allclose(values[0], [float(x.value) for x in exactly], atol=1e-14)
    assert np.allclose(jacobian[0], expected, rtol=1e-12, atol=1e-13)


@pytest.mark.slow
def test_starts_do_not_influence_each_other() -> None:
    gaps, size = gaps_of(S3.document()), len(S3.document()["unknowns"])

    def draw(generator: np.random.Generator) -> np.ndarray:
        return generator.normal(size=size)

    one = list(search(gaps, draw, seed=3, starts=6, iterations=20))
    two = list(search(gaps, draw, seed=3, starts=4, first=2, iterations=20, batch=3))
    assert [x.number for x in two] == [2, 3, 4, 5]
    for a, b in zip(one[2:], two, strict=True):
        assert np.allclose(a.point, b.point, rtol=1e-6)


def test_levenberg_marquardt_stops_at_a_least_squares_point_without_a_root() -> None:
    points, sizes = levenberg_marquardt(
        lambda v: [v[0] * v[0] + 1, v[1] - 2], np.array([[0.5, 0.0]])
    )
    assert abs(points[0][0]) < 1e-3
    assert sizes[0] == pytest.approx(1.0, abs=1e-5)


def test_newton_says_when_there_is_no_root_or_a_double_one() -> None:
    refused(ConvergenceError, "", polish, lambda v: [v[0] * v[0] + 1], [Exact(Fraction(3, 10))])
    with pytest.raises(ConvergenceError, match=r"multiple|singular"):
        polish(lambda v: [v[0] * v[0]], [Exact(Fraction(3, 10))], digits=130)
    with pytest.raises(ConvergenceError, match="did not converge"):  # far away after one step
        polish(lambda v: [v[0] * v[0] - 1], [Exact(Fraction(1, 10**14))])


@pytest.mark.slow
def test_free_parameters_are_fixed_rationally() -> None:
    gaps, size = gaps_of(S3.document()), len(S3.document()["unknowns"])

    def draw(generator: np.random.Generator) -> np.ndarray:
        return generator.normal(size=size) * 0.7

    ends = search(gaps, draw, seed=1, starts=32)
    found = next(x for x in ends if x.residual < 1e-12)
    square, point = fix_parameters(S3, found.point)
    assert len(square.fixed) == 1
    assert all(Fraction(x).denominator <= 1000 for x in square.fixed.values())
    smaller = conditions_of(square.document())
    assert len(smaller.unknowns) == len(smaller.equations)
    assert len(point) == len(smaller.unknowns)


def test_dependent_equations_are_named() -> None:
    refused(RankError, "rank 1", pivots, np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]))
    assert pivots(np.array([[1.0, 0.0, 5.0], [0.0, 1.0, 0.0]]), first=[0]) == [2]


def test_ansatz_counts_unknowns_and_equations() -> None:
    # ORDER6 families: three stages leave one parameter, three explicit ones none.
    for ansatz, left in (
        (S3, 1),
        (Ansatz("x", 3, 6, stage_order=2, explicit=(1,)), 0),
        (Ansatz("x", 5, 6), 5),
        (Ansatz("x", 5, 6, (Value("i"), Value("-1", 1, -1))), 4),
        (Ansatz("x", 5, 8, stage_order=2), 2),
        (Ansatz("x", 5, 8, stage_order=2, explicit=(1, 2)), 0),
        (Ansatz("x", 5, 8, stage_order=3), 1),
    ):
        system = conditions_of(ansatz.document())
        assert len(system.unknowns) - len(system.equations) == left


def test_ansatz_refuses_what_cannot_be() -> None:
    refused(UsageError, "`order`", Ansatz, "x", 3, 5)
    refused(UsageError, "unit circle", Ansatz, "x", 3, 6, (Value("2"),))
    refused(UsageError, "`fixed` names 'b9'", Ansatz("x", 3, 6, fixed={"b9": "1"}).document)


def test_an_empty_list_of_values_is_a_runge_kutta_method(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    for text, values in (("", Ansatz.values), ("values = []\n", ())):
        path.write_text(f'name = "x"\nstages = 3\norder = 4\n{text}', encoding="utf-8")
        assert tuple(Ansatz.from_toml(path).values) == tuple(values)


def test_ansatz_files_are_checked(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    for text, match in (
        ("stages = 3", "not complete"),
        ('name = "x"\nstages = 3\ncolour = 1', "'colour' is unknown"),
        ("name = [", "is not TOML"),
    ):
        path.write_text(text, encoding="utf-8")
        refused(DataError, match, Ansatz.from_toml, path)


def test_palindromic_signs_are_decided_for_all_values() -> None:
    document = S3.document()
    assert conditions_of(document).signs == {"o": [1, -1, 1, 1]}
    document["X"][2][0] = "beta1+b1-b1"
    assert conditions_of(document).signs == {"o": [1, -1, 1, 1]}
    document["X"][2][0] = "beta2"
    assert conditions_of(document).signs is None


def test_products_of_unknowns_in_x_are_refused() -> None:
    document = S3.document()
    document["X"][2][0] = "beta1*gamma1"
    refused(DataError, "a product of two expressions in the unknowns", conditions_of, document)


def test_unknown_equations_are_refused() -> None:
    document = S3.document()
    for text in ("magic 1", "abscissa 1", "order [oo] = 1", "explicit 9", "growth 2"):
        document["enclosure"]["equations"] = [text]
        refused(DataError, "", conditions_of, document)


def test_v_that_does_not_preserve_g_is_refused() -> None:
    document = S3.document()
    document["V"][1][2] = "1"
    refused(DataError, "V\\^T G V = G", conditions_of, document)
