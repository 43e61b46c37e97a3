"""``glmref audit``: small pieces of each syntax, a wrong entry in some, and what cannot be read."""

import ast
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from glmref.audit import code, julia
from glmref.audit.lexer import ENDINGS, LANGUAGES, language_of
from glmref.audit.nearest_method import Library
from glmref.audit.readers import declared_orders, read
from glmref.audit.recognising import size, tables
from glmref.audit.sources import audit
from glmref.audit.table import Table
from glmref.audit.table_verdicts import judge
from glmref.audit.values import Unread, evaluate
from glmref.catalogue.lookup import document
from glmref.cli import main
from glmref.exact.expression import parse
from tests.build import source
from tools.audit_recall import Seen, compared


def judged(text: str, form: str, language: str = "") -> dict[str, dict[str, Any]]:
    """Records by name, of a format or, without one, of a source in a language."""
    found = (
        tables(text, LANGUAGES[language], about=True, declared=declared_orders(text))
        if language
        else read(text, form, declared_orders(text))
    )
    return {x["name"]: x for x in [judge(y) for y in found]}


@pytest.mark.slow
def test_a_row_of_its_own_order_is_not_said_to_be_exchanged() -> None:
    """The weights of Fehlberg's order 5 with a digit wrong, beside his row of order 4."""
    table = with_abscissae("fehlberg-5-4")
    b = ["17/135", *table["b"][1:]]
    low = [document("fehlberg-5-4")["embedded"][0]["b"], 4]
    record = judged(json.dumps({**table, "b": b, "embedded": [low]}), "json")["fehlberg-5-4"]
    assert (record["status"], record["found"], record["remarks"]) == ("wrong", 0, [])
    assert {"entry": "b[1]", "is": "17/135", "should be": "16/135"} in record["correction"]


def test_an_unread_table_has_no_verdict() -> None:
    assert judge(Table("x", 3, unread="why"))["status"] == "unread"


@pytest.mark.slow
def test_the_command_goes_on_after_what_it_cannot_read(tmp_path: Path, cli) -> None:
    (tmp_path / "good.py").write_text(source("python.txt"))
    bad = source("python.txt").replace("[0, 3/4, 0]]", "[0, f(2), 0]]")
    (tmp_path / "bad.py").write_text(bad[bad.index("class RK3") : bad.index("class RadauIIA3")])
    out = cli("audit", tmp_path, code=1)
    rows = [json.loads(x) for x in out.out.splitlines()]
    assert {(x["path"], x["status"]) for x in rows} >= {("bad.py", "unread"), ("good.py", "wrong")}
    assert "1 wrong" in out.err


def test_nothing_read_is_an_error_and_unread_is_not_strictly_right(tmp_path, capsys, cli):
    """Plain C arrays, which no reader takes; and one table that is read beside one that is not."""
    (tmp_path / "rk.c").write_text("double A[2][2] = {{0, 0}, {1, 0}};\ndouble b[2] = {.5, .5};\n")
    out = cli("audit", tmp_path / "rk.c", "--from", "odeint", code=2)
    assert out.out == "" and "no table is found in" in out.err and "--from" in out.err
    path = tmp_path / "two.json"
    path.write_text('[{"A": [[0]], "b": [1], "order": 1}, {"A": [[0]], "b": [1, 2]}]')
    assert main(["audit", str(path), "--from", "json", "--fast"]) == 0
    (row,) = [json.loads(x) for x in capsys.readouterr().out.splitlines()]
    assert (row["format"], row["status"]) == ("glmref-audited-table-1", "unread")
    assert main(["audit", str(path), "--from", "json", "--strict", "--fast"]) == 1
    path = tmp_path / "one.json"
    path.write_text('{"A": [[0]], "b": [1, 2]}')
    assert "no table is understood in" in cli("audit", path, "--from", "json", code=2).err


def test_nothing_in_a_source_is_executed(tmp_path: Path) -> None:
    there = tmp_path / "made"
    text = f"A = __import__('pathlib').Path({str(there)!r}).touch()\nclass X(Y):\n    A = A\n"
    tables(text + "    B = [1]\n    C = [0]\n", LANGUAGES["python"], about=True)
    assert not there.exists()


@pytest.mark.parametrize("form", ["petsc", "julia", "odeint"])
def test_a_folder_without_sources_is_one_sentence(form: str, tmp_path: Path, cli) -> None:
    assert "holds no file" in cli("audit", tmp_path, "--from", form, code=2).err


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


def test_orders_beyond_twelve_are_looked_at_within_a_budget() -> None:
    from glmref.errors import BudgetError
    from glmref.exact import Exact
    from glmref.prove.schemes import reach, runge_kutta
    from glmref.system.budget import limited

    midpoint = runge_kutta(((Exact(1) / 2,),), (Exact(1),))
    with pytest.raises(BudgetError), limited(0.01):
        reach(midpoint, 14, high=True)


def test_nodes_of_another_number_than_the_stages_are_unread() -> None:
    (table,) = read(
        '{"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "c": [0, 1], "order": 2}', "json", {}
    )
    table.c = [[*(table.c[0] or []), *table.b[0]]]
    record = judge(table)
    assert record["status"] == "unread" and "have the sizes [2, 4]" in record["remarks"][0]


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


#: What a line makes of ``a`` when it is repeated.
GROWING = ("a = a^40", "a = a*a", "a = vcat(a, a)", "a = [a, a]", "a = zeros(100, 100, 100, 100)",
           "a = [[[1 for i in 1:200] for j in 1:200] for k in 1:9]", "a = a + a")  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize("line", GROWING)
@pytest.mark.parametrize("first", ["10^40", "[1, 1]", "sqrt(2) + 3"])
def test_numbers_and_arrays_of_a_source_do_not_grow_without_bound(tmp_path, line, first):
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


def test_the_notation_is_given_with_from_as_in_import(tmp_path: Path, cli) -> None:
    source = tmp_path / "weights.c"
    source.write_text("double a21 = 1.0;\ndouble b1 = 0.5;\ndouble b2 = 0.5;\n", encoding="utf-8")
    assert '"found": 2' in cli("audit", source, "--from", "constants", "--all").out


# --- any file -------------------------------------------------------------------------------------


CLASSES = """
# Runge-Kutta methods
class Heun3(Solver):
    order = 3
    A = np.array([[0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]])
    b = np.array([1 / 4, 0, 3 / 4])
    c = np.array([0, 1 / 3, 2 / 3])
"""


def test_every_ending_has_a_language() -> None:
    assert set(ENDINGS.values()) == set(LANGUAGES)
    assert language_of(Path("a.unknown")) is None


def test_the_command_needs_no_format(tmp_path: Path, cli) -> None:
    """Several paths, one with a wrong table; without any table nothing is green."""
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(CLASSES, "utf-8")
    wrong.write_text(CLASSES.replace("[0, 2 / 3, 0]]", "[0, 2 / 5, 0]]"), "utf-8")
    assert json.loads(cli("audit", right, "--all").out)["status"] == "right"
    (record,) = map(json.loads, cli("audit", right, wrong, code=1).out.splitlines())
    assert (record["path"], record["name"]) == ("wrong.py", "Heun3")
    other = tmp_path / "other"
    other.mkdir()
    (other / "nothing.py").write_text("x = 1\n", "utf-8")
    assert main(["audit", str(other)]) == 2
    assert list(audit(other)) == []


#: Samples of the formats, with their language and the tables that both readers see.
SAMPLES = [
    (source("petsc.c"), "petsc", "c", 1),
    (source("julia.jl"), "julia", "julia", 3),
    (source("named-b.cpp"), "constants", "c", 1),
]


@pytest.mark.parametrize(("text", "form", "language", "count"), SAMPLES)
def test_both_readers_see_the_same_numbers(text: str, form: str, language: str, count: int) -> None:
    """The reader of a format and the one of all sources, where both read a table."""

    def numbers(found: Any) -> set[tuple[float, ...]]:
        kinds = ("rk", "additive")
        return {
            tuple(float(f"{size(x):.9g}") for row in (*A, b) for x in row)
            for table in found
            if table.kind in kinds
            for A, b in zip(table.A, table.b, strict=True)
        }

    remark = {"python": "#", "julia": "#", "matlab": "%"}.get(language, "//")
    general = tables(f"{remark} Runge-Kutta\n{text}", LANGUAGES[language])
    assert len(numbers(read(text, form, {})) & numbers(general)) >= count


_RK3 = '"A": [[0, 0, 0], [1/2, 0, 0], [-1, 2, 0]], "order": 3, "b": [1/6, 2/3,'


@pytest.mark.parametrize(
    ("name", "text", "states"),
    [
        ("own.c", "double A[2][2] = {{0, 0}, {0.5, 0}}, b[2] = {0, 1}, c[2] = {0, 0.5};", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//6]", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//3]", ["wrong"]),
        ("own.py", f"RK3 = {{{_RK3} 1/6]}}\nBAD = {{{_RK3} 1/3]}}", ["right", "wrong"]),
    ],
)  # fmt: skip
def test_a_file_that_is_given_needs_no_word_of_the_subject(tmp_path, name, text, states):
    """A file of two arrays was no table, and weights with another sum were passed over."""
    (tmp_path / name).write_text(text)
    assert [x["status"] for x in audit(tmp_path / name)] == states
    (tmp_path / "A.jl").write_text(
        "A = [0 1//2; 1//3 1//7]\nb = [1//6, 2//3]"
    )  # of another subject
    assert [x["path"] for x in audit(tmp_path) if x["path"] == "A.jl"] == []


# --- recall ---------------------------------------------------------------------------------------


RK4 = (
    "# Runge-Kutta\nclass Kutta:\n    order = 4\n"
    "    A = [[0, 0, 0, 0], [1 / 2, 0, 0, 0], [0, 1 / 2, 0, 0], [0, 0, 1, 0]]\n"
    "    b = [1 / 6, 1 / 3, 1 / 3, 1 / 6]\n"
)


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (("", ""), Seen.ALIKE),
        (("order = 4", "pass"), Seen.NO_ORDER),
        (("order = 4", "order = 3"), Seen.OTHER_ORDER),
        (("1 / 3, 1 / 3", "1 / 2, 1 / 6"), Seen.OTHER),
        (("1 / 3, 1 / 3", "1 / 3, weight()"), Seen.SAID),
        (("    A = [[", "    # [["), Seen.SILENT),
    ],
)
def test_what_differs_has_its_reason(change: tuple[str, str], seen: Seen) -> None:
    special, general = (
        tables(x, LANGUAGES["python"], about=True) for x in (RK4, RK4.replace(*change))
    )
    assert [x for _, x in compared(special, general)] == [seen]


def test_an_order_that_only_the_general_reader_sees_is_more() -> None:
    special, general = (
        tables(x, LANGUAGES["python"], about=True) for x in (RK4.replace("order = 4", "pass"), RK4)
    )
    assert [x for _, x in compared(special, general)] == [Seen.MORE]


def test_what_a_special_reader_does_not_read_is_not_counted() -> None:
    text = RK4.replace("1 / 3, 1 / 3", "1 / 3, weight()")
    assert list(compared(tables(text, LANGUAGES["python"], about=True), [])) == []
