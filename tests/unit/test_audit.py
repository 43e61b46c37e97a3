"""``glmref audit``: small pieces of each syntax, a wrong entry in some, and what cannot be read."""

from __future__ import annotations

import ast
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from glmref.audit import code, julia
from glmref.audit.lexer import LANGUAGES
from glmref.audit.nearest_method import Library
from glmref.audit.readers import declared_orders, read
from glmref.audit.recognising import tables
from glmref.audit.sources import audit
from glmref.audit.table import Table
from glmref.audit.table_verdicts import judge
from glmref.audit.values import Unread, evaluate
from glmref.catalogue.lookup import document
from glmref.cli import main
from glmref.exact.expression import parse
from tests.build import source


def judged(text: str, form: str, language: str = "") -> dict[str, dict[str, Any]]:
    """Records by name, of a format or, without one, of a source in a language."""
    found = (
        tables(text, LANGUAGES[language], about=True, declared=declared_orders(text))
        if language
        else read(text, form, declared_orders(text))
    )
    return {x["name"]: x for x in [judge(y) for y in found]}


def test_sundials_tables_and_one_that_is_not_understood() -> None:
    found = judged(source("sundials.c"), "", "c")
    assert found["ARKODE_HEUN_EULER_2_1_2"]["status"] == "right"
    made = source("sundials.c").replace("SUN_RCONST(1.0)/SUN_RCONST(2.0);", "magic(3);", 1)
    unread = judged(made, "", "c")["ARKODE_HEUN_EULER_2_1_2"]
    assert unread["status"] == "unread" and "'magic' is not read (line 7)" in unread["remarks"][0]


def test_entries_of_an_object_that_was_cleared_are_zero() -> None:
    """A stiffly accurate row refers to a weight that is not given, because it is zero."""
    made = ("ARK_BUTCHER_TABLE(A3, {\n ARKodeButcherTable B = ARKodeButcherTable_Alloc(3, SUNFALSE);"
            "B->q = 2; B->p = 0; B->A[1][0] = 0.5; B->A[1][1] = 0.5; B->b[0] = 0.5; B->b[2] = 0.5;"
            "B->A[2][0] = B->b[0]; B->A[2][1] = B->b[1]; B->A[2][2] = B->b[2];"
            "B->c[1] = 1.0; B->c[2] = 1.0; return B; })")  # fmt: skip
    assert judged(made, "", "c")["A3"]["status"] == "right"


def test_petsc_registrations() -> None:
    found = judged(source("petsc.c"), "petsc")
    assert found["TSRK2R"]["status"] == "right"
    wrong = found["TSARKIMEXX"]
    assert (wrong["kind"], wrong["declared"], wrong["found"]) == ("additive", 2, 1)
    assert {"entry": "a[3][2]", "is": "3", "should be": "2"} in wrong["correction"]
    assert found["TSROSW2Z"]["status"] == "right"
    assert found["TSROSWY"]["status"] == "question"
    assert "a2 is the sentinel PETSC_CURRENT" in found["TSROSWY"]["remarks"][0]


def test_general_linear_methods_of_petsc() -> None:
    right = judged(source("glee.c"), "petsc")["TSGLEEMADE"]
    assert (right["kind"], right["found"], right["status"]) == ("glm", 2, "right")
    second = judged(source("glee.c").replace("-0.5, 0.5, 0.5}}", "-0.5, 0.25, 0.75}}"), "petsc")[
        "TSGLEEMADE"
    ]
    assert (second["found"], second["order_of_tree"], second["residual"]) == (1, 2, 0.25)
    assert second["status"] == "question"
    uneven = judged(source("glee.c").replace("U[4][2] = {{1, 0}", "U[4][2] = {{2, 0}"), "petsc")[
        "TSGLEEMADE"
    ]
    assert uneven["status"] == "wrong" and "U S = 1 fails by 1" in uneven["remarks"]
    cut = judged(
        source("glee.c").replace("V[2][2] = {{1, 0}, {0, 1}}", "V[2][2] = {{1, 0}}"), "petsc"
    )
    assert cut["TSGLEEMADE"]["status"] == "unread"


def test_julia_tables_in_their_four_styles() -> None:
    found = judged(source("julia.jl"), "julia")
    assert found["Kutta3"]["status"] == "right"
    assert found["Midpoint"]["correction"] == [{"entry": "c[2]", "is": "1/3", "should be": "1/2"}]
    cooper = found["Cooper2"]
    assert (cooper["declared"], cooper["found"], cooper["status"]) == (2, 1, "question")
    assert found["ARS222"]["status"] == "found" and found["ARS222"]["found"] == 2
    assert found["ARS222"]["kind"] == "additive"
    heun = found["HeunConstantCache"]
    assert heun["status"] == "wrong" and "sum to 0.25" in heun["remarks"][0]
    assert found["LeapfrogConstantCache"]["found"] == 2


def test_python_modules() -> None:
    found = judged(source("python.txt"), "", "python")
    assert found["_tableau"]["status"] == "right"
    assert found["RK3"]["status"] == "right"
    assert found["RadauIIA3"]["correction"][0] == {
        "entry": "a[2][2]", "is": "1/3", "should be": "1/4", "line": 22, "text": "1 / 3"
    }  # fmt: skip
    assert found["Heun22"]["status"] == "right"


def test_exchanged_rows_are_said_to_be_exchanged() -> None:
    swapped = judged(source("openmodelica.c"), "", "c")["getButcherTableau_SWAPPED"]
    assert swapped["status"] == "wrong" and swapped["found"] == 1
    assert "the rows may be exchanged" in swapped["remarks"][0]


@pytest.mark.slow
def test_a_row_of_its_own_order_is_not_said_to_be_exchanged() -> None:
    """The weights of Fehlberg's order 5 with a digit wrong, beside his row of order 4."""
    table = with_abscissae("fehlberg-5-4")
    b = ["17/135", *table["b"][1:]]
    low = [document("fehlberg-5-4")["embedded"][0]["b"], 4]
    record = judged(json.dumps({**table, "b": b, "embedded": [low]}), "json")["fehlberg-5-4"]
    assert (record["status"], record["found"], record["remarks"]) == ("wrong", 0, [])
    assert {"entry": "b[1]", "is": "17/135", "should be": "16/135"} in record["correction"]


def test_arrays_of_eigen_and_steps_of_fortran() -> None:
    (found,) = judged(source("eigen.cpp"), "", "c").values()
    assert found["status"] == "right" and found["declared"] == 1
    heun = judged(source("fortran.f90"), "", "fortran")["heun"]
    assert heun["status"] == "right" and heun["declared"] == 2 and heun["stages"] == 2


def test_a_quotient_by_zero_leaves_a_step_unread() -> None:
    text = source("fortran.f90").replace("/ 2.0_wp", "/ 0.0_wp")
    heun = judged(text, "", "fortran")["heun"]
    assert heun["status"] == "unread" and "divisor 0" in heun["remarks"][0]


def test_rosenbrock_methods_in_the_transformed_form() -> None:
    ros2 = judged(source("kpp.f90"), "kpp")["Ros2"]
    assert (ros2["kind"], ros2["declared"], ros2["found"]) == ("rosenbrock", 2, 2)
    broken = judged(source("kpp.f90").replace("(-2.0_dp)/g", "(-3.0_dp)/g"), "kpp")["Ros2"]
    assert broken["found"] == 0 and broken["status"] == "wrong"


def test_an_unread_table_has_no_verdict() -> None:
    assert judge(Table("x", 3, unread="why"))["status"] == "unread"


@pytest.mark.slow
def test_the_command_goes_on_after_what_it_cannot_read(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "good.py").write_text(source("python.txt"))
    bad = source("python.txt").replace("[0, 3/4, 0]]", "[0, f(2), 0]]")
    (tmp_path / "bad.py").write_text(bad[bad.index("class RK3") : bad.index("class RadauIIA3")])
    assert main(["audit", str(tmp_path)]) == 1
    out = capsys.readouterr()
    rows = [json.loads(x) for x in out.out.splitlines()]
    assert {(x["path"], x["status"]) for x in rows} >= {("bad.py", "unread"), ("good.py", "wrong")}
    assert "1 wrong" in out.err


def test_nothing_read_is_an_error_and_unread_is_not_strictly_right(
    tmp_path: Path, capsys: Any
) -> None:
    """Plain C arrays, which no reader takes; and one table that is read beside one that is not."""
    (tmp_path / "rk.c").write_text("double A[2][2] = {{0, 0}, {1, 0}};\ndouble b[2] = {.5, .5};\n")
    assert main(["audit", str(tmp_path / "rk.c"), "--format", "odeint"]) == 2
    out = capsys.readouterr()
    assert out.out == "" and "no table is found in" in out.err and "--from" in out.err
    path = tmp_path / "two.json"
    path.write_text('[{"A": [[0]], "b": [1], "order": 1}, {"A": [[0]], "b": [1, 2]}]')
    assert main(["audit", str(path), "--format", "json", "--fast"]) == 0
    (row,) = [json.loads(x) for x in capsys.readouterr().out.splitlines()]
    assert (row["format"], row["status"]) == ("glmref-audited-table-1", "unread")
    assert main(["audit", str(path), "--format", "json", "--strict", "--fast"]) == 1
    path = tmp_path / "one.json"
    path.write_text('{"A": [[0]], "b": [1, 2]}')
    assert main(["audit", str(path), "--format", "json"]) == 2
    assert "no table is understood in" in capsys.readouterr().err


def test_nothing_in_a_source_is_executed(tmp_path: Path) -> None:
    there = tmp_path / "made"
    text = f"A = __import__('pathlib').Path({str(there)!r}).touch()\nclass X(Y):\n    A = A\n"
    tables(text + "    B = [1]\n    C = [0]\n", LANGUAGES["python"], about=True)
    assert not there.exists()


@pytest.mark.parametrize("form", ["petsc", "julia", "kpp"])
def test_a_folder_without_sources_is_one_sentence(form: str, tmp_path: Path, capsys: Any) -> None:
    assert main(["audit", str(tmp_path), "--format", form]) == 2
    assert "holds no file" in capsys.readouterr().err


PLAIN_CSV = """name,A,b,order,embedded
Heun,0 0; 1 0,1/2 0.5,2,"[{""error"": [""1/2"", ""-1/2""]}]"
wrong,0 0; 1 0,1/4 3/4,2,
odd,0 0; 1,1 0,1,
"""


def test_plain_json_holds_one_table_or_many() -> None:
    found = judged(source("plain-json.json"), "json")
    status = {name: x["status"] for name, x in found.items()}
    assert [status[x] for x in ("Heun", "Stormer", "Euler")] == ["right"] * 3
    assert status["lost"] == "wrong" and found["lost"]["line"] == 3
    assert found["lost"]["correction"][0] == {"entry": "a[3][2]", "is": "1", "should be": "2"}
    assert (status["odd"], status["short"], status["table 7"]) == ("unread",) * 3
    one = judged('{"A": [[0]], "b": [1], "order": 1}', "json")
    named = judged('{"Euler": {"A": [[0]], "b": [1], "order": 2}}', "json")
    assert one["table 1"]["status"] == "right" and named["Euler"]["found"] == 1
    assert judged("{", "json")[""]["status"] == "unread"


def with_abscissae(name: str) -> dict[str, Any]:
    """A table of the catalogue as plain fractions, with c = A 1."""
    doc = document(name)
    A = [[Fraction(x) for x in row] for row in doc["A"]]
    c = [str(sum(row)) for row in A]
    return {"name": name, "A": doc["A"], "b": doc["b"], "c": c, "order": doc["claims"]["order"]}


def test_a_wrong_digit_far_behind_is_named_and_a_rounded_row_is_not() -> None:
    table = with_abscissae("dormand-prince-5-4")
    A = [list(row) for row in table["A"]]
    A[4][2] = str(Fraction(A[4][2]) + Fraction(1, 10**11))
    record = judged(json.dumps({**table, "A": A}), "json")["dormand-prince-5-4"]
    assert (record["status"], record["found"]) == ("wrong", 5)
    (named,) = record["correction"]
    assert named["entry"] == "a[5][3]" and float(named["should be"]) == 64448 / 6561
    A[4] = [f"{float(Fraction(x)):.11f}" for x in table["A"][4]]  # each digit of the row is lost
    record = judged(json.dumps({**table, "A": A}), "json")["dormand-prince-5-4"]
    assert record["status"] == "digits" and not record["correction"]


def test_a_row_that_adds_the_error_instead_is_said_to() -> None:
    table = with_abscissae("fehlberg-5-4")
    low, high = document("fehlberg-5-4")["embedded"][0]["b"], table["b"]
    mirrored = [str(2 * Fraction(x) - Fraction(y)) for x, y in zip(low, high, strict=True)]
    for row, status in ((high, "right"), (mirrored, "wrong")):
        text = json.dumps({**table, "b": low, "order": 4, "embedded": [[row, 5]]})
        record = judged(text, "json")["fehlberg-5-4"]
        assert record["status"] == status, record
    assert any("2 b minus this row has order 5" in x for x in record["remarks"])


def test_a_stage_that_only_estimates_see_is_judged_by_its_row() -> None:
    """Bogacki-Shampine 3(2): the last row is b, and no condition of order 3 looks at it."""
    text = """{"A": [[0, 0, 0, 0], ["1/2", 0, 0, 0], [0, "3/4", 0, 0], ["2/9", "1/3", "5/9", 0]],
    "b": ["2/9", "1/3", "4/9", 0], "c": [0, "1/2", "3/4", 1], "order": 3}"""
    (table,) = read(text, "json", {})
    record = judge(table)
    assert record["status"] == "wrong"
    assert record["correction"] == [{"entry": "a[4][3]", "is": "5/9", "should be": "4/9"}]
    (table,) = read(text.replace("5/9", "4/9"), "json", {})
    assert judge(table)["status"] == "right"


def test_plain_csv_has_a_table_in_each_row() -> None:
    found = judged(PLAIN_CSV, "csv")
    assert found["Heun"]["status"] == "right" and found["Heun"]["line"] == 2
    assert found["wrong"]["found"] == 1 and found["odd"]["status"] == "unread"


def test_a_plain_table_read_as_a_source_names_its_reader(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "heun.csv").write_text("name,A,b,order\nHeun,0 0; 1 0,1/2 1/2,2\n")
    assert main(["audit", str(tmp_path / "heun.csv")]) == 2
    assert "is not known; --from csv reads it" in capsys.readouterr().out
    assert main(["audit", str(tmp_path / "heun.csv"), "--from", "csv"]) == 0


def test_a_folder_without_a_table_leads_to_its_files(tmp_path: Path, capsys: Any) -> None:
    text = "A = [[0, 0, 0], [0.5, 0, 0], [-1, 3, 0]]\nb = [1/6, 2/3, 1/6]\nc = [0, 0.5, 1]\n"
    (tmp_path / "m.py").write_text(text)  # one row in two sums to its node: noise, in a folder
    assert main(["audit", str(tmp_path)]) == 2
    assert "; a file given by its name is searched more closely; " in capsys.readouterr().err
    assert main(["audit", str(tmp_path / "m.py")]) == 0
    assert '"entry": "a[3][2]", "is": "3", "should be": "2"' in capsys.readouterr().out


def test_the_command_offers_every_reader() -> None:
    from glmref.audit.readers import FORMATS, SUFFIXES
    from glmref.audit.sources import _MARKS
    from glmref.cli.auditing import READ

    assert set(READ) == set(FORMATS) == set(SUFFIXES) == set(_MARKS)


def test_members_of_principia() -> None:
    found = judged(source("principia.hpp"), "principia")
    assert found["Leapfrog"]["status"] == "right" and found["Leapfrog"]["kind"] == "splitting"
    assert found["Heun"]["status"] == "right" and found["Heun"]["found"] == 2
    assert found["Adams"]["status"] == "unread"
    assert found["Stormer"]["status"] == "right" and found["Stormer"]["kind"] == "nystrom"
    assert found["Stormer, lower order"]["found"] == 0
    wrong = judged(
        source("principia.hpp").replace("b̂{{{0.5, 0.5}}}", "b̂{{{0.5, 0.25}}}"), "principia"
    )
    assert wrong["Heun"]["found"] == 0


def test_structs_of_odeint_and_functions_of_gsl() -> None:
    text = (
        "/* Runge-Kutta */\nint kutta_apply(void *s) {}\nint kutta_order(void *s) { return 3; }\n"
    )
    assert judged(text, "", "c")["kutta"]["status"] == "unread"
    assert not judged(text.replace("_apply", "_sort"), "", "c")
    assert judged(source("odeint.hpp"), "odeint")["midpoint"]["status"] == "right"
    pair = judged(source("odeint-pair.hpp"), "odeint")["pair"]
    assert (pair["status"], pair["declared"], pair["stages"]) == ("right", 2, 3)
    open_ = judged(
        source("odeint-pair.hpp").replace("dc2 = static_cast<value_type>( 0 )", "dc2 = c1"),
        "odeint",
    )
    assert "sum to 0.5" in open_["pair"]["remarks"][0]


def test_orders_beyond_twelve_are_looked_at_within_a_budget() -> None:
    from glmref.errors import BudgetError
    from glmref.exact import Exact
    from glmref.prove.schemes import reach, runge_kutta
    from glmref.system.budget import limited

    midpoint = runge_kutta(((Exact(1) / 2,),), (Exact(1),))
    with pytest.raises(BudgetError), limited(0.01):
        reach(midpoint, 14, high=True)


def test_numbers_with_names_of_their_own() -> None:
    heun = judged(source("named.cpp"), "constants")["Heun"]
    assert (heun["found"], heun["stages"], heun["status"]) == (2, 2, "found")
    spoilt = judged(source("named.cpp").replace("e2 = -0.5", "e2 = 0.5"), "constants")["Heun"]
    assert spoilt["status"] == "wrong" and "sum to 1" in spoilt["remarks"][0]
    for lost in ("b2 = 1.0 - Heun::b1,", "e1 = 1.0 - 0.5,"):  # a statement without its end
        spoilt = judged(source("named.cpp").replace(lost, lost[:-1]), "constants")["Heun"]
        assert spoilt["status"] == "unread" and "a `;` is missing" in spoilt["remarks"][0]
    heavy = judged(source("named.cpp").replace("b1 = 0.5", "b1 = 0.5 + 1./9.").replace("1.0 - Heun::b1", "0.5"),
                   "constants")["Heun"]  # fmt: skip
    assert (heavy["found"], heavy["status"]) == (0, "wrong")
    assert "the order is 0: the weights do not sum to 1" in heavy["remarks"]
    (table,) = read(source("named-b.cpp"), "constants", declared_orders(source("named-b.cpp")))
    pair = judge(table)
    assert (pair["declared"], pair["found"], pair["stages"]) == (2, 3, 4)
    assert not pair["remarks"]  # the rows sum to c, the error weights to 0


def test_java_methods_that_return_arrays() -> None:
    kutta = judged(source("java-static.java"), "", "java")["KuttaIntegrator"]
    assert (kutta["declared"], kutta["found"], kutta["status"]) == (3, 3, "wrong")
    assert "sum to 0.25" in kutta["remarks"][0]
    assert judged(source("java.java"), "", "java")["GillFieldIntegrator"]["status"] == "unread"
    rows = "b[1] = getField().getTwo();"
    whole = source("java.java").replace("b[1] = a(0);", (
        "b[1] = sqrt2.subtract(2).divide(-6); b[2] = sqrt2.add(2).divide(6); b[3] = fraction(1, 6);"
    )).replace("final T[] b =", "final T sqrt2 = getField().getOne().newInstance(2).sqrt();\n        final T[] b =")  # fmt: skip
    gill = judged(whole, "", "java")["GillFieldIntegrator"]
    assert gill["found"] == 4 and rows not in whole


def test_rust_functions_and_constants() -> None:
    found = judged(source("rust.rs"), "", "rust")
    assert found["HEUN_2_A"]["status"] == "found" and found["HEUN_2_A"]["found"] == 2
    gauss = found["gauss"]  # the root is given to ten digits
    assert (gauss["declared"], gauss["status"], set(found)) == (4, "digits", {"HEUN_2_A", "gauss"})


def test_an_array_of_a_wrong_size_is_unread_and_the_rest_is_read() -> None:
    found = judged(source("rust.rs").replace("a[1][1] = 0.2_5", "a[1][2] = 0.2_5"), "", "rust")
    assert (found["gauss"]["status"], found["HEUN_2_A"]["status"]) == ("unread", "found")
    assert "an entry of a lies outside of it" in found["gauss"]["remarks"][0]
    (table,) = read(
        '{"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "c": [0, 1], "order": 2}', "json", {}
    )
    table.c = [[*(table.c[0] or []), *table.b[0]]]
    record = judge(table)
    assert record["status"] == "unread" and "have the sizes [2, 4]" in record["remarks"][0]


def test_methods_of_matlode() -> None:
    heun = judged(source("matlode.m"), "matlode")["Coefficients_Heun"]
    assert (heun["found"], heun["status"]) == (2, "wrong")
    assert "the weights of the error estimate sum to 1, not to 0" in heun["remarks"]


def test_python_classes_that_change_their_arrays() -> None:
    found = judged(source("classes.txt"), "", "python")
    assert found["Three"]["status"] == "unread" and "run time" in found["Three"]["remarks"][0]
    assert "Loop" not in found
    assert found["Heun"]["status"] == "right" and found["Heun"]["declared"] == 2
    assert (found["Nystrom"]["kind"], found["Nystrom"]["status"]) == ("nystrom", "right")
    assert found["TABLEAU"]["status"] == "right" and found["TABLEAU"]["declared"] == 2


def test_ode_jl_tables() -> None:
    (pair,) = judged(
        "const bt_rk21 = TableauRKExplicit(:heun_euler,(2,1), Rational{Int64},\n"
        "   [0     0\n    1     0],\n   [1//2  1//2\n    1     0],\n   [0,    1])\n",
        "julia",
    ).values()
    assert (pair["name"], pair["declared"], pair["status"]) == ("heun_euler", 2, "right")


def test_the_transformed_form_is_read_from_julia() -> None:
    (table,) = read(source("rodas.jl"), "julia", {"Two2": 2})
    assert (table.kind, table.order, table.rows) == ("rosenbrock", 2, [])
    gamma = [[x.value.as_fraction() for x in row] for row in table.A[1]]
    # C = diag(1/gamma) - Gamma^-1, so that gamma_21 = gamma c_21 gamma
    assert gamma == [[Fraction(1, 2), 0], [Fraction(-1, 4), Fraction(1, 2)]]
    assert [x.value.as_fraction() for x in table.b[0]] == [Fraction(7, 20), Fraction(1, 2)]


def test_the_family_of_steyer_is_read_from_julia() -> None:
    (table,) = read(source("imkg.jl"), "julia")
    explicit, implicit = table.A
    known = document("imkg-232a")["parts"]
    for part, (*rows, weights) in zip(known, (explicit, implicit), strict=True):
        for row, numbers in zip((*part["A"], part["b"]), (*rows, weights), strict=True):
            *kept, last = numbers
            assert last.value.is_zero()
            assert all((parse(x) - y.value).is_zero() for x, y in zip(row, kept, strict=True))


def test_stages_numbered_from_zero_and_weights_that_are_not_read() -> None:
    first, second, third = read(source("constants.jl"), "julia", {"Euler2": 2})
    assert [[x.value.as_fraction() for x in row] for row in first.A[0]] == [[0, 0], [1, 0]]
    assert judge(first, search=False)["status"] == "right"
    assert "two steps" in second.unread and "`α`" in third.unread


def test_nystrom_tables_of_julia() -> None:
    (table,) = read(source("nystrom.jl"), "julia", {"Nystrom4": 4})
    assert (table.kind, table.order) == ("nystrom", 4)
    assert judge(table, search=False)["status"] == "right"
    (wrong,) = read(source("nystrom.jl").replace("2 // 6", "1 // 6"), "julia", {"Nystrom4": 4})
    assert judge(wrong, search=False)["status"] != "right"


def test_broadcasts_calls_after_semicolons_and_lines_that_go_on() -> None:
    text = """
function Two()
    A = [0 0; 1 0]
    α = [big"1" // 2; BigInt(1) //
        BigInt(2)]
    low = α .- [1 // 2, -1 // 2]
    return ExplicitRKTableau(A, [0, 1], α, 2, αEEst = low, adaptiveorder = 1)
end
"""
    (table,) = read(text, "julia")
    record = judge(table, search=False)
    assert (record["status"], record["found"]) == ("right", 2), record


class Counted(str):
    """A text that counts the characters that are taken from it."""

    taken = 0

    def __getitem__(self, key: Any) -> str:
        found = super().__getitem__(key)
        self.taken += len(found)
        return found


def test_a_statement_of_any_length_is_looked_at_a_few_times() -> None:
    text = Counted("a = [\n" + "    0.25,\n" * 300 + "]\nb = 1\n")
    assert [x.line for x in julia.julia_statements(text)] == [1, 303]
    assert text.taken < 4 * len(text)


def test_an_array_of_c_of_any_length_is_looked_at_a_few_times() -> None:
    text = Counted("double a[] = {\n" + "    {0.25, 1},\n" * 300 + "};\n#define B 1\nint c = 2;\n")
    assert [x.line for x in code.c_statements(text)] == [1, 303, 304]
    assert text.taken < 4 * len(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[x for x in span(1, 2) for y in span(1, 2)]", "a loop is not read"),
        ("[x for x in span(1, 2) if x]", "a loop is not read"),
        ("[x for x in y]", "a loop is not read"),
        ("[x for x, y in span(1, 2)]", "a loop is not read"),
        ("[x for x in span(1, 2, 2)]", "a range with a step is not read"),
        ("[x for x in span(1, last=2)]", "a range with a step is not read"),
        ("[x for x in span(1, [2])]", "the ends of a range must be numbers"),
        ("[x for x in span(1, 300)]", "a loop is too long"),
    ],
)
def test_comprehensions_of_another_form_are_unread(text: str, said: str) -> None:
    with pytest.raises(Unread, match=said):
        evaluate(ast.parse(text, mode="eval").body, {})
    found = evaluate(ast.parse("[2 * x for x in span(1, 3)]", mode="eval").body, {})
    assert [x.whole() for x in found] == [2, 4, 6]


@pytest.mark.slow
def test_a_splitting_that_lacks_a_step_is_compared_with_the_catalogue(monkeypatch: Any) -> None:
    """McLachlan's Nystrom splitting with five steps of the position, as though they summed so."""
    monkeypatch.setattr("glmref.audit.nearest_method.names", lambda: ["ruth-3", "mclachlan-rkn-4"])
    (table,) = read(source("shortened.jl"), "julia")
    assert table.kind == "splitting"
    table, library = replace(table, order=4), Library()
    (said,) = judge(table, library)["remarks"]
    assert said == (
        "b is that of mclachlan-rkn-4, which has 6 a: 0.405188618395, -0.287144040817, "
        "0.381955422421, 0.381955422421, -0.287144040817, 0.405188618395"
    )
    other = replace(table, b=[table.b[0], table.b[1][:4]])
    assert library.steps(other, 4) == ""


@pytest.mark.parametrize(
    ("name", "large"), [("b2", "b2000000"), ("btilde2", "btilde2000000"), ("a21", "a2000001")]
)
def test_a_name_does_not_make_a_table_of_millions_of_stages(name: str, large: str) -> None:
    heun = judged(source("julia.jl").replace(f"{name} =", f"{large} ="), "julia")[
        "HeunConstantCache"
    ]
    assert heun["status"] == "unread" and "more than 200 stages" in str(heun["remarks"])


#: What a line makes of ``a`` when it is repeated.
GROWING = ("a = a^40", "a = a*a", "a = vcat(a, a)", "a = [a, a]", "a = zeros(100, 100, 100, 100)",
           "a = [[[1 for i in 1:200] for j in 1:200] for k in 1:9]", "a = a + a")  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize("line", GROWING)
@pytest.mark.parametrize("first", ["10^40", "[1, 1]", "sqrt(2) + 3"])
def test_numbers_and_arrays_of_a_source_do_not_grow_without_bound(
    tmp_path: Path, line: str, first: str
) -> None:
    text = f"function T()\na = {first}\n" + f"{line}\n" * (1 if "for" in line else 40)
    path = tmp_path / "x.jl"
    path.write_text(f"{text}A = [0 0; 1 0]\nreturn ExplicitRKTableau(A, [0, 1], a, 2)\nend\n")
    begun = process_time()
    (record,) = audit(path, "julia", compare=False)
    assert record["status"] == "unread" and record["remarks"]
    assert process_time() - begun < 5


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("form", "text"),
    [
        ("petsc", "TSRKRegister\n" + "/*" * 200_000),
        ("julia", "Tableau\n" + "#=" * 200_000),
        ("julia", "Tableau\n" + "x +\n" * 20_000),
        ("julia", "Tableau\nx = " + "1" * 100_000),
        ("json", '["A", ' + "0, " * 20_000 + "0]"),
        ("json", '{"A": [[0]], "A": [[1]], "b": [1], "order": 1}'),
        ("csv", f"name,b\n{'x' * 200_000},1\n"),
        ("", f"def step(f, t, y, h):\n  k = {'f(t, ' * 10_000}y{')' * 10_000}\n  return y + h*k\n"),
        ("", "def step(f, t, y, h):\n" + "  k = f(t, y + h*k/2)\n" * 10_000 + "  return y + k\n"),
    ],
)
def test_sources_are_read_in_linear_time(tmp_path: Path, form: str, text: str) -> None:
    path = tmp_path / ("x" if form else "x.py")
    path.write_text(text)
    begun = process_time()
    assert all(x["status"] == "unread" for x in audit(path, form, compare=False))
    assert process_time() - begun < 5


def test_the_residual_is_that_of_the_tree_that_is_named() -> None:
    """RadauIIA3 with 1/3 for 1/4: [f] misses 1/2 by 1/48, a tree of order 3 misses by 0.043."""
    found = judged(source("python.txt"), "", "python")["RadauIIA3"]
    assert (found["status"], found["tree"], found["order_of_tree"]) == ("wrong", "f[f]", 2)
    assert found["residual"] == 0.021


def test_of_rounded_numbers_the_worst_tree_is_named() -> None:
    rounded = {"A": [[0, 0], ["0.666666666", 0]], "b": ["1/4", "3/4"], "order": 2}
    (found,) = [judge(x) for x in read(json.dumps(rounded), "json", {})]
    assert (found["status"], found["tree"], found["residual"]) == ("digits", "[o]", 5e-10)


FREQUENCY = {x: source(f"frequency-{x}") for x in ("tableaus.jl", "steps.jl")}


def test_a_table_that_a_step_completes_is_unread(tmp_path: Path) -> None:
    for name, text in FREQUENCY.items():
        (tmp_path / name).write_text(text)
    (found,) = audit(tmp_path, "julia", compare=False)
    assert (found["name"], found["status"], found["line"]) == ("Made2ConstantCache", "unread", 6)
    assert found["remarks"] == ["completed at run time: a step assigns to a21 (steps.jl:6)"]
    (tmp_path / "steps.jl").write_text(FREQUENCY["steps.jl"].replace("a21 +=", "a =="))
    (found,) = audit(tmp_path, "julia", compare=False)
    assert (found["status"], found["found"]) == ("right", 2)


def test_an_embedded_row_of_a_rosenbrock_method_has_its_declared_order() -> None:
    """ELO is one more than the lower of the two orders: in Ros2 2, the embedded row has order 1."""
    elo = source("kpp.f90").replace("    ros_S = 2\n", "    ros_S = 2\n    ros_ELO = 2.0_dp\n")
    assert judged(elo, "kpp")["Ros2"]["status"] == "right"
    wrong = judged(elo.replace("ros_ELO = 2", "ros_ELO = 3"), "kpp")["Ros2"]
    assert (wrong["status"], wrong["found"]) == ("wrong", 2)
    assert wrong["remarks"] == ["the row m - E is declared of order 2 and has order 1"]


def test_one_row_that_is_not_c_is_a_question_though_the_order_holds() -> None:
    """3/13 beside 3/16 in a method of order 3, as the row of a stage that only order 4 sees."""
    third = "3/13"
    table = {
        "A": [[0] * 5, ["1/7", 0, 0, 0, 0], [0, third, 0, 0, 0], [0, 0, "1/3", 0, 0],
              [0, 0, 0, "2/3", 0]],
        "b": ["1/4", 0, 0, 0, "3/4"], "c": [0, "1/7", "3/16", "1/3", "2/3"], "order": 3,
    }  # fmt: skip
    (found,) = [judge(x) for x in read(json.dumps(table), "json", {})]
    assert (found["status"], found["found"]) == ("question", 3)
    assert found["remarks"][-1] == "no other row does; the order holds on y' = f(t, y), too"
    right = json.dumps(table).replace("3/13", "3/16")
    assert judge(*read(right, "json", {}))["status"] == "right"


def test_weights_of_a_composition_have_the_order_of_the_sum_of_their_cubes() -> None:
    found = judged(source("chains.cpp"), "weights")
    assert [(x["name"], x["line"], x["found"], x["status"]) for x in found.values()] == [
        ("sy_const_3, 3", 3, 2, "question"), ("sy_right, 3", 4, 4, "found"),
        ("getYoshidaWeights, 7", 6, 6, "found"),
    ]  # fmt: skip
    assert found["sy_const_3, 3"]["remarks"] == [
        "the sum of the cubes of the weights is 0.855, for order 4 it is 0"
    ]


def test_drifts_beside_the_weights_of_a_composition_are_no_weights() -> None:
    """Yoshida (1990), order 4: the four drifts sum to 1 and read the same backwards, too."""
    text = (
        "// symplectic steps of Yoshida\n"
        "double c[4] = {0.6756035959798289, -0.1756035959798288, -0.1756035959798288, "
        "0.6756035959798289};\n"
        "double d[3] = {1.3512071919596578, -1.7024143839193153, 1.3512071919596578};\n"
    )
    found = judged(text, "weights")
    assert [(x["line"], x["found"], x["status"]) for x in found.values()] == [(3, 4, "found")]


def test_a_list_that_nothing_calls_weights_of_a_composition_is_not_read() -> None:
    other = (
        source("chains.cpp")
        .replace("Suzuki-Yoshida", "Gauss")
        .replace("sy_", "q_")
        .replace("Yoshida", "")
    )
    assert judged(other, "weights") == {}


def test_matrices_of_a_linear_system_are_no_tableau() -> None:
    """A, B, C of x' = A x + B u, y = C x: weights of order 0 and c that is not A 1, undeclared."""
    assert not judged(source("system.txt"), "", "python")


def test_the_notation_is_given_with_from_as_in_import(tmp_path: Path, capsys: Any) -> None:
    """``--format``, which elsewhere is that of the output, is accepted, too."""
    source = tmp_path / "weights.c"
    source.write_text("double a21 = 1.0;\ndouble b1 = 0.5;\ndouble b2 = 0.5;\n", encoding="utf-8")
    found = []
    for option in ("--from", "--format"):
        assert main(["audit", str(source), option, "constants", "--all"]) == 0
        found.append(capsys.readouterr().out)
    assert found[0] == found[1] and '"found": 2' in found[0]
