# pyright: strict, reportUnnecessaryTypeIgnoreComment=true
"""A user's code that pyright checks: it is in `include` of pyproject.toml, in strict mode.

The ignored lines are the near misses: pyright refuses them, and says so when it no longer does.
"""

import ast
import inspect
from dataclasses import fields
from fractions import Fraction

import glmref
import glmref.method.glm
from glmref.errors import DataError
from glmref.exact import Exact
from glmref.method import GLM, PartitionedGLM


def test_strings_fractions_and_whole_numbers_make_a_method() -> None:
    midpoint = glmref.GLM(A=[["1/2"]], U=[["1"]], B=[["1"]], V=[["1"]])
    same = GLM([[Fraction(1, 2)]], [[1]], [[Exact(1)]], [[1]], "midpoint", D=["1"], G=[[1]])
    assert midpoint.A == same.A
    half = midpoint.A[0][0]
    assert half == Fraction(1, 2)


def test_pairs_are_made_alike() -> None:
    one: list[list[str]] = [["1"]]
    pair = PartitionedGLM(
        A=[["0"]], U=one, B=one, V=one, A_hat=[[1]], U_hat=one, B_hat=one, V_hat=one, D_P=["1"]
    )
    assert pair.n_P == pair.n_Q == 1


def test_floats_are_the_decimals_they_are_written_as() -> None:
    one = [[1.0]]
    assert GLM(A=[[0.1]], U=one, B=one, V=one).A[0][0] == Fraction(1, 10)
    try:
        GLM(A="0.1", U=one, B=one, V=one)  # a string is a sequence of strings, too
    except DataError as error:
        assert "must be a list of rows" in str(error)
    else:
        raise AssertionError("a string was taken for a matrix")
    try:
        GLM(A=[[True]], U=one, B=one, V=one)
    except DataError as error:
        assert "must be a number or a string such as '1/4'" in str(error)
    else:
        raise AssertionError("a truth value was taken for a number")


def test_a_missing_block_is_refused_by_the_checker_and_at_run_time() -> None:
    try:
        GLM(A=[["1/2"]], U=[["1"]], B=[["1"]])  # pyright: ignore[reportCallIssue]
    except TypeError:
        pass
    else:
        raise AssertionError("V is missing")


def test_the_signature_for_the_checker_has_the_fields_that_there_are() -> None:
    tree = ast.parse(inspect.getsource(glmref.method.glm))
    written = {
        node.name: [x.arg for x in inner.args.args[1:]]
        for node in tree.body
        if isinstance(node, ast.ClassDef)
        for inner in ast.walk(node)
        if isinstance(inner, ast.FunctionDef) and inner.name == "__init__"
    }
    kept = {x.__name__: [f.name for f in fields(x)] for x in (GLM, PartitionedGLM)}
    assert written == kept
