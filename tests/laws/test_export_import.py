"""Export then import is the identity, for every method of the catalogue that the format holds."""

import json
from collections.abc import Iterator

import pytest

import glmref
from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import UsageError
from glmref.exact import Ball, Exact, Scalar
from glmref.exact.linalg import Matrix
from glmref.exchange.cells import from_cells
from glmref.exchange.export import export
from glmref.exchange.import_tables import FORMATS, read_table
from glmref.method import GLM, AdditiveGLM, PartitionedGLM
from glmref.prove.verifier import verify
from tests.shipped import shipped

#: Formats of tableaux.
TABLES = tuple(FORMATS)
#: Coefficients with roots inside roots come back as decimals.
NESTED = ("triple-jump-6", "triple-jump-verlet-6", "suzuki-verlet-6")

EVERY = tuple(glmref.names("methods"))
NAMES = [x for x in EVERY if shipped(x)["class"] not in ("additive", "rosenbrock")]
ADDITIVE = [x for x in glmref.names("methods") if shipped(x)["class"] == "additive"]
#: Formats that hold the first embedded row.
WITH_ROWS = ("sundials", "petsc", "diffrax", "ordinarydiffeq")
SPLITTINGS = [x for x in NAMES if shipped(x)["class"] == "splitting"]


def blocks(
    method: GLM | PartitionedGLM | AdditiveGLM, *, row: bool = False
) -> Iterator[tuple[str, Matrix]]:
    for one in method.embedded[:row]:
        yield from ((f"d^{n}", x) for n, x in enumerate(one.solution(method.weights)))
    if isinstance(method, AdditiveGLM):
        for n, part in enumerate(method.components, 1):
            yield from zip((f"{x}^{n}" for x in "AUBV"), part.matrices, strict=True)
        return
    letters = ("A", "U", "B", "V", "A_hat", "U_hat", "B_hat", "V_hat")
    yield from ((x, getattr(method, x)) for x in letters if hasattr(method, x))


def same(x: Scalar, y: Scalar, digits: int) -> bool:
    """Equal numbers where both are exact; else decimals that do not contradict each other.

    The second must still know its number to the digits that were written.
    """
    if isinstance(x, Exact) and isinstance(y, Exact):
        return x == y
    known = y.radius() if isinstance(y, Ball) else 0.0
    return (x - y).is_zero() is not False and known <= 10.0 ** (1 - digits)


def check(name: str, form: str, digits: int) -> None:
    method = glmref.load(name)
    again = load_document(read_table(export(method, to=form), form, where=f"{name}.{form}"))
    assert again.name == name
    before = dict(blocks(method, row=form in WITH_ROWS))
    after = dict(blocks(again, row=True))
    assert before.keys() == after.keys()
    for letter, matrix in before.items():
        for i, (row, found) in enumerate(zip(matrix, after[letter], strict=True)):
            for j, (x, y) in enumerate(zip(row, found, strict=True)):
                assert same(x, y, digits), f"{letter}[{i + 1}][{j + 1}] of {name}: {x!r}, {y!r}"
    if method.is_exact and name not in NESTED:
        assert again.is_exact, "an exact method came back as decimals"


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", EVERY)
def test_json_is_the_method_file_and_csv_its_cells(name: str) -> None:
    assert json.loads(export(name, to="json")) == shipped(name)
    assert from_cells(export(name, to="csv")) == shipped(name)


@pytest.mark.sampled(8, besides=NESTED)
@pytest.mark.parametrize("name", NAMES)
def test_tables_of_other_packages_come_back_or_are_refused_in_one_sentence(name: str) -> None:
    method = glmref.load(name)
    one_step = isinstance(method, GLM) and method.r == 1 and name != "ab-1"
    for form in TABLES:
        try:
            export(method, to=form)
        except UsageError as refusal:
            assert name in str(refusal)
            assert "\n" not in str(refusal)
            assert form != "rungekutta.jl" or not one_step
            continue
        check(name, form, 30)


@pytest.mark.parametrize("name", ["gauss-3", "order8-s3-w3-i", "pair-6-7", "rk4"])
def test_decimals_of_chosen_length_come_back(name: str) -> None:
    again = load_document(read_table(export(name, to="csv", digits=20), "csv"))
    method = glmref.load(name)
    for letter, matrix in blocks(method):
        for row, found in zip(matrix, getattr(again, letter), strict=True):
            assert all(same(x, y, 20) for x, y in zip(row, found, strict=True))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", ADDITIVE)
def test_additive_methods_come_back(name: str) -> None:
    for form in ("petsc", "sundials"):
        check(name, form, 30)
        claims = read_table(export(name, to=form), form)["claims"]
        own = document(name)["claims"]
        lower = list(own.get("embedded-order", {}).values())[:1]
        rows = {"embedded-order": {"embedded": lower[0]}} if lower and form == "sundials" else {}
        if "order" in own:  # rounded coefficients have none that is exact
            assert claims == {"order": own["order"], **rows}


@pytest.mark.parametrize("name", ["dormand-prince-5-4", "tr-bdf2-3-2", "verner-efficient-8-7"])
def test_embedded_rows_come_back_with_their_order(name: str) -> None:
    own = next(iter(document(name)["claims"]["embedded-order"].values()))
    forms = ("sundials",) if name == "tr-bdf2-3-2" else ("sundials", "ordinarydiffeq")
    for form in forms:
        again = read_table(export(name, to=form), form)
        assert again["claims"]["embedded-order"] == {"embedded": own}
        wrong = load_document({**again, "claims": {"embedded-order": {"embedded": own + 1}}})
        assert {str(x.verdict) for x in verify(wrong)} == {"fails"}


def test_rosenbrock_methods_are_refused_in_one_sentence() -> None:
    for form in ("petsc", "rungekutta.jl", "c"):
        with pytest.raises(UsageError, match="ros3p is a Rosenbrock method: json and csv hold it"):
            export("ros3p", to=form)


@pytest.mark.sampled(8, besides=NESTED, whole=25)
@pytest.mark.parametrize("name", SPLITTINGS)
def test_splittings_come_back(name: str) -> None:
    check(name, "sundials", 30)
    again = read_table(export(name, to="sundials"), "sundials")
    assert again["first"] == document(name)["first"]
    assert again["claims"] == {"order": document(name)["claims"]["order"]}


def test_a_changed_digit_does_not_come_back_as_the_same() -> None:
    text = export("gauss-2", to="json", digits=20).replace(
        "0.03867513459481288", "0.03867513459481289"
    )
    again = load_document(json.loads(text))
    assert isinstance(again, GLM)
    method = glmref.load("gauss-2")
    assert not same(method.A[0][1], -again.A[0][1], 20)
    assert not same(method.A[0][1], again.A[0][1], 20)
