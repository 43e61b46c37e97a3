"""Splittings that are written as flows one after another, and dictionaries of rows."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.audit.judge import judge
from glmref.audit.lexer import LANGUAGES
from glmref.audit.recognising import tables
from glmref.audit.table import Table

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


def test_steps_in_a_loop_are_steps_of_one_method() -> None:
    text = """void step(double *q, double *p, double dt, int n) {
      double lambda = 0.1931833275037836;
      kick(p, lambda*dt);
      for (int i = 1; i < n; i++) {
        drift(q, 0.5*dt); kick(p, (1 - 2*lambda)*dt);
        drift(q, 0.5*dt); kick(p, 2*lambda*dt);
      }
      drift(q, 0.5*dt); kick(p, (1 - 2*lambda)*dt); drift(q, 0.5*dt); kick(p, lambda*dt);
    }"""
    (table,) = read(text, "c")
    assert judge(table)["found"] == 2
    (unread,) = read(text.replace("double lambda = 0.1931833275037836;", ""), "c")
    assert "lambda" in unread.unread
    branch = text.replace("for (int i = 1; i < n; i++)", "if (n > 1)")
    assert "a branch between its flows" in read(branch, "c")[0].unread


@pytest.mark.parametrize("text", [
    "void draw(double dt) { line(x, 0.3*dt); text(x, 0.7*dt); }",
    "void step(double dt) { drift(q, dt/2); kick(p, dt); drift(q, dt/2); }",
    "void step(double dt) { t += 0.1*dt; wait(dt); t += 0.9*dt; wait(dt); }",
    "void mean(double dt) { a += 0.25*dt*u; b += 0.3*dt*w; }",
])  # fmt: skip
def test_no_numbers_of_a_splitting_are_none(text: str) -> None:
    assert read(text, "c") == []


def test_numbers_of_a_known_splitting_are_not_silent() -> None:
    (table,) = read("u = 1.3512071919596578\nv = -1.7024143839193153\nrun(u, v)", "python")
    assert "forest-ruth" in table.unread


def test_halves_of_weights_without_the_middle_one_are_a_composition() -> None:
    text = """static double w6[3] = {-0.117767998417887e1, 0.235573213359357e0, 0.784513610477560e0};
    step_of_yoshida(w6);"""
    (table,) = read(text, "c")
    assert judge(table)["found"] == 6


DICTIONARY = """class RKF45(ExplicitRungeKutta):
    order = 4
    def __init__(self):
        self.eval_stages = [0.0, 1/4, 3/8, 12/13, 1, 1/2]
        self.BT = {
            0: [1/4],
            1: [3/32, 9/32],
            2: [1932/2197, -7200/2197, 7296/2197],
            3: [439/216, -8, 3680/513, -845/4104],
            4: [-8/27, 2, -3544/2565, 1859/4104, -11/40],
            5: [25/216, 0, 1408/2565, 2197/4104, -1/5],
        }
        self.TR = [1/360, 0, -128/4275, -2197/75240, 1/50, 2/55]
"""


@pytest.mark.parametrize(("old", "new", "status"), [
    ("0: [1/4]", "0: [1/4]", "right"), ("3680/513", "3860/513", "wrong"),
    ("1408/2565", "1480/2565", "unread"), ("-3544/2565", "-3554/2565", "question"),
])  # fmt: skip
def test_a_dictionary_of_rows_is_a_table(old: str, new: str, status: str) -> None:
    (table,) = read(DICTIONARY.replace(old, new), "python")
    assert judge(table)["status"] == status
