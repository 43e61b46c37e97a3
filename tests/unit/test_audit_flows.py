"""Splittings that are written as flows one after another, and dictionaries of rows."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.audit.lexer import LANGUAGES
from glmref.audit.recognising import tables
from glmref.audit.table import Table
from glmref.audit.table_verdicts import judge

#: Drifts and kicks of Ruth (1983) and of Forest and Ruth (1990), with the order.
RUTH = ["7/24.", "2/3.", "3/4.", "-2/3.", "-1/24.", "1.0"]
FOREST = ["0.6756035959798289", "1.351207191959658", "-0.1756035959798289", "-1.702414383919316",
          "-0.1756035959798289", "1.351207191959658", "0.6756035959798289"]  # fmt: skip


def read(text: str, language: str) -> list[Table]:
    """Return the tables of a source about Hamiltonian systems."""
    mark = "#" if language == "python" else "//"
    return tables(f"{mark} symplectic integrator\n{text}", LANGUAGES[language], about=True)


def calls(numbers: list[str]) -> str:
    rows = [f"{('drift', 'kick')[k % 2]}(q, p, {x}*dt);" for k, x in enumerate(numbers)]
    return "\n".join(["void step(double *q, double *p, double dt) {", *rows, "}"])


def updates(numbers: list[str]) -> str:
    rows = [(f"    q = q + dt * ({x}) * p", f"    p -= ({x}) * dt * force(q)")[k % 2]
            for k, x in enumerate(numbers)]  # fmt: skip
    return "\n".join(["def step(q, p, dt):", *rows, "    return q, p"])


def components(numbers: list[str]) -> str:
    rows = [("x += {0}*h*vx; y += {0}*h*vy;", "vx += {0}*h*fx; vy += {0}*h*fy;")[k % 2].format(x)
            for k, x in enumerate(numbers)]  # fmt: skip
    return "\n".join(["void step(double h) {", *rows, "}"])


FORMS = {"calls": (calls, "c"), "updates": (updates, "python"), "components": (components, "c")}


@pytest.mark.parametrize(("numbers", "order"), [(RUTH, 3), (FOREST, 4)], ids=["ruth", "forest"])
@pytest.mark.parametrize("form", FORMS)
def test_flows_one_after_another_are_a_splitting(form: str, numbers: list[str], order: int) -> None:
    write, language = FORMS[form]
    (table,) = read(write(numbers), language)
    assert judge(table)["found"] == order


@given(st.sampled_from(sorted(FORMS)), st.integers(0, 6), st.integers(3, 8))
def test_a_wrong_digit_is_not_silent_and_not_accused(form: str, at: int, place: int) -> None:
    write, language = FORMS[form]
    start = place + FOREST[at].index(".")
    digit = str((int(FOREST[at][start]) + 1) % 10)
    wrong = [*FOREST[:at], FOREST[at][:start] + digit + FOREST[at][start + 1 :], *FOREST[at + 1 :]]
    found = [judge(x) for x in read(write(wrong), language)]
    assert found and {x["status"] for x in found} <= {"unread", "found", "question"}
    assert all(x.get("found", 0) < 4 for x in found)
