"""Bad input of every kind: one sentence, exit code 2, within two seconds, no traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.lookup import document
from glmref.cli import main

#: Seconds of processor time until the sentence is there; the slowest kind takes about a tenth of it.
LIMIT = 2.0


def _with(shipped: str = "gsymplectic-n", /, **changes: Any) -> bytes:
    """A shipped document with some keys changed; ``None`` takes a key out."""
    doc = {**document(shipped), **changes}
    return json.dumps({key: value for key, value in doc.items() if value is not None}).encode()


def _entry(text: object, **changes: Any) -> bytes:
    """The document of method N with one entry of A changed."""
    A = [list(row) for row in document("gsymplectic-n")["A"]]
    A[0][0] = text
    return _with(A=A, **changes)


def _replaced(old: str, new: str, base: str = "gsymplectic-n") -> bytes:
    text = json.dumps(document(base))
    assert old in text
    return text.replace(old, new, 1).encode()


def _enclosure(base: str, **changes: Any) -> bytes:
    return _with(base, enclosure={**document(base)["enclosure"], **changes})


def _opening(base: str, **changes: Any) -> bytes:
    return _with(base, starting={**document(base)["starting"], **changes})


def _claim(base: str = "gsymplectic-n", **claims: Any) -> bytes:
    named = {key.replace("_", "-"): value for key, value in claims.items()}
    return _with(base, claims={**document(base)["claims"], **named})


def _source(**changes: Any) -> bytes:
    source = {**document("gsymplectic-n")["source"], **changes}
    return _with(source={key: x for key, x in source.items() if x is not None})


def _start(**changes: Any) -> bytes:
    block = {**document("gsymplectic-n")["starting"], **changes}
    return _with(starting={key: x for key, x in block.items() if x is not None})


TOWER = "sqrt(" * 6 + "2" + ")" * 6
SQUARES = {"c0": "9" * 900, **{f"c{k}": f"c{k - 1}*c{k - 1}" for k in range(1, 40)}}
ROOTS = {"c0": "2", **{f"c{k}": f"sqrt(c{k - 1}+1)" for k in range(1, 12)}}

FILES: dict[str, bytes | Callable[[], bytes]] = {
    # not JSON, or not the JSON that is read
    "empty": b"",
    "spaces": b"  \n ",
    "binary": bytes(range(256)),
    "utf-16": json.dumps({"format": "glmref-method-1"}).encode("utf-16"),
    "byte-order-mark": b"\xef\xbb\xbf" + _with(),
    "latin-1": _replaced("Khan", "KhXn").replace(b"KhXn", b"Kh\xe4n"),
    "truncated": _with()[:-20],
    "trailing-comma": _with()[:-1] + b",}",
    "comment": b"// a method\n" + _with(),
    "two-documents": _with() * 2,
    "single-quotes": b"{'format': 'glmref-method-1'}",
    "nul-bytes": _with().replace(b" ", b"\0"),
    "ten-megabytes": lambda: _with(title="x" * 10_000_000),
    "deep-nesting": b"[" * 100_000 + b"]" * 100_000,
    "deep-nesting-unclosed": b"[" * 3_000_000,
    "quotes-without-end": b"[" + b'\\"' * 1_900_000,
    "nan": _entry(float("nan")),
    "infinity": _entry(float("inf")),
    "minus-infinity": _entry(-float("inf")),
    "float": _entry(0.25),
    "float-with-exponent": _replaced('"(3-sqrt(3))/6"', "1e999"),
    "long-float": _replaced('"(3-sqrt(3))/6"', "0." + "3" * 5000),
    "huge-integer": _replaced('"(3-sqrt(3))/6"', "9" * 5000),
    "duplicate-key": _replaced('"title"', '"name"'),
    "duplicate-claim": _replaced('"order": 4', '"order": 4, "order": 5'),
    "list-on-top": b"[1, 2]",
    "string-on-top": b'"gauss-2"',
    "null-on-top": b"null",
    # keys
    "unknown-key": _with(C=["1"]),
    "key-with-escapes": _with(**{"\x1b[31mred\n": "1"}),
    "key-of-another-class": _with(alpha=["1"]),
    "missing-block": _with(V=None),
    "missing-class": _with(**{"class": None}),
    "wrong-class": _with(**{"class": "runge-kutta"}),
    "class-is-a-number": _with(**{"class": 3}),
    "wrong-format": _with(format="glmref-method-99"),
    "missing-name": _with(name=None),
    "name-with-a-path": _with(name="../../etc/passwd"),
    "name-in-capitals": _with(name="Gauss 2"),
    "name-too-long": _with(name="a" * 5000),
    "title-is-a-list": _with(title=["a"]),
    "field-is-wrong": _with(field="quaternion"),
    "enclosure-is-a-list": _with(enclosure=[1]),
    "enclosure-with-an-unknown-key": _enclosure("s5t-w3", equation=[]),
    "enclosure-equation-is-a-number": _enclosure("pair-4-4", equations=[5]),
    "enclosure-equations-are-a-word": _enclosure("s5t-w3", equations="order [o]"),
    **{
        f"enclosure-radius-{base}-{number}": _enclosure(base, radius=radius)
        for base in ("pair-4-4", "s5t-w3")
        for number, radius in enumerate(("x", "nan", "1/0", [1], None, "1e-99999999", "1", "0"))
    },
    "start-of-another-order-than-claimed": _opening("gsymplectic-n-pair", order=9),
    "start-of-another-order-than-claimed-enclosed": _opening("pair-4-4", order=2),
    "start-of-fewer-conditions": _claim("pair-4-4", starting_order=2),
    # shapes
    "ragged-matrix": _with(A=[["0", "0"], ["0"]]),
    "empty-matrix": _with(A=[]),
    "empty-row": _with(A=[[], []]),
    "row-is-a-string": _with(A=["00", "00"]),
    "wrong-shape": _with(U=[["1", "0", "0"], ["1", "0", "0"]]),
    "matrix-1000-by-1000": lambda: _with(A=[["0"] * 1000] * 1000),
    "row-of-1000": lambda: _with(A=[["0"] * 1000] * 3),
    "matrix-201-rows": lambda: _with(A=[["0"] * 200] * 201),
    "g-of-wrong-shape": _with(G=[["1"]]),
    "d-too-long": _with(D=["1/2"] * 3),
    "d-is-null-in-list": _with(D=["1/2", None]),
    "starting-of-wrong-shape": _start(B=[["0"]]),
    "starting-ragged": _start(A=[["0", "0"], ["0"]]),
    "starting-with-unknown-key": _start(c=["0"]),
    "starting-without-u": _start(u=None),
    "starting-of-unknown-kind": _start(kind="richardson"),
    "starting-order-99": _start(order=99),
    "starting-order-true": _start(order=True),
    "starting-is-a-list": _with(starting=[]),
    "finishing-of-wrong-shape": _with(finishing={"A": [["0"]], "b": ["0", "0"]}),
    "starting-of-a-pair": _with("stormer-verlet", starting=document("gsymplectic-n")["starting"]),
    # entries
    "null-entry": _entry(None),
    "number-entry": _entry(1),
    "true-entry": _entry(True),
    "object-entry": _entry({"re": "1"}),
    "empty-entry": _entry(""),
    "blank-entry": _entry(" \t"),
    "huge-exponent": _entry("1e999999"),
    "power": _entry("2**999999999"),
    "caret": _entry("2^1000"),
    "code": _entry("__import__('os').system('true')"),
    "lambda": _entry("(lambda: 1)()"),
    "format-string": _entry("{0.__class__}"),
    "unicode-digits": _entry("１/２"),
    "vulgar-fraction": _entry("½"),
    "unicode-minus": _entry("\u22121"),
    "no-break-space": _entry("1\u00a0/2"),
    "unclosed": _entry("(1/2"),
    "overclosed": _entry("1/2)"),
    "operator-at-end": _entry("1/"),
    "deep-parentheses": _entry("(" * 500 + "1" + ")" * 500),
    "many-signs": _entry("-" * 3000 + "1"),
    "long-entry": _entry("1+" * 4000 + "1"),
    "long-integer": _entry("9" * 1001),
    "division-by-zero": _entry("1/0"),
    "division-by-hidden-zero": _entry("1/(sqrt(2)*sqrt(3)-sqrt(6))"),
    "sqrt-of-a-negative": _entry("sqrt(-2)"),
    "imaginary-unit-in-a-real-tableau": _entry("i"),
    "complex-g-in-a-real-tableau": _with(G=[["1", "0"], ["0", "i"]]),
    "sqrt-tower": _entry(TOWER),
    "sqrt-tower-of-constants": _entry("c11", constants=ROOTS),
    "squares-of-squares": _entry("c39", constants=SQUARES),
    "root-of-a-negative": _entry("root(-2,3)"),
    "root-of-absurd-degree": _entry("root(2,1000000)"),
    "exp-of-a-number": _entry("exp(1)"),
    "exp-of-absurd-denominator": _entry("exp(2*pi*i/1000003)", field="complex"),
    "pi": _entry("pi/4"),
    "unknown-name": _entry("alpha"),
    "decimal": _entry("0.25"),
    "decimal-longer-than-declared": _entry("0.12345678", digits=4),
    "root-of-a-decimal-around-zero": _entry("1/sqrt(0.00)", digits=2),
    "digits-absurd": _entry("0.5", digits=10**9),
    "digits-negative": _entry("0.5", digits=-1),
    "digits-true": _entry("0.5", digits=True),
    "digits-null": _with(digits=[]),
    # constants
    "constant-shadows-i": _with(constants={"i": "1"}),
    "constant-shadows-sqrt": _with(constants={"sqrt": "1"}),
    "constant-with-a-space": _with(constants={"a b": "1"}),
    "constant-of-itself": _with(constants={"c": "c+1"}),
    "constants-of-each-other": _with(constants={"a": "b", "b": "a"}),
    "constant-twice": _with(constants={"c": "1"}, unknowns={"c": "2"}),
    "constants-are-a-list": _with(constants=["1"]),
    "constant-is-a-number": _with(constants={"c": 1}),
    # claims and source
    "claims-missing": _with(claims=None),
    "claims-empty": _with(claims={}),
    "claims-are-a-list": _with(claims=["order"]),
    "unknown-claim": _claim(colour="blue"),
    "order-true": _claim(order=True),
    "order-negative": _claim(order=-1),
    "order-99": _claim(order=99),
    "order-in-quotes": _claim(order="4"),
    "order-null": _replaced('"order": 4', '"order": null'),
    "symmetric-in-quotes": _claim(symmetric="yes"),
    "growth-is-a-string": _claim(growth="0"),
    "growth-of-numbers": _claim(growth=[0]),
    "growth-of-lists": _claim(growth=[["0"]]),
    "growth-endless": _claim(growth=["0"] * 1000),
    "error-constant-is-a-number": _claim("ab-2", error_constant=1),
    "claim-without-meaning": _claim("stormer-verlet", a_stable=True),
    "source-missing": _with(source=None),
    "source-is-a-string": _with(source="Khan 2018"),
    "source-without-place": _source(where=None),
    "citation-empty": _source(citation="  "),
    "status-unknown": _source(status="trust me"),
    "source-with-unknown-key": _source(url="http://example.org"),
    "errata-are-a-string": _source(errata="none"),
    "bibtex-is-a-number": _source(bibtex=1),
    "broken-is-a-string": _with(broken="yes"),
    "broken-names-no-claim": _with(broken={"claim": "l-stable", "why": "it is", "flag": "X"}),
    # classes
    "multistep-of-unequal-lengths": _with("ab-2", beta=["1"]),
    "multistep-without-leading-alpha": _with("ab-2", alpha=["1", "-1", "0"]),
    "multistep-of-one-term": _with("ab-2", alpha=["1"], beta=["1"]),
    "runge-kutta-not-square": _with("rk4", A=[["0", "0"]], b=["1", "0"]),
    "splitting-out-of-turn": _with("stormer-verlet", a=["1"] * 5),
    "splitting-of-x": _with("stormer-verlet", first="x"),
    "composition-of-itself": _with("yoshida-4", base="yoshida-4"),
    "composition-of-nothing": _with("yoshida-4", base="no-such-method"),
    "composition-of-a-path": _with("yoshida-4", base="/etc/passwd"),
    "composition-of-a-pair": _with("yoshida-4", base="stormer-verlet"),
    "pair-half-missing": _with("gsymplectic-n-pair", p={"A": [["0"]]}),
    "pair-half-is-a-list": _with("gsymplectic-n-pair", q=[]),
    "separable-in-quotes": _with("gsymplectic-n-pair", separable="true"),
    "sweep-v-not-orthogonal": _with(
        "s5t-w3", V=[["2" if i == j else "0" for j in range(4)] for i in range(4)]
    ),
    "sweep-without-d": _with("s5t-w3", D=None),
}

ARGUMENTS: dict[str, list[str]] = {
    "unknown-command": ["prove"],
    "unknown-option": ["verify", "--fast"],
    "unknown-name": ["verify", "gaus-2"],
    "unknown-format": ["verify", "--format", "xml"],
    "unknown-only": ["verify", "rk4", "--only", "beauty"],
    "only-what-no-file-claims": ["verify", "rk4", "--only", "growth"],
    "empty-name": ["verify", ""],
    "name-with-line-ends": ["verify", "a\nb\r\nc"],
    "name-with-escapes": ["verify", "\x1b]0;title\x07"],
    "name-far-too-long": ["verify", "a" * 100_000],
    "file-name-too-long": ["verify", "a" * 5000 + ".json"],
    "nonexistent-file": ["verify", "no/such/file.json"],
    "folder": ["verify", "."],
    "device": ["verify", os.devnull],
    "show-nothing": ["show"],
    "show-two-plotted": ["show", "rk4", "euler", "--plot", "both.svg"],
    "decimal-zero": ["show", "rk4", "--decimal", "0"],
    "decimal-absurd": ["show", "rk4", "--decimal", "100000000"],
    "decimal-no-number": ["show", "rk4", "--decimal", "ten"],
    "analyze-unknown": ["analyze", "rk5"],
    "cite-nothing": ["cite"],
    "cite-unknown": ["cite", "rk4", "nobody-1899"],
    "list-unknown-class": ["list", "--class", "magic"],
    "list-with-argument": ["list", "rk4"],
    "errata-unknown": ["errata", "9.9-no-such-thing"],
    "errata-unknown-verdict": ["errata", "--verdict", "sloppy"],
    "errata-of-unknown-method": ["errata", "--method", "nobody-1899"],
}


#: Kinds of files in which only claims, or their proofs, are wrong.
CLAIMED = (
    *("claims-missing", "claims-empty"),  # a bare tableau
    "broken-names-no-claim",
    "enclosure-radius",
    "start-of-another",
    "start-of-fewer",
)


def _spent() -> float:
    """Processor time of this process and those it waited for: other programs change it little."""
    return sum(os.times()[:4])


def _assert_one_sentence(code: int, out: str, err: str) -> None:
    assert code == 2
    assert out == ""
    assert err.startswith("glmref: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert all(x.isprintable() for x in err[:-1])
    assert len(err) < 1000
    assert "Traceback" not in err
    assert "internal" not in err


def test_at_least_45_kinds_of_bad_input_are_tried() -> None:
    assert len(FILES) + len(ARGUMENTS) >= 45


@pytest.mark.sampled(10)
@pytest.mark.parametrize("command", ["verify", "show"])
@pytest.mark.parametrize("kind", FILES)
def test_bad_file_gives_one_sentence_and_exit_2(
    kind: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if command == "show" and kind.startswith(CLAIMED):
        pytest.skip("what is claimed plays no part in show")
    content = FILES[kind]
    file = tmp_path / "method.json"
    file.write_bytes(content if isinstance(content, bytes) else content())
    started = _spent()
    code = main([command, str(file)])
    assert _spent() - started < LIMIT
    out, err = capsys.readouterr()
    _assert_one_sentence(code, out, err)
    assert "method.json: " in err


@pytest.mark.parametrize("kind", ARGUMENTS)
def test_bad_argument_gives_one_sentence_and_exit_2(
    kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    started = _spent()
    code = main(ARGUMENTS[kind])
    assert _spent() - started < LIMIT
    _assert_one_sentence(code, *capsys.readouterr())


@pytest.mark.sampled(1)
@pytest.mark.parametrize("base", ["gsymplectic-n", "stormer-verlet", "yoshida-4", "s5t-w3", "ab-2"])
def test_the_documents_the_bad_ones_are_made_of_are_good(
    base: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "method.json"
    file.write_bytes(_with(base))
    assert main(["verify", str(file)]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read all")
def test_unreadable_file_gives_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "method.json"
    file.write_bytes(_with())
    file.chmod(0)
    _assert_one_sentence(main(["verify", str(file)]), *capsys.readouterr())


def test_link_to_itself_gives_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    link = tmp_path / "method.json"
    link.symlink_to(link)
    _assert_one_sentence(main(["verify", str(link)]), *capsys.readouterr())


def test_file_name_with_a_line_end_stays_on_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a\n\x1b[2Jb.json"
    file.write_text("{}")
    _assert_one_sentence(main(["verify", str(file)]), *capsys.readouterr())


def test_a_bad_file_among_good_ones_costs_only_its_own_result(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "method.json"
    file.write_bytes(FILES["float"])  # type: ignore[arg-type]
    code = main(["verify", "euler", str(file), "no-such-method", "rk4", "--format", "json"])
    out, err = capsys.readouterr()
    assert code == 2
    assert {f["method"] for f in json.loads(out)["findings"]} == {"euler", "rk4"}
    assert [line.partition(":")[0] for line in err.splitlines()] == ["glmref", "glmref"]


@pytest.mark.sampled(0)
@pytest.mark.parametrize("kind", ["deep-nesting", "code", "squares-of-squares"])
def test_the_program_itself_says_it_in_one_sentence_within_two_seconds(
    kind: str, tmp_path: Path
) -> None:
    content = FILES[kind]
    assert isinstance(content, bytes)
    file = tmp_path / "method.json"
    file.write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-m", "glmref", "verify", str(file)],
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    _assert_one_sentence(done.returncode, done.stdout, done.stderr)
