"""Splittings that are written as flows one after another, and dictionaries of rows."""

from __future__ import annotations

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


#: Forest and Ruth (1990) as coefficients a, b; Blanes and Moan (2002), S6, from both ends.
CHOICES = {
    "python": """def build(method):
    if method == "FR":
        a = [0.6756035959798288, -0.1756035959798288, -0.1756035959798288, 0.6756035959798288]
        b = [1.3512071919596576, -1.7024143839193153, 1.3512071919596576]
    elif method in ("S6", "BM4"):
        a, b = zeros(7), zeros(7)
        a[1] = 0.209515106613362
        a[2] = -0.143851773179818
        a[3] = 0.5 - a[:3].sum()
        a[4:] = flipud(a[1:4])
        b[0] = 0.0792036964311957
        b[1] = 0.353172906049774
        b[2] = -0.0420650803577195
        b[3] = 1 - 2*sum(b[:3])
        b[4:] = flipud(b[:3])
    return a, b
""",
    "matlab": """function [a, b] = build(method)
    switch method
    case 'FR'
        a = [0.6756035959798288 -0.1756035959798288 -0.1756035959798288 0.6756035959798288];
        b = [1.3512071919596576 -1.7024143839193153 1.3512071919596576];
    case 'S6'
        a = [0.209515106613362 -0.143851773179818 0.434336666566456 0.434336666566456 ...
             -0.143851773179818 0.209515106613362];
        b = [0.0792036964311957 0.353172906049774 -0.0420650803577195 0.2193769557534996 ...
             -0.0420650803577195 0.353172906049774 0.0792036964311957];
    end
end
""",
    "julia": """function build(method)
    if method == "FR"
        a = [0.6756035959798288, -0.1756035959798288, -0.1756035959798288, 0.6756035959798288]
        b = [1.3512071919596576, -1.7024143839193153, 1.3512071919596576]
    elseif method == "S6"
        a = [0.209515106613362, -0.143851773179818, 0.434336666566456, 0.434336666566456,
             -0.143851773179818, 0.209515106613362]
        b = [0.0792036964311957, 0.353172906049774, -0.0420650803577195, 0.2193769557534996,
             -0.0420650803577195, 0.353172906049774, 0.0792036964311957]
    end
end
""",
}


@pytest.mark.parametrize("language", CHOICES)
def test_what_is_done_for_one_string_is_a_method_of_that_name(language: str) -> None:
    found = read(CHOICES[language], language)
    assert [(x.name, judge(x)["found"]) for x in found] == [("FR", 4), ("S6", 4)]


def test_a_name_of_one_choice_is_not_known_in_another() -> None:
    text = 'if method == "x":\n    a = [0.5, 0.5]\nelif method == "y":\n    b = [1.0, 0.0]\n'
    assert read(text, "python") == []
    assert len(read(text.replace('elif method == "y"', "if twice"), "python")) == 0


ADJOINT = """def sequence(name):
    alpha = [0.0792036964311957, 0.1303114101821663, 0.2228614958676077, -0.3667132690474257,
             0.3246481886897062, 0.1096884778767498]
    return concatenate((alpha, flip(alpha)))
"""


def test_steps_of_a_method_and_its_adjoint_are_those_of_a_splitting() -> None:
    (table,) = read(ADJOINT, "python")
    assert judge(table)["found"] == 4
    wrong = judge(read(ADJOINT.replace("0.3246", "0.3264"), "python")[0])
    assert wrong["found"] == 0
    assert wrong["status"] == "unread"
    assert all(x.kind != "splitting" or x.unread
               for x in read(ADJOINT.replace("flip(alpha)", "alpha"), "python"))  # fmt: skip


HALVES = """void omelyan(double dt) {
  const double rho = 0.08398315262876693, theta = 0.6822365335719091;
  const double kappa = 0.2539785108410595, lambda = -0.03230286765269967;
  double a[3] = {kappa, lambda, 1-2*(kappa+lambda)};
  double b[3] = {rho, theta, .5-rho-theta};
}"""


def test_half_of_a_symmetric_splitting_is_the_whole_one() -> None:
    (table,) = read(HALVES, "c")
    assert [len(x) for x in table.b] == [6, 6]
    assert judge(table)["found"] == 4
    other = read(HALVES.replace("1-2*(kappa+lambda)", "1-kappa-lambda"), "c")
    assert not other or len(other[0].b[0]) == 3


PAIRS = """void make(int n) {
  if (n == -3) {
""" + "".join(
    f"    cd[{k}][0] = {x}; cd[{k}][1] = {y};\n"
    for k, (x, y) in enumerate(zip(FOREST[::2], [*FOREST[1::2], "0.0"], strict=True))
) + "  }\n}"  # fmt: skip


def test_pairs_that_are_given_entry_by_entry_are_steps_of_two_flows() -> None:
    (table,) = read(PAIRS, "c")
    assert judge(table)["found"] == 4
    assert all(x.unread for x in read(PAIRS.replace("cd[3][1] = 0.0;", ""), "c"))


def test_lists_of_pairs_beside_other_matrices_are_steps_of_two_flows() -> None:
    text = """def methods():
    alphas['Lie-3'] = [[1, 1, 1]]
    alphas['Ruth'] = [[7./24, 2./3], [3./4, -2./3], [-1./24, 1.]]
    alphas['Three'] = [[0.5, 0.5, 1], [0, 0.5, 0], [0.5, 0, 0]]
"""
    (table,) = read(text, "python")
    assert (table.name, judge(table)["found"]) == ("Ruth", 3)
    (table,) = read(text.replace("3./4", "3./8"), "python")
    assert (judge(table)["found"], judge(table)["status"]) == (0, "unread")


ASSIGNED = """class Neri:
    coefs = ([1.3512071919596578, -1.7024143839193155], [0.6756035959798289, -0.1756035959798289])

    def step(ips, tau):
        k, d = Neri.coefs
""" + "".join(
    f"        ips = {'drift' if k % 2 == 0 else 'kick'}(ips, {'dk'[k % 2]}[{x}] * tau)\n"
    for k, x in enumerate([0, 0, 1, 1, 1, 0, 0])
) + "        return ips\n"  # fmt: skip


def test_flows_whose_value_is_the_new_state_are_a_splitting() -> None:
    (table,) = read(ASSIGNED, "python")
    assert judge(table)["found"] == 4
    other = read(ASSIGNED.replace("ips = kick(ips,", "new = kick(ips,"), "python")
    assert all(x.unread for x in other)


COMPOSED = """function step!(y, x, dt, ops)
    s = 2^(1 / 3)
    g = 1 / (2 - s)
    strang!(y, x, g*dt, ops)
    strang!(y, y, -s*g*dt, ops)
    strang!(y, y, g*dt, ops)
end
"""


def test_one_flow_that_goes_back_is_a_composition() -> None:
    (table,) = read(COMPOSED, "julia")
    assert (table.kind, judge(table)["found"]) == ("composition", 4)
    assert read(COMPOSED.replace("1 / 3", "1 / 5"), "julia") == []  # of a method of order 4
    assert read(COMPOSED.replace("-s*g", "s*g"), "julia") == []


def test_a_file_with_a_statement_in_the_first_columns_is_no_fixed_form() -> None:
    text = """MODULE yoshida
   SUBROUTINE weights(w)
         w(1) = 1.0d0/(2.0d0 - 2.0d0**(1.0d0/3.0d0))
         w(2) = 1.0d0 - &
                2.0d0*w(1)
         w(3) = w(1)
"""
    (table,) = tables(text, LANGUAGES["fortran"], fixed=True)
    assert judge(table)["found"] == 4


def test_letters_after_small_ones_are_those_of_two_flows() -> None:
    text = "\n".join(f"s{'CD'[k % 2]}{k // 2 + 1} = {x};" for k, x in enumerate(FOREST))
    (table,) = read(text, "matlab")
    assert judge(table)["found"] == 4


SPRK = """static Table ruth(void)
{
  Table table = Table_Alloc(3);
  table->q = 3;
  table->stages = 3;
  table->a[0] = 2.0/3.0;
  table->a[1] = -2.0/3.0;
  table->a[2] = 1.0;
  table->ahat[0] = 7.0/24.0;
  table->ahat[1] = 3.0/4.0;
  table->ahat[2] = -1.0/24.0;
  return table;
}"""


def test_a_and_a_hat_are_steps_of_two_flows_and_q_beside_the_stages_is_the_order() -> None:
    (table,) = read(SPRK, "c")
    assert (judge(table)["declared"], judge(table)["status"]) == (3, "right")
    (table,) = read(SPRK.replace("3.0/4.0", "3.0/5.0"), "c")
    assert judge(table)["status"] != "right"
    (table,) = read(SPRK.replace("  table->stages = 3;\n", ""), "c")
    assert table.order is None


def test_adding_to_any_vector_is_no_flow() -> None:
    rows = ["strang!(u, 0.25*dt)", "axpy!(u, g, 0.3*dt)", "strang!(g, 0.5*dt)",
            "axpy!(v, g, 0.7*dt)", "strang!(v, 0.25*dt)"]  # fmt: skip
    text = "function step!(u, v, g, dt)\n    " + "\n    ".join(rows) + "\nend\n"
    assert all(x.unread for x in read(text, "julia"))
    assert any(not x.unread for x in read(text.replace("axpy!", "kick!"), "julia"))


def test_constants_of_drifts_and_kicks_have_the_name_of_the_drifts() -> None:
    rows = [f"#define {'DRIFT' if k % 2 == 0 else 'KICK'}{k // 2 + 1} {x}"
            for k, x in enumerate(FOREST[:4])]  # fmt: skip
    (table,) = read("\n".join(rows), "c")
    assert (table.name, judge(table)["found"]) == ("DRIFT", 4)
