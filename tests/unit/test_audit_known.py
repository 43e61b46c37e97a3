"""Numbers of known methods are found in any layout, and a slip in one of them is named."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.audit.known import known, may_hold_known, records
from glmref.audit.lexer import LANGUAGES
from glmref.audit.sources import audit
from glmref.audit.values import Numeral, spelled
from glmref.catalogue.lookup import document

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
