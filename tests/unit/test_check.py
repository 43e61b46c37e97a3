"""``glmref.check``: any kind of number, any kind of method, and the tree that fails."""

import json
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction as F
from typing import Any

import mpmath
import numpy as np
import pytest

import glmref
from glmref.catalogue.strict_toml import loads
from glmref.cli import main
from glmref.errors import DataError
from glmref.findings import Verdict
from glmref.method import as_matrix
from glmref.prove.schemes import reach, runge_kutta
from tests.build import refused

HEUN = [[0, 0], [1, 0]]


def verdicts(*given: Any, **said: Any) -> list[str]:
    return [str(x.verdict) for x in glmref.check(*given, **said)]


@pytest.mark.parametrize(
    "weights",
    [
        ["1/2", "1/2"],
        ["0.5", "5e-1"],
        [F(1, 2), F(1, 2)],
        [0.5, 0.5],
        np.array([0.5, 0.5]),
        np.array([F(1, 2), F(1, 2)], dtype=object),
        np.array([0.5, 0.5], dtype=np.float32),
        np.array([0.5, 0.5], dtype=np.longdouble),
        [mpmath.mpf(1) / 2, mpmath.mpf("0.5")],
        ["sqrt(1/4)", "1-sqrt(4)/4"],
    ],
)
def test_every_kind_of_number_is_read(weights: Any) -> None:
    assert verdicts(np.array(HEUN), weights, order=2) == ["holds"]
    refused(glmref.CheckFailed, r"tree \[oo\] of order 3", glmref.check, HEUN, weights, order=3)


def test_a_float_is_the_decimal_as_which_it_prints() -> None:
    (found,) = glmref.check([[0, 0], [5, 0]], [0.1, "9/10"], order=1)
    assert found.verdict is Verdict.HOLDS
    (found,) = glmref.check([[0, 0], [2 / 3, 0]], [0.25, 0.75], order=2)
    assert found.verdict is Verdict.OPEN
    assert found.witness.startswith("order 2 to ") and "within the 15 digits" in found.witness
    assert 'where 2/3 is meant, write "2/3" in place of 0.6666666666666666' in found.witness
    with pytest.raises(glmref.CheckFailed, match=r"tree \[o\] of order 2"):
        glmref.check([[0, 0], [0.6666666666, 0]], [0.25, 0.75], order=2)  # ten digits are exact


def test_stated_digits_decide_nothing_within_them() -> None:
    third = 1 / 3
    A = [[0, 0], [2 * third, 0]]
    (found,) = glmref.check(A, [0.25, 0.75], order=2, digits=15)
    assert found.verdict is Verdict.OPEN
    assert "within the 15 digits" in found.witness
    glmref.assert_tableau(A, [0.25, 0.75], order=2, digits=15)
    with pytest.raises(glmref.CheckFailed):
        glmref.check([[0, 0], [0.6667, 0]], [0.25, 0.75], order=2, digits=15)


@pytest.mark.slow
def test_rounded_abscissae_do_not_hide_orders_beyond_eight() -> None:
    """Trees with leaves for t are looked at through order 8; c that is rounded is not another c."""
    gauss = glmref.load("gauss-5")
    assert isinstance(gauss, glmref.GLM)

    def decimals(row: Any) -> list[str]:
        return [x.ball().decimal_text(50) for x in row]

    table = {"A": list(map(decimals, gauss.A)), "b": decimals(gauss.B[0]), "order": 10}
    table["c"] = decimals([sum(row, 0 * row[0]) for row in gauss.A])
    for digits in ({}, {"digits": 48}):
        (found,) = glmref.check(table | digits)
        assert found.verdict is Verdict.OPEN
        within = "within the 48 digits"
        assert "order 10 to" in found.witness and within in found.witness
        assert "the decimals as written have order 1" in found.witness
    table["c"][2] = "0.6"  # another one: what is said of order 8 and below decides
    refused(glmref.CheckFailed, "the order is that on y' = f", glmref.check, table)


def test_embedded_rows_and_error_weights_have_their_orders() -> None:
    m = glmref.load("dormand-prince-5")
    low = glmref.load("dormand-prince-4")
    assert isinstance(m, glmref.GLM) and isinstance(low, glmref.GLM)
    row = low.B[0]
    assert verdicts(m, order=5, embedded=(row, 4)) == ["holds", "holds"]
    error = [x - y for x, y in zip(m.B[0], row, strict=True)]
    assert verdicts(m, order=5, embedded={"error": error, "order": 4}) == ["holds", "holds"]
    with pytest.raises(glmref.CheckFailed, match="order 5 of embedded row 1 fails"):
        glmref.check(m, embedded=(row, 5))
    with pytest.raises(glmref.CheckFailed, match=r"differ in sum by 0\.5"):
        glmref.check(HEUN, ["1/2", "1/2"], embedded={"b": ["1/2", 0]})


def test_abscissae_apart_are_judged_on_time_dependent_systems() -> None:
    """Oliver (1975): c is not A 1, and the order is 2 on y' = f(t, y) all the same."""
    b = ["1/2", "1/2"]
    refused(glmref.CheckFailed, r"f\[t\] of order 2", glmref.check, HEUN, b, [0, "1/2"], order=2)
    # c = (1/4, 3/4) sums with b to 1/2: order 2, though the rows sum to (0, 1)
    (order,) = glmref.check(HEUN, b, ["1/4", "3/4"], order=2)
    assert order.verdict is Verdict.HOLDS
    assert "row 1 of A sums to 0 and c[1] is 0.25" in order.witness


def test_additive_parts_may_hold_and_their_coupling_fail() -> None:
    explicit = {"A": [[0, 0], ["1/2", 0]], "b": [0, 1], "order": 2}
    implicit = {"A": [[0, 0], [0, "1/2"]], "b": [0, 1], "order": 2}
    assert verdicts({"parts": [explicit, implicit]}, order=2) == ["holds"] * 3
    trapezoidal = {"A": [[0, 0], ["1/2", "1/2"]], "b": ["1/2", "1/2"], "order": 2}
    with pytest.raises(glmref.CheckFailed) as failed:
        glmref.check({"parts": [explicit, trapezoidal]}, order=2)
    assert [str(x.verdict) for x in failed.value.findings] == ["holds", "holds", "fails"]
    assert "tree 1[2] of order 2 has residual 0.5" in str(failed.value)


@pytest.mark.slow
def test_nystrom_methods() -> None:
    """Nystrom's method of order 4: Hairer, Norsett, Wanner (1993), table II.14.2."""
    table = {
        "A": [[0, 0, 0], ["1/8", 0, 0], [0, "1/2", 0]],
        "b": ["1/6", "1/3", 0],
        "b_prime": ["1/6", "2/3", "1/6"],
        "c": [0, "1/2", 1],
    }
    assert verdicts(table, order=4) == ["holds", "holds"]
    refused(glmref.CheckFailed, "order 5 of the position fails", glmref.check, table, order=5)
    inner = {"A_prime": [[0, 0, 0], ["1/2", 0, 0], [-1, 2, 0]]}
    with pytest.raises(glmref.CheckFailed, match=r"k\[kk\]|k\[k\[k\]\]|k\["):
        glmref.check(table | {"A_prime": [[0] * 3] * 3}, order=2)
    assert verdicts(table | inner, order=2) == ["holds", "holds"]


def test_embedded_rows_of_nystrom_methods() -> None:
    """Dormand, El-Mikkawy and Prince (1987), RKN4(3)4FM: a row of order 3 for q and for q'."""
    doc = glmref.load("dormand-prince-rkn-4-3").document
    table = {key: doc[key] for key in ("A", "b", "b_prime", "c")}
    row = {key: doc["embedded"][0][key] for key in ("b", "b_prime")}
    found = glmref.check(table, order=4, embedded=row | {"order": 3})
    assert [(x.claim, str(x.verdict), str(x.proof)) for x in found] == [
        ("order of the position", "holds", "exact"),
        ("order of the velocity", "holds", "exact"),
        ("order of the position of embedded row 1", "holds", "exact"),
        ("order of the velocity of embedded row 1", "holds", "exact"),
    ]
    for key, part in (("b", "position"), ("b_prime", "velocity")):
        wrong = row | {key: ["1/3", *row[key][1:]]}
        with pytest.raises(glmref.CheckFailed) as failed:
            glmref.check(table, embedded=wrong | {"order": 3})
        (one,) = [x for x in failed.value.findings if str(x.verdict) == "fails"]
        assert one.claim == f"order of the {part} of embedded row 1"
    with pytest.raises(glmref.CheckFailed, match=r"order 4 of the \w+ of embedded row 1 fails"):
        glmref.check(table, embedded=row | {"order": 4})
    errors = {
        f"error{'_prime' if key == 'b_prime' else ''}": [
            F(x) - F(y) for x, y in zip(table[key], row[key], strict=True)
        ]
        for key in row
    }
    assert [str(x.verdict) for x in glmref.check(table, embedded=errors | {"order": 3})] == [
        "holds", "holds"
    ]  # fmt: skip
    sums = glmref.check(table, embedded=[row])
    assert [x.claim for x in sums] == [
        "error weights of the position of row 1 sum to",
        "error weights of the velocity of row 1 sum to",
    ]
    with pytest.raises(glmref.CheckFailed, match="error weights of the velocity of row 1 sum to"):
        glmref.check(table, embedded=[row | {"b_prime": [1, 1, 1, 1]}])


def test_rosenbrock_methods_and_their_w_order() -> None:
    """ROS2 of Verwer et al. (1999): order 2 for any J and gamma; order 3 fails."""
    ros2 = {"alpha": [[0, 0], [1, 0]], "gamma": [["1/4", 0], ["-1/2", "1/4"]], "b": ["1/2", "1/2"]}
    assert verdicts(ros2, order=2, w_order=2) == ["holds", "holds"]
    wrong = ros2 | {"gamma": [["1/4", 0], ["1/2", "1/4"]]}
    refused(glmref.CheckFailed, r"order 2 fails: tree \[o\]", glmref.check, wrong, order=2)
    # GRK-like: with b gamma 1 = 0 only in the sum with alpha, the exact Jacobian is needed
    exact_only = {"alpha": [[0]], "gamma": [["1/2"]], "b": [1]}
    assert verdicts(exact_only, order=2) == ["holds"]
    with pytest.raises(glmref.CheckFailed, match=r"W-order 2 fails: tree f\[f\]"):
        glmref.check(exact_only, w_order=2)


def test_dense_output_is_a_polynomial_of_the_step() -> None:
    said = {"A": HEUN, "b": ["1/2", "1/2"], "dense": [[1, "-1/2"], [0, "1/2"]]}
    assert verdicts(said, dense_order=2) == ["holds"]
    with pytest.raises(glmref.CheckFailed, match="order 2 of the dense output fails"):
        glmref.check(said | {"dense": [[1, "-1/3"], [0, "1/3"]]}, dense_order=2)


def test_balls_of_a_dense_output_have_the_residuals_of_its_numbers() -> None:
    A, b, dense = (as_matrix(x, "x") for x in (HEUN, [["1/2", "1/2"]], [[1, "-1/3"], [0, "1/3"]]))
    sharp = replace(runge_kutta(A, b[0]), dense=dense)
    balls = sharp.in_balls()
    assert sharp.is_exact and not balls.is_exact
    assert not replace(sharp, dense=balls.dense).is_exact
    exact, found = reach(sharp, 3), reach(balls, 3)
    assert found.sizes == pytest.approx(exact.sizes) and max(exact.sizes) > 0.1
    assert found.refuted == exact.refuted == 2


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ('{"A": [[0,0],[1,0]], "b": ["1/2","1/2"], "order": 2}', 0, "order 2 holds"),
        ("A = [[0, 0], [1, 0]]\nb = [0.5, 0.5]\norder = 2\n", 0, "order 2 holds"),
        ('{"A": [[0,0],[1,0]], "b": ["1/2","1/3"], "order": 2}', 1, "tree o of order 1"),
        ('{"A": [[0,0],[1,0]], "b": [0.333, "0.667"], "digits": 3, "order": 1}', 3, "within the 3"),
        ("{]", 2, "line 1, column 2 is not JSON"),
        ("A = [", 2, "neither a JSON object nor TOML"),
        ('\ufeff{"A": [[0]], "b": [1], "order": 1}', 0, "order 1 holds"),
        ('{"A": [[0]], "b": [1], "b": [2], "order": 1}', 2, "the key 'b' occurs twice"),
        ('[{"A": [[0]], "b": [1], "order": 1}]', 2, "must hold one object with A and b"),
        ("[[0]]", 2, "must hold one object with A and b"),
        ("null", 2, "neither a JSON object nor TOML"),
        (
            "A = [[0]]\nb = [1]\n[[embedded]]\nb = [1]\norder = 2\n",
            1,
            "order 2 of embedded row 1 fails",
        ),
        ('{"A": [[0]], "b": ["1e400"], "order": 1}', 1, "residual above 1e308"),
    ],
)
def test_the_command_reads_a_pipe(text, code, said, monkeypatch, capsys):
    import io

    monkeypatch.setattr("sys.stdin", io.StringIO(text))
    assert main(["check", "-"]) == code
    out = capsys.readouterr()
    assert said in out.out + out.err


def test_a_repeated_key_among_many_is_found_at_once(monkeypatch: Any, capsys: Any) -> None:
    """Its search among 60,000 keys once took half a minute."""
    import io
    import time

    keys = ", ".join(f'"k{i}": 1' for i in range(60_000))
    monkeypatch.setattr("sys.stdin", io.StringIO(f'{{{keys}, "k59999": 1}}'))
    begin = time.process_time()
    assert main(["check", "-"]) == 2
    assert time.process_time() - begin < 5
    assert "the key 'k59999' occurs twice" in capsys.readouterr().err


NINES = "9" * 5000


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        (f'["{NINES}.5", 1]', "5002 characters"),
        (f'["{"9" * 1_000_000}", 1]', "1000000 characters"),
        (f"[0.{NINES}, 1]", "is '1.0' of type Double"),
        ("[1e-99999999, 1]", "is '0.0' of type Double"),
        ("[0e99999999, 1]", "is '0.0' of type Double"),
        ('["\uff10.\uff15", "1/2"]', "'\uff10' is not allowed"),
        (f"[{'0, ' * 300} 1]", "more than 200 entries"),
    ],
)
def test_numbers_and_tables_beyond_any_size_are_refused_at_once(weights, said, tmp_path, cli):
    path = tmp_path / "x.json"
    path.write_text(f'{{"A": [[0, 0], [1, 0]], "b": {weights}, "order": 2, "digits": 20}}', "utf-8")
    assert said in cli("check", path, code=2).err


def test_a_name_is_printed_on_one_line(tmp_path: Any, cli) -> None:
    path = tmp_path / "x.json"
    name = "\x1b[2J\u202e\ud800\nx: order 9 holds" + "y" * 10_000
    path.write_text(json.dumps({"A": [[0]], "b": [1], "order": 1, "name": name}))
    (line,) = cli("check", path).out.splitlines()
    assert line.isprintable() and len(line) <= 2000


def test_a_sentence_quotes_little_of_what_it_refuses() -> None:
    caught = refused(DataError, "", glmref.check, [[0]], [1], order="x" * 1_000_000)
    assert len(caught) <= 1500


@pytest.mark.slow
def test_vectors_may_be_matrices_and_orders_numbers_of_numpy() -> None:
    np, mpmath, sympy = map(pytest.importorskip, ("numpy", "mpmath", "sympy"))
    half = sympy.Rational(1, 2)
    for A, b in (
        (np.array(HEUN), np.array([[0.5, 0.5]])),
        (mpmath.matrix(HEUN), mpmath.matrix([0.5, 0.5])),
        (sympy.Matrix(HEUN), sympy.Matrix([half, half])),
        (sympy.Matrix(HEUN), sympy.Matrix([[half, half]])),
    ):
        row = (np.array([1, 0]), np.int64(1))
        found = glmref.check(A, b, order=np.int64(2), embedded=row)
        assert [str(x.verdict) for x in found] == ["holds", "holds"]
    assert verdicts(np.array(0.5), np.array(1), order=2) == ["holds"]
    refused(DataError, "`b` must have 2 entries", glmref.check, HEUN, [[1], [2], [3]], order=1)


def test_radicals_of_sympy_are_exact() -> None:
    """McLachlan's and Yoshida's cube root, nested roots, and what is no number with radicals."""
    sympy = pytest.importorskip("sympy")
    root, x = sympy.cbrt(2), sympy.Symbol("x")
    w = 1 / (2 - root)
    b = [w, 1 - 2 * w, w]
    assert verdicts([[0] * 3, [w, 0, 0], [w, 1 - 2 * w, 0]], b, order=1) == ["holds"]
    nested = sympy.sqrt(2 + sympy.sqrt(2))
    assert verdicts([[0, 0], [nested, 0]], [1 - half(nested), half(nested)], order=1) == ["holds"]
    square = (1 - sympy.sqrt(2)) ** 2
    assert verdicts([[0, 0], [0, 0]], [square, 1 - sympy.expand(square)], order=1) == ["holds"]
    for bad in (x, sympy.pi, sympy.I, sympy.nan, sympy.CRootOf(x**3 - 3 * x + 1, 0)):
        refused(DataError, "write a number, a fraction", glmref.check, [[0]], [bad], order=1)


def test_numbers_of_any_package_beyond_any_size_are_refused_at_once() -> None:
    sympy = pytest.importorskip("sympy")
    shared, tower = sympy.sqrt(2), sympy.Integer(2)
    for _ in range(50):
        shared = sympy.Add(shared, shared, evaluate=False)  # 2^50 terms
        tower = sympy.sqrt(1 + tower)
    for bad in (
        1 << 10**7, F(1, 1 << 10**6), mpmath.ldexp(1, 10**12), mpmath.ldexp(1, -(10**12)),
        mpmath.mpf((0, 1 << 10**6, 0, 10**6)), Decimal("1E+999999999999999999"),
        Decimal("1E-10000000"), np.longdouble("inf"), np.longdouble("nan"),
        sympy.Integer(10) ** 100_000, sympy.Float((0, 1, 10**12, 1)), shared, tower,
        sympy.Mul(*[sympy.sqrt(2)] * 5000, evaluate=False),
    ):  # fmt: skip
        refused(DataError, "write a number, a fraction", glmref.check, [[0]], [bad], order=1)
    refused(DataError, "too many digits", glmref.from_rk, [[0]], [1 << 10**7])
    with pytest.raises(DataError, match="`name` must be a text, got a whole number with thousands"):
        glmref.check([[0]], [1], order=1, name=1 << 10**6)


def test_binary_numbers_with_digits() -> None:
    third = np.longdouble(1) / 3
    for x, y in ((third, 1 - third), (mpmath.mpf(1) / 3, mpmath.mpf(2) / 3)):
        assert verdicts([[0, 0], [1, 0]], [x, y], order=1, digits=12) == ["open"]


def half(x: Any) -> Any:
    """1 / (2 x)."""
    return 1 / (2 * x)


def test_an_embedded_row_without_an_order_is_a_difference_of_any_kind() -> None:
    part = {"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"]}
    rosenbrock = {"alpha": HEUN, "gamma": [["1/2", 0], [0, "1/2"]], "b": ["1/2", "1/2"]}
    for said in ({"parts": [part, part]}, rosenbrock):
        assert verdicts(said, order=1, embedded={"b": [1, 0]}) == ["holds", "holds"]
        with pytest.raises(glmref.CheckFailed, match="error weights of row 1 sum to 0 fails"):
            glmref.check(said, order=1, embedded={"b": [1, 1]})


def test_a_key_of_thousands_of_parts_is_refused_at_once(tmp_path: Any, cli) -> None:
    """Python's parser of TOML takes the third power of their number."""
    for key in ("a." * 20_000, '"a" . ' * 20_000, "x = { b = 1, " + "a." * 20_000):
        path = tmp_path / "x.toml"
        path.write_text(f"{key}a = 1\n")
        for command in ("check", "run", "compare", "derive"):
            assert "a key has more than 100 parts" in cli(command, path, code=2).err
    assert loads(f'H = "{"0.5*q*q + " * 300}0.5"')
