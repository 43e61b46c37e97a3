"""Recipes reproduce shipped files, and refuse what does not exist."""

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.canonical import canonical, compact
from glmref.catalogue.lookup import document, load, path_of
from glmref.catalogue.reader import load_document
from glmref.compute import Records
from glmref.derive import recipes
from glmref.derive.recipes import conjugation, order8
from glmref.derive.recipes.order6_family import family, least_growth, solve_forms
from glmref.derive.recipes.two_stage import condition
from glmref.errors import UsageError
from glmref.exact import Exact
from glmref.findings import Proof
from glmref.method import GLM
from tests.build import refused, same


def text_of(name: str) -> str:
    """The shipped file."""
    return path_of(name).read_text(encoding="utf-8")


SHIPPED = [
    ("1/3", "exp(2*pi*i/3)", "g6245-w3"),
    ("1/3", "i", "g6245"),
    ("3/10", "exp(2*pi*i/3)", "c2-3-10-w3"),
]


@pytest.mark.slow
@pytest.mark.sampled(1, whole=1)
@pytest.mark.parametrize(("c2", "z", "name"), SHIPPED)
def test_order6_without_a_start_is_the_shipped_file_but_for_it(c2: str, z: str, name: str) -> None:
    result = recipes.run("order6", {"c2": c2, "z": z, "start": "no"})
    shipped = dict(document(name))
    for key in ("starting", "digits"):
        del shipped[key]
    shipped["claims"] = {k: v for k, v in shipped["claims"].items() if k != "starting-order"}
    assert canonical(result.documents[0]) == canonical(shipped)
    assert [x.proof for x in result.statements] == [Proof.EXACT]


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("c2", "z", "name"),
    [SHIPPED[0], *(pytest.param(*x, marks=pytest.mark.slow) for x in SHIPPED[1:])],
)
def test_order6_reproduces_the_shipped_file_bit_for_bit(c2: str, z: str, name: str) -> None:
    result = recipes.run("order6", {"c2": c2, "z": z})
    assert canonical(result.documents[0]) == text_of(name)
    assert [x.proof for x in result.statements] == [Proof.EXACT, Proof.ENCLOSED]


def test_order6_accepts_c2_just_inside_its_interval_and_refuses_it_just_outside() -> None:
    # (5 - sqrt 5)/10 = 0.27639...: there b3 changes sign, and with it -b1 b2 b3.
    assert not any(x.is_real() for x in solve_forms(family(Fraction(2763, 10000))))
    assert any(x.is_real() for x in solve_forms(family(Fraction(2765, 10000))))
    assert any(x.is_real() for x in solve_forms(family(Fraction(499, 1000))))
    refused(UsageError, "must not be 0, 1/2 or 1", recipes.run, "order6", {"c2": "1/2"})


def test_least_growth_is_a_lower_bound_on_random_forms() -> None:
    # gamma = x e1 + y e2 (+ z e0) on the hyperboloid: no growth below the bound. Here the bound is
    # compared with the two values that the decompositions without growth would need, which fail.
    member = family(Fraction(1, 15))
    bound = least_growth(member)
    assert bound is not None
    assert 33.054 < float(bound) < 33.055
    assert least_growth(family(Fraction(1, 3))) is None  # growth 0 is possible there


@pytest.mark.slow
def test_order6_takes_a_z_that_is_no_root_of_unity() -> None:
    result = recipes.run("order6", {"c2": "2/5", "z": "(3+4*i)/5"})
    method = load_document(result.documents[0])
    assert method.V[1][1] == Fraction(3, 5)


def assert_same_method(derived: Mapping[str, Any], name: str) -> None:
    """The derived document and the shipped one are the same method."""
    left, right = load_document(derived), load(name)
    assert isinstance(left, GLM) and isinstance(right, GLM)
    for letter in "AUBV":
        assert same(getattr(left, letter), getattr(right, letter)), letter


def test_two_stage_family_gives_n_and_p_and_no_growth_is_impossible() -> None:
    result = recipes.run("two-stage")
    for derived in result.documents:
        assert_same_method(derived, derived["name"])
    assert "-1/3: impossible" in result.statements[-1].text
    assert {x.proof for x in result.statements} == {Proof.EXACT}


def test_two_stage_condition_vanishes_for_n() -> None:
    # w = g x^2 = 1 - 2/sqrt(3) solves w^2 - 2 w - 1/3 = 0; a rational near it does not.
    assert (
        condition(Fraction(1, 2), Fraction(393, 1000), Fraction(-393, 1000), -1).magnitude() > 1e-5
    )
    w = Exact(1) - 2 / Exact(3).sqrt()
    assert (w * w - w * 2 - Fraction(1, 3)).is_zero()


def test_order4_recipe_gives_the_thesis_method_corrected() -> None:
    result = recipes.run("order4")
    assert_same_method(result.documents[0], "thesis-3-8")
    assert result.statements[0].proof is Proof.EXACT


def test_order4_recipe_gives_s4_in_closed_form() -> None:
    result = recipes.run("order4", {"family": "symmetric"})
    assert_same_method(result.documents[0], "s4-symmetric")
    assert result.statements[0].proof is Proof.EXACT


SAMPLE = ("s3i1-w3", "s4-w3", "t115a-i")


@pytest.mark.parametrize("name", SAMPLE)
def test_conjugation_methods_are_reproduced_bit_for_bit(name: str) -> None:
    assert_reproduced("conjugation6", name)


def assert_reproduced(recipe: str, name: str) -> None:
    """The recipe gives the shipped file, apart from its start and finish."""
    derived = dict(recipes.run(recipe, {"name": name, "start": "no"}).documents[0])
    shipped = document(name)
    for key in ("starting", "finishing"):
        if key in shipped:
            derived[key] = shipped[key]
    claims = {k: v for k, v in shipped["claims"].items() if k.endswith("ing-order")}
    derived["claims"] = {**derived["claims"], **claims}
    assert canonical(derived) == text_of(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [x for x in conjugation.ROUGH if x not in SAMPLE])
def test_other_conjugation_methods_are_reproduced_bit_for_bit(name: str) -> None:
    assert_reproduced("conjugation6", name)


ORDER_8 = ("order8-s3-w3-i", "order8-s4i2-w3-i")


@pytest.mark.slow
@pytest.mark.parametrize("name", ORDER_8)
def test_order_8_methods_with_six_values_are_reproduced_bit_for_bit(name: str) -> None:
    assert_reproduced("order8", name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [x for x in order8.ROUGH if x not in ORDER_8])
def test_other_order_8_methods_are_reproduced_bit_for_bit(name: str) -> None:
    assert_reproduced("order8", name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("recipe", "name"),
    [
        ("conjugation6", "s5i1-w3"),
        ("conjugation6", "t115a-i"),
        ("order8", "order8-s3-w3-i"),
        ("order8", "order8-s4i2-w3-i"),
        ("order8", "order8-s5i1-w3"),
    ],
)
def test_starts_and_finishes_are_reproduced_bit_for_bit(recipe: str, name: str) -> None:
    derived = recipes.run(recipe, {"name": name}).documents[0]
    assert canonical(derived) == text_of(name)


@pytest.mark.slow
def test_a_start_that_is_not_on_record_is_refused() -> None:
    with pytest.raises(UsageError, match="no start is on record"):
        recipes.run("order6", {"c2": "2/5", "start": "yes"})


def test_yoshida_composition_is_reproduced_bit_for_bit() -> None:
    derived = recipes.run("yoshida6").documents[0]
    assert canonical(derived) == text_of("yoshida-6-midpoint")


@pytest.mark.slow
def test_progress_is_reported() -> None:
    seen: list[tuple[str, int, int]] = []
    recipes.run(
        "order6", {"start": "no"}, lambda what, done, total: seen.append((what, done, total))
    )
    assert seen[-1] == ("done", 3, 3)


ANSATZ = Path(__file__).with_name("three-stages.toml")


@pytest.mark.slow
def test_search_finds_a_method_and_resumes_where_it_stopped(tmp_path: Path) -> None:
    state = tmp_path / "state.sqlite"
    options = {"ansatz": str(ANSATZ), "starts": "96"}
    whole = recipes.run("search", options)
    assert whole.documents[0]["claims"]["order"] == 6
    recipes.run("search", {**options, "starts": "64", "state": str(state)})
    first, second = Records(state)
    # as an earlier version leaves it that is killed while it writes
    state.with_suffix(".jsonl").write_bytes(compact(first) + b"\n" + compact(second)[:20])
    state.unlink()
    ran: list[int] = []
    resumed = recipes.run(
        "search", {**options, "state": str(state)}, lambda what, done, total: ran.append(done)
    )
    assert ran == [64, 96]
    assert canonical(resumed.documents[0]) == canonical(whole.documents[0])


@pytest.mark.slow
def test_search_says_how_far_it_came_when_nothing_is_found(tmp_path: Path) -> None:
    ansatz = tmp_path / "a.toml"
    text = ANSATZ.read_text(encoding="utf-8").replace("stages = 3", "stages = 2")
    ansatz.write_text(text, encoding="utf-8")
    result = recipes.run("search", {"ansatz": str(ansatz), "starts": "8"})
    assert not result.documents
    assert "0 methods completed" in result.statements[-1].text
