"""Search, recipes, closed forms and the command: reproducible, resumable, honest about where they stop."""

import json
import os
import pty
import signal
import subprocess
import sys
import termios
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from glmref.catalogue.canonical import canonical
from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.cli import main
from glmref.compute import Records
from glmref.derive import recipes
from glmref.derive.ansatz import Ansatz, Value
from glmref.derive.parameters import RankError, fix_parameters, pivots
from glmref.derive.partitioned import PairAnsatz, complete_pair, search_pairs
from glmref.derive.recipes.shipped_pairs import SHIPPED
from glmref.derive.recognise import minimal_polynomial, surd, surds
from glmref.derive.search import evaluate, levenberg_marquardt, search
from glmref.errors import DataError, UsageError
from glmref.exact import Exact, ball
from glmref.exact.expression import parse
from glmref.exact.judging import as_number, consulted, coordinates, rounded
from glmref.prove.enclosure import conditions_of, gaps_of
from glmref.theory.stability import parasitic_curvature
from tests.build import SOURCE, refused

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


# -- from an ansatz to a proved pair: equations, free parameters, recipes and the search


def test_palindromes_hold_for_all_values_of_the_unknowns():
    for ansatz in (PairAnsatz("x", 5, 6, starts="qp"), PairAnsatz("x", 4, 4, outer="Q", g=-1)):
        assert conditions_of(ansatz.document()).signs == {"f": [1, -1], "k": [1, -1]}


@pytest.mark.slow
def test_a_search_is_reproducible_and_ends_in_a_proved_pair():
    ansatz = PairAnsatz("found", 4, 4)
    first, second = (list(search_pairs(ansatz, seed=3, starts=16)) for _ in range(2))
    assert first == second
    found = next(x for x in first if x.residual < 1e-10)
    square, start = fix_parameters(ansatz, found.point)
    assert len(square.fixed) == 3  # 7 unknowns, 4 equations
    doc, proof = complete_pair(square, [repr(x) for x in start], source=SOURCE)
    assert (proof.order, proof.identity) == (4, True)
    assert doc["claims"]["reducible"] is False


@pytest.mark.slow
def test_the_recipe_reproduces_a_shipped_pair():
    derivation = recipes.run("pairs", {"name": "pair-6-7"})
    assert [dict(x) for x in derivation.documents] == [document("pair-6-7")]
    assert "order 6" in derivation.statements[0].text


@pytest.mark.slow
@pytest.mark.sampled(1, whole=4)
@pytest.mark.parametrize(  # a minute each those of order 8
    "name",
    [x for x in SHIPPED if x != "pair-6-7" and ("8-" not in x or "GLMREF_LONG" in os.environ)],
)
def test_the_recipe_reproduces_the_other_shipped_pairs(name):
    assert [dict(x) for x in recipes.run("pairs", {"name": name}).documents] == [document(name)]


@pytest.mark.slow
def test_the_search_of_the_recipe_completes_a_pair_or_says_how_near_it_came():
    options = {"n": "4", "order": "4", "starts": "", "seed": "3", "tries": "16"}
    derivation = recipes.run("pairs", options)
    assert len(derivation.documents) == 1
    assert "16 starts" in derivation.statements[-1].text
    for wrong in (
        {"n": "x"},
        {"n": "4", "nystrom": "maybe"},
        {"n": "4", "circle": "maybe"},
        {"name": "pair-5-5"},
    ):
        refused(UsageError, "", recipes.run, "pairs", wrong)


@pytest.mark.slow
def test_a_search_passes_over_pairs_that_leave_the_unit_circle():
    options = {"n": "5", "order": "4", "starts": "", "seed": "3", "tries": "32", "wanted": "99"}
    free = recipes.run("pairs", options).documents
    kept = recipes.run("pairs", {**options, "circle": "yes"})
    signs = {x["name"]: parasitic_curvature(load_document(x)).real.sign() for x in free}
    assert set(signs.values()) == {1, -1}
    assert {x["name"] for x in kept.documents} == {name for name, s in signs.items() if s > 0}
    left = [x for x in kept.statements if "leave the unit circle" in x.text]
    assert len(left) == sum(1 for s in signs.values() if s < 0)


def test_without_a_start_on_record_the_claim_is_the_one_the_equations_give():
    for name, expected in (("pair-4-4", 1), ("pair-6-7", 1), ("pair-rkn-6-7", 3)):
        shipped = SHIPPED[name]
        doc, _ = complete_pair(shipped.ansatz, shipped.start.split(), source=SOURCE)
        assert doc["claims"]["starting-order"] == expected
        assert "starting" not in doc


# -- closed forms are found where they exist and nowhere else


@pytest.mark.parametrize(
    "text", ["3/7", "-5", "sqrt(5)/6", "-4*sqrt(5)/27", "1/2-sqrt(15)/30", "sqrt(5/8+sqrt(5)/8)"]
)
def test_surds_are_recognised_from_their_digits(text: str) -> None:
    value = parse(text)
    found = surd(ball(value))
    assert found is not None
    assert parse(found) == value


def test_a_number_without_such_a_form_is_left_alone() -> None:
    # A root of x^5 - x - 1, which is not solvable by radicals, found by bisection.
    low, high = Fraction(1), Fraction(2)
    for _ in range(400):
        middle = (low + high) / 2
        low, high = (middle, high) if middle**5 - middle - 1 < 0 else (low, middle)
    value = ball(low)
    assert surd(value) is None
    assert minimal_polynomial(value, degree=5, height=1000) == [1, 0, 0, 0, -1, -1]
    assert surds({"x": value, "y": ball(Fraction(1, 3))}) == {"y": "1/3"}


# -- ``glmref derive`` on the command line: lists, help, bad input, progress, interruption


ANSATZ = Path(__file__).with_name("three-stages.toml")


def test_without_a_recipe_the_recipes_are_listed(cli) -> None:
    text = cli("derive").out
    assert all(name in text for name in recipes.names())


def test_the_list_of_recipes_comes_as_json_too(cli) -> None:
    found = json.loads(cli("derive", "--format", "json").out)
    assert found["format"] == "glmref-recipes-1"
    assert [x["name"] for x in found["recipes"]] == recipes.names()
    options = {x["name"]: x["options"] for x in found["recipes"]}
    assert options["order6"] == {"c2": "1/3", "z": "exp(2*pi*i/3)", "start": "auto"}


@pytest.mark.parametrize("words", [["order6", "--help"], ["--help", "order6"], ["order6", "-h"]])
def test_help_after_a_recipe_is_that_of_the_recipe(words: list[str], cli) -> None:
    text = cli("derive", *words).out
    assert "glmref derive order6" in text
    assert "--c2" in text and "default: 1/3" in text
    assert ":mod:" not in text


def test_an_ansatz_that_is_not_toml_is_one_sentence(tmp_path: Path, cli) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"stages = \xff")
    assert "a.toml: byte 9 is not UTF-8" in cli("derive", path, code=2).err


def cli(*words: str) -> list[str]:
    return [sys.executable, "-m", "glmref", "derive", *words]


def wait_for_records(state: Path, count: int, process: subprocess.Popen[bytes]) -> None:
    """Wait until the state file has as many records, or the search has ended."""
    until = time.monotonic() + 120
    while process.poll() is None and time.monotonic() < until:
        if len(Records(state)) >= count:
            return
        time.sleep(0.02)
    raise AssertionError("the search ended before it could be stopped")


OPTIONS = {"ansatz": str(ANSATZ), "starts": "96"}


@pytest.fixture(scope="module")
def undisturbed() -> list[str]:
    return [canonical(x) for x in recipes.run("search", OPTIONS).documents]


@pytest.mark.slow
@pytest.mark.parametrize(("how", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)])
def test_a_search_that_is_stopped_goes_on_where_it_was(how, code, tmp_path, undisturbed):
    """Interrupted or killed, the second run takes over what the first one kept."""
    state = tmp_path / "state"
    words = [str(ANSATZ), "--starts", "96", "--state", str(state)]
    process = subprocess.Popen(cli(*words), stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    wait_for_records(state, 1, process)
    process.send_signal(how)
    _, complaint = process.communicate()
    assert process.returncode == code
    if how is signal.SIGINT:
        assert f"the same command goes on from {state}".encode() in complaint
    kept = len(Records(state))
    assert kept < 3  # parcels of 32 starts
    ran: list[int] = []
    resumed = recipes.run(
        "search", {**OPTIONS, "state": str(state)}, lambda _, done, total: ran.append(done)
    )
    assert min(ran) == 32 * (kept + 1)
    assert [canonical(x) for x in resumed.documents] == undisturbed


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal_and_nowhere_else() -> None:
    leader, follower = pty.openpty()
    termios.tcsetwinsize(follower, (24, 80))
    run = subprocess.run(cli("yoshida6"), stderr=follower, stdout=subprocess.PIPE, check=True)
    os.close(follower)
    shown = os.read(leader, 100_000).decode()
    os.close(leader)
    assert "A:" in shown and "%" in shown
    assert b'"yoshida-6-midpoint"' in run.stdout
    silent = subprocess.run(cli("yoshida6"), capture_output=True, check=True)
    assert b"%" not in silent.stderr


def test_a_name_of_a_file_is_that_file(tmp_path: Path) -> None:
    path = tmp_path / "new" / "mine.json"
    words = ["derive", "pairs", "--name", "pair-4-4", "--output", str(path)]
    assert main(words) == 0
    assert json.loads(path.read_text(encoding="utf-8"))["name"] == "pair-4-4"


def test_several_methods_go_to_a_folder_whatever_its_name_ends_with(tmp_path: Path) -> None:
    words = ["derive", "two-stage", "--format", "json", "--output", str(tmp_path / "two.json")]
    assert main(words) == 0
    assert len(list((tmp_path / "two").glob("*.json"))) > 1
