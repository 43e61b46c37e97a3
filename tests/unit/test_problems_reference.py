"""Reading and regenerating the files of data/solutions."""

import json

import mpmath
import pytest

from glmref.errors import DataError
from glmref.problems import problem
from glmref.problems.reference import FORMAT, read_references
from tests.build import high
from tools.reference_solutions import solution_document, solution_entries

GOOD = {
    "parameters": {"q0": "5/2", "p0": "0"},
    "t": "1/2",
    "state": ["0.25", "-1e-3"],
    "agreement": "1e-3",
    "generator": "by hand",
}


def written(tmp_path, document, name="pendulum"):
    path = tmp_path / f"{name}.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"format": "other"}, "`format` must be"),
        ({"format": FORMAT, "problem": "kepler", "solutions": []}, "must be the file's name"),
        ({"format": FORMAT, "problem": "pendulum"}, "incomplete"),
        ({"format": FORMAT, "problem": "pendulum", "solutions": [{}]}, "incomplete"),
        (solution_document("pendulum", [{**GOOD, "state": ["x"]}]), "incomplete or not a number"),
        (solution_document("pendulum", [{**GOOD, "t": "soon"}]), "incomplete or not a number"),
        ([1], "`format` must be"),
    ],
)
def test_a_wrong_file_is_one_sentence(tmp_path, document, says):
    with pytest.raises(DataError) as error:
        read_references(written(tmp_path, document))
    assert says in str(error.value) and str(error.value).startswith("pendulum.json")


def test_a_float_in_a_file_is_refused(tmp_path):
    with pytest.raises(DataError, match="float"):
        read_references(written(tmp_path, solution_document("pendulum", [{**GOOD, "t": 0.5}])))


def test_references_belong_to_their_parameters():
    assert [float(r.t) for r in problem("pendulum").references] == [10, 100]
    assert problem("pendulum", q0=2.5).references == problem("pendulum").references
    assert problem("pendulum", q0=1).references == ()
    assert problem("kepler").references == ()


def test_regenerated_digits_are_all_right():
    p = problem("pendulum")
    (entry,) = solution_entries(p, ["2"], digits=15)
    context = high(40)
    exact = p.on(context).solution(2)
    for text, value in zip(entry["state"], exact, strict=True):
        digits = len(text.lstrip("-0.").replace(".", ""))
        assert 13 <= digits <= 25
        # the last digit that two computations agree on may be off by one
        assert abs(context.mpf(text) - value) < 2 * abs(value) * 10.0 ** (1 - digits)


@pytest.mark.slow
def test_digits_that_do_not_agree_are_not_written():
    (entry,) = solution_entries(problem("kaps", epsilon=1), ["1"], digits=6, stages=4)
    context = mpmath.MPContext()
    for text, exact in zip(entry["state"], (context.exp(-2), context.exp(-1)), strict=True):
        digits = len(text.lstrip("-0.").replace(".", ""))
        assert digits < 16 and abs(context.mpf(text) / exact - 1) < 2 * 10.0 ** (1 - digits)
