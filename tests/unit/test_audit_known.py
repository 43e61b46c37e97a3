"""Numbers of known methods are found in any layout, and a slip in one of them is named."""

from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.audit import known as known_module
from glmref.audit.known import known, may_hold_known, records
from glmref.audit.lexer import LANGUAGES
from glmref.audit.sources import audit
from glmref.audit.values import Numeral, spelled
from glmref.catalogue.lookup import document, load

#: Methods of fractions, and how a fraction is written in each language.
METHODS = ("cash-karp-5-4", "dormand-prince-5-4", "fehlberg-5-4", "prince-dormand-6-5")
FORMS = {
    "c": "y += {p}.0 * h / {q}.0 * k;\n",
    "fortran": "      y = y + {p}._dp/{q}._dp*k\n",
    "python": "    t = [0, sp.Rational({p}, {q})]\n",
    "julia": "    y = y + {p} // {q} * k\n",
    "rust": "    F::from({p}.0) / F::from({q}.0),\n",
}


def numbers(name: str) -> list[Fraction]:
    """Return the entries of A and b that are not 0, with their signs."""
    given = document(name)
    return [Fraction(x) for row in (*given["A"], given["b"]) for x in row if x != "0"]


def written(values: list[Fraction], language: str, decimals: bool) -> str:
    """Return a source that holds the numbers in statements of no table."""
    if decimals:
        return "".join(f"    z({float(x):.16f})\n" for x in values)
    signed = [(("-" if x < 0 else "+"), abs(x)) for x in values]
    form = FORMS[language]
    return "".join(
        (form.replace("+ ", f"{s} ", 1) if language in ("fortran", "julia") else
         form.replace("{p}", f"{s.strip('+')}{{p}}", 1)).format(p=x.numerator, q=x.denominator)
        for s, x in signed
    )  # fmt: skip


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(METHODS), st.sampled_from(sorted(FORMS)), st.booleans(), st.randoms())
def test_the_numbers_of_a_method_are_found_in_any_order(
    name: str, language: str, decimals: bool, random: Random
) -> None:
    values = numbers(name)
    random.shuffle(values)
    text = written(values, language, decimals)
    assert may_hold_known(text)
    found = known(text, LANGUAGES[language])
    family = name.partition("-")[0]
    assert found[0].method.startswith(family) and not any(x.slips for x in found)
    (record, *_) = records(text, LANGUAGES[language], [])
    assert record["status"] == "unread" and "in a form that is not read" in record["remarks"][0]


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(METHODS), st.sampled_from(sorted(FORMS)), st.data())
def test_two_digits_exchanged_are_named_with_line_and_number(
    name: str, language: str, data: st.DataObject
) -> None:
    values = numbers(name)
    lines = written(values, language, False).splitlines(keepends=True)
    often = [abs(x) for x in values]
    places = [
        (i, k)
        for i, x in enumerate(values)
        for k, (a, b) in enumerate(pairwise(str(x.denominator)))
        if often.count(abs(x)) == 1 and x.denominator > 1000 and a != b and b != "0"
    ]
    i, k = data.draw(st.sampled_from(places))
    q = str(values[i].denominator)
    wrong = q[:k] + q[k + 1] + q[k] + q[k + 2 :]
    lines[i] = lines[i].replace(q, wrong)
    found = records("".join(lines), LANGUAGES[language], [])
    said = [x for record in found for x in record.get("correction", ())]
    assert [(x["line"], x["should be"].replace(".0", "").replace(".", "").replace("_dp", ""))
            for x in said] == [(i + 1, f"{abs(values[i].numerator)}/{q}")]  # fmt: skip


def listed(values: list[Fraction]) -> str:
    """Return the numbers as a list."""
    return "a = {" + ", ".join(f"{x.numerator}.0/{x.denominator}.0" for x in values) + "};\n"


def test_a_sign_that_no_other_number_of_a_list_has_is_named() -> None:
    values = numbers("fehlberg-5-4")
    k = values.index(Fraction(-845, 4104))
    values[k] = -values[k]
    (record,) = records(listed(values), LANGUAGES["c"], [])
    (said,) = record["correction"]
    assert (said["is"], said["should be"]) == ("845.0/4104.0", "-845.0/4104.0")


@pytest.mark.parametrize(
    "term",
    [
        pytest.param("+ 3680.0/513.0*k3 -\n 845.0/4104.0*k4", id="line"),
        pytest.param("- k4*845.0/4104.0", id="factor"),
        pytest.param("- (double)845/4104*k4", id="cast"),
        pytest.param("- h*(845.0/4104.0*k4)", id="brackets"),
        pytest.param("; a54 = 845.0/4104.0; y = - a54*k4", id="name"),
        pytest.param("; w = {1.0/3, 845.0/4104.0, 45.0/108}", id="other list"),
    ],
)
def test_a_sign_outside_of_its_list_is_not_asked_about(term: str) -> None:
    values = numbers("fehlberg-5-4")
    others = [x for x in values if x != Fraction(-845, 4104)]
    for text in (written(others, "c", False), listed(others), listed(values)):
        found = records(f"{text}y = z {term};\n", LANGUAGES["c"], [])
        assert not any("correction" in x for x in found)


@pytest.mark.parametrize(
    ("number", "wrong"),
    [
        pytest.param("575, 13824", "575, 13842", id="digits"),
        pytest.param(" 253.0/4096", " -253.0/4096", id="sign"),
    ],
)
def test_one_of_two_copies_is_named(number: str, wrong: str) -> None:
    values = numbers("cash-karp-5-4")
    copy = written(values, "python", False) if "," in number else listed(values)
    text = copy + copy.replace(number, wrong)
    (record,) = records(text, LANGUAGES["python"], [])
    (said,) = record["correction"]
    assert said["line"] == text[: text.index(wrong)].count("\n") + 1
    assert said["should be"].replace(".0", "") == number.strip().replace(", ", "/").replace(
        ".0", ""
    )
    assert "correction" not in next(records(copy + copy, LANGUAGES["python"], []))


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("x = [3, 40, 9, 40, 439, 216, 3680, 513, 845, 4104]\n", id="list of counts"),
        pytest.param("".join(f"d({k / 7919:.12f})\n" for k in range(500)), id="other decimals"),
        pytest.param("a = 439/216 + 3680/513 - 845/4104\n", id="three numbers of a method"),
        pytest.param("# " + written(numbers("fehlberg-5-4"), "python", False).replace("\n", " "),
                     id="a comment"),
    ],
)  # fmt: skip
def test_what_is_no_known_method_is_passed(text: str) -> None:
    assert list(records(text, LANGUAGES["python"], [])) == []


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 10**8 - 1), min_size=50, max_size=400))
def test_decimals_at_random_are_no_method(values: list[int]) -> None:
    text = "".join(f"y({x / 10**8:.8f})\n" for x in values)
    assert known(text, LANGUAGES["python"]) == []


@pytest.mark.parametrize("end", ["f(5, 7", "f(5,", "1.7976931348623158e308", "12345678e999", "5/"])
def test_odd_ends_of_a_source_are_passed(end: str) -> None:
    assert known(written(numbers("cash-karp-5-4"), "c", False) + end, LANGUAGES["c"])


def test_comments_of_fixed_form_are_not_read(tmp_path: Path) -> None:
    text = written(numbers("cash-karp-5-4"), "fortran", False).replace("_dp", "D0")
    lines = [x for x in text.splitlines() if "575" not in x]
    path = tmp_path / "step.f"
    path.write_text("\n".join([*lines, "C     Y + 557.D0/13824.D0 is a misprint", ""]))
    assert "question" not in {x["status"] for x in audit(tmp_path)}


def test_digits_that_are_rounded_are_no_slip() -> None:
    text = "".join(f"y({float(x):.9f})\n" for x in numbers("cash-karp-5-4"))
    assert all(not x.slips for x in known(text, LANGUAGES["python"]))


def test_numbers_that_were_computed_from_rounded_ones_are_those_of_the_method() -> None:
    # printed to 16 digits, of which the last two are those of the roundings of alpha and gamma
    rows = [x.value for x in known_module._constants()["rodas4p, transformed"] if not x.part]
    text = "".join(f"v({float(x) * (1 + 3e-15):.15e});\n" for x in rows)
    assert [x.method for x in known(text, LANGUAGES["c"])] == ["rodas4p, transformed"]
    text = "".join(f"v({float(x) * (1 + 3e-12):.15e});\n" for x in rows)
    assert known(text, LANGUAGES["c"]) == []


def test_the_audit_asks_about_a_step_whose_layout_it_does_not_read(tmp_path: Path) -> None:
    text = written(numbers("cash-karp-5-4"), "c", False).replace("575.0 ", "557.0 ")
    (tmp_path / "step.cs").write_text(text, encoding="utf-8")
    (tmp_path / "right.c").write_text(written(numbers("cash-karp-5-4"), "c", False))
    rows = {x["path"]: x for x in audit(tmp_path)}
    assert rows["step.cs"]["status"] == "question"
    assert rows["step.cs"]["correction"][0]["should be"] == "575.0/13824.0"
    assert rows["right.c"]["status"] == "unread"
    assert "step.cs" not in {x["path"] for x in audit(tmp_path, compare=False)}


#: Ways to write a decimal: digits after the point, marks between them, power of ten.
WAYS = {
    "c": (30, "", ""),
    "rust": (30, "_", "_f64"),
    "fortran": (31, "", "d-1"),
    "python": (20, "", "e0"),
}


def decimal(x: Fraction, way: str) -> str:
    """Return a number cut to the digits of a way, in its form."""
    places, mark, end = WAYS[way]
    scaled = round(abs(x) * 10**places * (10 if end == "d-1" else 1))
    digits = str(scaled).rjust(places + 1, "0")
    after = digits[-places:]
    parts = [after[k : k + 3] for k in range(0, places, 3)] if mark else [after]
    return f"{digits[:-places]}.{mark.join(parts)}{end}"


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(METHODS), st.sampled_from(sorted(WAYS)), st.data())
def test_a_correction_has_all_digits_of_the_number_in_the_form_of_the_source(
    name: str, way: str, data: st.DataObject
) -> None:
    values = numbers(name)
    often = [abs(x) for x in values]
    places = [k for k, x in enumerate(values) if often.count(abs(x)) == 1 and x.denominator > 1000]
    k = data.draw(st.sampled_from(places))
    right = decimal(values[k], way)
    at = right.index(".") + data.draw(st.integers(3, 7))
    if not right[at].isdigit():
        at += 1
    changed = data.draw(st.sampled_from([x for x in "123456789" if x != right[at]]))
    lines = [f"z({decimal(x, way)})\n" for x in values]
    wrong = right[:at] + changed + right[at + 1 :]
    lines[k] = lines[k].replace(right, wrong)
    found = records("".join(lines), LANGUAGES[way], [])
    said = [x for record in found for x in record.get("correction", ())]
    assert [(x["line"], x["is"], x["should be"]) for x in said] == [
        (k + 1, *(x.removesuffix("_f64") for x in (wrong, right)))
    ]


@given(st.decimals(0, 1000, places=20), st.integers(0, 20), st.integers(-9, 9))
def test_a_number_is_spelled_in_the_way_of_a_numeral(x: Decimal, places: int, power: int) -> None:
    way = f"1.{'1' * places}e{power}"
    value = Fraction(x)
    said = Numeral.of(spelled(way, value))
    assert said is not None and len(said.after) == places and said.power == power
    assert abs(said.value - value) <= said.unit / 2


#: A stage of a low-storage step in a branch, by language.
BRANCHES = {
    "c": "  case {k}: A = {A}; B = {B}; break;\n",
    "fortran": "      if (k == {k}) then\n        A = {A}\n        B = {B}\n      end if\n",
    "python": "    elif k == {k}:\n        A, B = {A}, {B}\n",
    "julia": "    k == {k} && (A = {A}; B = {B})\n",
    "rust": "    {k} => ({A}, {B}),\n",
}


def two_registers(name: str) -> tuple[list[Fraction], list[Fraction]]:
    """Return A_2, .., A_s and B_1, .., B_s of D = A_k D + h f(y), y = y + B_k D, from the tableau."""
    component = load(name).components[0]
    rows = [[x.as_fraction() for x in row] for row in (*component.A, component.B[0])]
    B = [rows[j + 1][j] for j in range(len(component.A))]
    A = [(rows[j + 1][j - 1] - B[j - 1]) / B[j] for j in range(1, len(B))]
    return A, B


def in_branches(A: list[Fraction], B: list[Fraction], language: str) -> list[str]:
    """Return the branches of a low-storage step, each with its numbers."""
    said = [
        f"{x.numerator}.0/{x.denominator}.0" if language != "julia"
        else f"{x.numerator}//{x.denominator}" for x in (*A, *B)
    ]  # fmt: skip
    pairs = zip(["0.0", *said[: len(A)]], said[len(A) :], strict=True)
    return [BRANCHES[language].format(k=k, A=a, B=b) for k, (a, b) in enumerate(pairs)]


STORED = ("williamson-3", "carpenter-kennedy-4-printed")


@pytest.mark.parametrize("name", STORED)
def test_the_numbers_of_two_registers_are_those_of_the_tableau(name: str) -> None:
    A, B = two_registers(name)
    given = document(name)["constants"]
    assert [Fraction(given[f"A{k}"]) for k in range(2, len(B) + 1)] == A
    assert [Fraction(given[f"B{k}"]) for k in range(1, len(B) + 1)] == B


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(STORED), st.sampled_from(sorted(BRANCHES)), st.data())
def test_a_low_storage_step_in_branches_is_known_and_a_slip_in_it_is_asked_about(
    name: str, language: str, data: st.DataObject
) -> None:
    comment = {"fortran": "! ", "python": "# ", "julia": "# "}.get(language, "// ")
    rows = in_branches(*two_registers(name), language)
    right = f"{comment}low-storage Runge-Kutta\n" + "".join(rows)
    assert may_hold_known(right)
    (record,) = records(right, LANGUAGES[language], [])
    assert record["status"] == "unread" and name in record["remarks"][0]
    values = [x for part in two_registers(name) for x in part]
    x = data.draw(st.sampled_from([x for x in values if len(str(x.denominator)) > 2]))
    digits = str(x.denominator)
    k = data.draw(st.sampled_from([k for k, (a, b) in enumerate(pairwise(digits)) if a != b]))
    turned = digits[:k] + digits[k + 1] + digits[k] + digits[k + 2 :]
    if turned[0] == "0":
        return
    (record,) = records(right.replace(digits, turned), LANGUAGES[language], [])
    (said,) = record["correction"]
    assert record["status"] == "question"
    assert said["should be"].replace(".0", "") == f"{abs(x.numerator)}/{digits}"
    assert said["line"] == right[: right.index(digits)].count("\n") + 1


@pytest.mark.parametrize("language", ["c", "fortran"])
def test_the_one_number_assigned_with_another_sign_is_asked_about(language: str) -> None:
    right = "".join(in_branches(*two_registers("carpenter-kennedy-4-printed"), language))
    (record,) = records(right.replace("= -3550", "= 3550"), LANGUAGES[language], [])
    (said,) = record["correction"]
    assert said["should be"] == "-3550918686646.0/2091501179385.0"
    all_turned = right.replace("= -", "= ")
    assert "correction" not in next(records(all_turned, LANGUAGES[language], []))


def test_the_form_of_shu_and_osher_is_known() -> None:
    given = document("ssp-5-4-printed")["constants"]
    digits = [x.removesuffix("*u") for x in given.values() if x.endswith("*u")]
    text = "".join(f"    z(0.{x.rjust(15, '0')})\n" for x in digits)
    (record,) = records(text, LANGUAGES["python"], [])
    assert "ssp-5-4-printed, in the form of its source" in record["remarks"][0]
    (record,) = records(text.replace("251891774271694", "251981774271694"), LANGUAGES["python"], [])
    assert [x["should be"] for x in record["correction"]] == ["0.251891774271694"]


@pytest.mark.parametrize("word", ["Runge-Kutta", "geodesy"])
def test_short_fractions_say_of_which_method_they_are_together_and_in_the_subject(
    word: str,
) -> None:
    rows = in_branches(*two_registers("williamson-3"), "c")
    text = f"// {word}\n" + "".join(rows)
    assert may_hold_known(text) == bool(found := list(records(text, LANGUAGES["c"], [])))
    assert bool(found) == (word == "Runge-Kutta")
    apart = f"// {word}\n" + ("\n" * 40).join(rows)
    assert not list(records(apart, LANGUAGES["c"], []))


def test_a_low_storage_table_that_is_read_is_not_said_to_be_unread(tmp_path: Path) -> None:
    A, B = two_registers("carpenter-kennedy-4-printed")
    lists = [", ".join(f"{x.numerator}.0/{x.denominator}.0" for x in y) for y in ([0, *A], B)]
    text = "static const double {}[5] = {{{}}};\n"
    (tmp_path / "low_storage.c").write_text(
        "// low-storage Runge-Kutta\n"
        + text.format("rk4a", lists[0])
        + text.format("rk4b", lists[1])
    )
    assert [x["status"] for x in audit(tmp_path)] == ["found"]


@pytest.mark.parametrize(
    ("old", "new"),
    [("-0.0662645826698185", "-0.662645826698185"), ("-0.0662645826698185", "-0.0662654826698185")],
)
def test_a_slip_in_one_of_few_numbers_of_a_splitting_is_named(
    tmp_path: Path, old: str, new: str
) -> None:
    """Two numbers of 15 digits say which splitting it is; the others are computed from them."""
    source = (
        "! symplectic scheme\n  double precision, parameter :: xi = 0.178617895844809d0\n"
        "  double precision, parameter :: lam = -0.212341831062605d0\n"
        "  double precision, parameter :: chi = -0.0662645826698185d0\n"
    )
    for name, text, states in (("right", source, ["unread"]),
                               ("wrong", source.replace(old, new), ["question"])):  # fmt: skip
        (tmp_path / name).mkdir()
        (tmp_path / name / "c.f90").write_text(text, "utf-8")
        found = list(audit(tmp_path / name))
        assert [x["status"] for x in found] == states, found
    (slip,) = found[0]["correction"]
    assert slip["line"] == 4 and slip["should be"].startswith(old.strip("-")[:16])
