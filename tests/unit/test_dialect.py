"""One dialect: a tableau in every way it is written, through every command, with one verdict."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import glmref
from glmref.catalogue.keys import BLOCKS, FORMATS, SECOND, completed, of_second
from glmref.catalogue.lookup import document, names
from glmref.cli import main

HEUN_A, HEUN_B = [[0, 0], [1, 0]], ["1/2", "1/2"]
SOURCE = {"citation": "Heun (1900)", "where": "p. 1", "status": "derived"}
#: Heun's method with Euler's as embedded row, of orders 2 and 1.
DIALECTS: dict[str, dict[str, Any]] = {
    "numbers": {"A": HEUN_A, "b": [0.5, 0.5], "order": 2},
    "texts": {"A": [["0", "0"], ["1", "0"]], "b": HEUN_B, "order": 2},
    "decimals in texts": {"A": [["0.0", "0"], ["1.0", "0"]], "b": ["0.5", "5e-1"], "order": 2},
    "claims": {"A": HEUN_A, "b": HEUN_B, "claims": {"order": 2}},
    "claims and top": {"A": HEUN_A, "b": HEUN_B, "claims": {"order": 2}, "order": 2},
    "c": {"A": HEUN_A, "b": HEUN_B, "c": [0, 1.0], "order": 2},
    "at least": {"A": HEUN_A, "b": HEUN_B, "order": 1},
    "row": {"A": HEUN_A, "b": HEUN_B, "order": 2, "embedded": [1, 0]},
    "row with order": {"A": HEUN_A, "b": HEUN_B, "order": 2, "embedded": [[1, 0], 1]},
    "object": {"A": HEUN_A, "b": HEUN_B, "order": 2, "embedded": {"b": ["1", "0"], "order": 1}},
    "named": {
        "A": HEUN_A, "b": HEUN_B, "order": 2,
        "embedded": [{"name": "euler", "b": [1, 0]}], "claims": {"embedded-order": {"euler": 1}},
    },
    "estimate": {
        "A": HEUN_A, "b": HEUN_B, "order": 2,
        "embedded": [{"error": ["-1/2", "1/2"], "order": 1}],
    },
    "class": {"class": "rk", "name": "Heun (2)", "A": HEUN_A, "b": HEUN_B, "order": 2},
    "source": {"A": HEUN_A, "b": HEUN_B, "source": SOURCE, "claims": {"order": 2}},
    "general linear": {"A": HEUN_A, "U": [[1], [1]], "B": [HEUN_B], "V": [[1]], "order": 2},
    "format": {
        "format": "glmref-method-1", "name": "mine", "class": "rk", "A": [["0", "0"], ["1", "0"]],
        "b": HEUN_B, "claims": {"order": 2}, "source": SOURCE,
    },
}  # fmt: skip


def write(folder: Path, content: Any, name: str = "mine.json") -> str:
    path = folder / name
    path.write_text(json.dumps(content), encoding="utf-8")
    return str(path)


def verdicts(capsys: Any, command: str, file: str) -> tuple[int, list[str]]:
    capsys.readouterr()
    code = main([command, file, "--format", "json"])
    return code, [x["verdict"] for x in json.loads(capsys.readouterr().out)["findings"]]


@pytest.mark.sampled(1, whole=6)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_command_takes_every_dialect(dialect: str, tmp_path: Path, capsys: Any, cli) -> None:
    file = write(tmp_path, DIALECTS[dialect])
    for command in ("check", "verify"):
        code, found = verdicts(capsys, command, file)
        assert code == 0 and set(found) == {"holds"}
    record = json.loads(cli("analyze", file, "--format", "json").out)
    assert (record["order"], record["order_proved"]) == (2, [2, 2])
    assert main(["show", file, "--plot", str(tmp_path / "x.svg")]) == 0
    for target in ("C", "cpp", "json"):
        assert main(["export", file, "--to", target]) == 0
    assert main(["certify", file]) == 0
    assert glmref.load(file).is_exact
    if "format" not in DIALECTS[dialect]:
        assert {str(x.verdict) for x in glmref.check(DIALECTS[dialect])} == {"holds"}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("dialect", [x for x in DIALECTS if x != "at least"])
def test_every_command_refutes_every_dialect(dialect: str, tmp_path: Path, capsys: Any) -> None:
    """The same with an order too high on top or under ``claims``."""
    content = dict(DIALECTS[dialect])
    content |= {"order": 3} if "order" in content else {}
    if "order" in content.get("claims", {}):
        content["claims"] = {"order": 3}
    file = write(tmp_path, content)
    found = [verdicts(capsys, command, file) for command in ("check", "verify")]
    assert found[0] == found[1] and found[0][0] == 1 and "fails" in found[0][1]


def test_toml_is_read_by_every_command(tmp_path: Path, capsys: Any) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("A = [[0, 0], [1, 0]]\nb = [0.5, 0.5]\norder = 2\n")
    for command in ("check", "verify", "analyze", "show"):
        assert main([command, str(path)]) == 0
    assert glmref.load(path).name == "mine"


KINDS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    #: A true statement, and what makes it false.
    "additive": (
        {"parts": [{"A": HEUN_A, "b": HEUN_B, "order": 2}, {"A": HEUN_A, "b": HEUN_B}], "order": 2},
        {"order": 3},
    ),
    "nystrom": (
        {"A": [[0, 0, 0], [0.125, 0, 0], [0, 0.5, 0]], "b": ["1/6", "1/3", 0],
         "b_prime": ["1/6", "2/3", "1/6"], "c": [0, 0.5, 1], "order": 4},
        {"order": 5},
    ),
    "rosenbrock": (
        {"alpha": [[0, 0], [1, 0]], "gamma": [[0.25, 0], [-0.5, 0.25]], "b": [0.5, 0.5],
         "order": 2, "w_order": 2},
        {"w_order": 3},
    ),
    "lmm": ({"alpha": [0, -1, 1], "beta": [-0.5, 1.5, 0], "order": 2}, {"order": 3}),
    "splitting": ({"a": [0.5, 0.5], "b": [1], "order": 2}, {"order": 3}),
    "partitioned-rk": (
        {"A": [[0, 0], [0.5, 0.5]], "b": [0.5, 0.5], "A_hat": [[0.5, 0], [0.5, 0]],
         "b_hat": [0.5, 0.5], "order": 2},
        {"order": 3},
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_method_is_checked_and_analysed(kind, tmp_path, capsys):
    right, change = KINDS[kind]
    for content, code in ((right, 0), (right | change, 1)):
        file = write(tmp_path, content)
        assert verdicts(capsys, "check", file) == verdicts(capsys, "verify", file)
        assert verdicts(capsys, "check", file)[0] == code
    file = write(tmp_path, right)
    method = glmref.load(file)
    assert method.document is not None and method.document["class"] == kind
    assert main(["analyze", file]) in (0, 3)
    assert main(["show", file]) == 0


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", names())
def test_a_shipped_method_without_its_format_is_the_same_method(name: str, tmp_path: Path) -> None:
    whole = document(name)
    keys = BLOCKS[whole["class"]] | {"constants", "digits", "field", "unknowns", "enclosure"}
    bare = {k: x for k, x in whole.items() if k in keys}
    if set(bare) == {"alpha", "beta"}:  # a multistep method, or its one-leg twin
        bare["class"] = whole["class"]
    plain = glmref.load(write(tmp_path, bare, "My Method (2).json"))
    assert plain.document is not None and plain.document["class"] == whole["class"]
    assert plain.name == "my-method-2-" and not plain.claims and not plain.source
    method = glmref.load(name)
    for x, y in zip(plain.components, method.components, strict=True):
        for letter in "AUBV":
            gaps = np.array(getattr(x, letter), dtype=object) - np.array(
                getattr(y, letter), dtype=object
            )
            assert all(z.is_zero() is not False for z in gaps.flat)


RKF45 = {
    "A": [[0] * 6, ["1/4", 0, 0, 0, 0, 0], ["3/32", "9/32", 0, 0, 0, 0],
          ["1932/2197", "-7200/2197", "7296/2197", 0, 0, 0],
          ["439/216", -8, "3680/513", "-845/4104", 0, 0],
          ["-8/27", 2, "-3544/2565", "1895/4104", "-11/40", 0]],
    "b": ["16/135", 0, "6656/12825", "28561/56430", "-9/50", "2/55"],
    "c": [0, "1/4", "3/8", "12/13", 1, "1/2"], "order": 5,
    "embedded": {"b": ["25/216", 0, "1408/2565", "2197/4104", "-1/5", 0], "order": 4},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.sampled(4)
@pytest.mark.parametrize("command", ["check", "verify", "analyze"])
@pytest.mark.parametrize("form", ["plain", "doubles", "format"])
def test_the_wrong_entry_and_its_correction_are_named_everywhere(command, form, tmp_path, capsys):
    """Fehlberg's pair with 1895 in place of 1859."""
    content = dict(RKF45)
    if form == "doubles":
        content |= {"A": [[eval(str(x)) for x in row] for row in RKF45["A"]]}
        content |= {"b": [eval(str(x)) for x in RKF45["b"]]}
    if form == "format":
        texts = {k: json.loads(json.dumps(RKF45[k]), parse_int=str) for k in ("A", "b", "c")}
        content = texts | {"format": "glmref-method-2", "name": "mine", "class": "rk",
                           "claims": {"order": 5}, "source": SOURCE}  # fmt: skip
    code = main([command, write(tmp_path, content)])
    out = " ".join(capsys.readouterr().out.split())
    assert code in ((0, 3) if command == "analyze" else (1,))
    assert "a[6][4] is 1895/4104 and should be 1859/4104" in out
    assert "row 6 of A sums to 0.508771929825 and c[6] is 0.5" in out


YOSHIDA = {
    "a": [0.6756035959798289, -0.1756035959798288, -0.1756035959798288, 0.6756035959798289],
    "b": [1.3512071919596578, -1.7024143839193155, 1.3512071919596578], "order": 4,
}  # fmt: skip


@pytest.mark.slow
def test_a_method_in_doubles_has_order_4_to_16_digits_first(tmp_path: Path, capsys: Any) -> None:
    file = write(tmp_path, YOSHIDA)
    for command in ("check", "verify"):
        code, found = verdicts(capsys, command, file)
        assert (code, found) == (3, ["open"])
    main(["check", file])
    out = capsys.readouterr().out
    assert out.startswith("order 4 is not decided: order 4 to ")
    assert "no condition fails within the 15 digits" in out
    main(["analyze", file])
    assert "\norder                                      4 to 2.0e-16, " in capsys.readouterr().out
    wrong = YOSHIDA | {"b": [1.3512071919596578, -1.7024143839193, 1.3512071919596578]}
    assert verdicts(capsys, "check", write(tmp_path, wrong))[0] == 3  # 13 digits allow it
    wrong["b"] = [1.3512071919596578, -1.7024143839, 1.3512071919596578]
    assert verdicts(capsys, "check", write(tmp_path, wrong)) == (1, ["fails"])


@pytest.mark.parametrize(
    ("claim", "sentence"),
    [
        ({"symplectic": False}, "symplectic no fails: found yes"),
        ({"stage-order": 3}, "stage-order 3 fails: found 1"),
        (
            {"hamiltonian-to-order": 7},
            "hamiltonian-to-order 7 fails: found 8; no tree of order 8 or less fails",
        ),
        ({"energy-order": 1}, "energy-order 1 fails: found 2; order 3 fails at [oo]"),
        ({"energy-order": 4}, "energy-order 4 fails: order 3 fails at [oo]"),
    ],
)
def test_a_claim_that_fails_says_what_was_found(claim, sentence, tmp_path, cli):
    file = write(tmp_path, {"A": [["1/2"]], "b": ["1"], "claims": claim})
    assert cli("check", file, code=1).out == sentence + "\n"


def test_parts_at_other_times_than_their_row_sums_are_checked_only(tmp_path, capsys, cli):
    part = {"A": HEUN_A, "b": HEUN_B, "c": ["1/4", "3/4"]}
    file = write(tmp_path, {"parts": [part, part], "order": 1})
    assert verdicts(capsys, "check", file) == verdicts(capsys, "verify", file) == (0, ["holds"])
    assert "`parts[1].c` is not A 1" in cli("analyze", file, code=2).err


def test_a_splitting_that_does_not_say_what_is_first_is_asked_for_it(tmp_path: Path, cli) -> None:
    file = write(tmp_path, {"a": ["1/2", "1/2"], "b": [1, 0], "order": 2})
    for command in ("check", "verify", "analyze", "show"):
        assert '"first": "q"' in cli(command, file, code=2).err
    assert main(["check", write(tmp_path, {"a": ["1/2", "1/2"], "b": [1], "order": 2})]) == 0
    both = {"a": ["1/2", "1/2"], "b": [1, 0], "order": 2, "first": "q"}
    assert main(["check", write(tmp_path, both)]) == 0


@pytest.mark.slow
def test_rounded_tables_are_consistent_within_their_digits(tmp_path: Path, capsys: Any) -> None:
    """The splitting of order 4 by Forest and Ruth, in doubles."""
    w = 1.3512071919596578
    ruth = {"a": [w / 2, (1 - w) / 2, (1 - w) / 2, w / 2], "b": [w, 1 - 2 * w, w]}
    assert main(["analyze", write(tmp_path, ruth)]) == 0
    lines = [x.split(maxsplit=1) for x in capsys.readouterr().out.splitlines()[1:]]
    said = {x[0]: x[1] for x in reversed(lines) if len(x) == 2}
    assert said["order"].startswith("4 to ")
    assert said["consistent"].startswith("yes to ")
    assert "not" not in said
    # 3/4 and one unit in the last place: rounding has gone further than the digits
    third = {
        "A": [[0, 0, 0], ["0.33333333333333331", 0, 0], [0, "0.66666666666666663", 0]],
        "b": [0.25, 0, "0.75000000000000011"],
    }
    assert main(["analyze", write(tmp_path, third)]) == 0
    assert "order 3 to 1.1e-16, 0 exactly" in " ".join(capsys.readouterr().out.split())


# --- a tableau and nothing else ------------------------------------------------------------------

HEUN = {"A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"]}
SAID = ("format", "name", "class", "claims", "source", "title", "notes", "$schema")


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "content",
    [
        HEUN,
        {**HEUN, "claims": {}},
        {**HEUN, "format": "glmref-method-1", "name": "heun"},
        {"A": HEUN["A"], "U": [["1"], ["1"]], "B": [["1/2", "1/2"]], "V": [["1"]]},
    ],
)
def test_analyze_and_show_read_it_and_verify_and_cite_say_what_is_missing(content, tmp_path, cli):
    file = str(write(tmp_path, content))
    assert "order with the identity" in cli("analyze", file).out
    assert json.loads(cli("analyze", file, "--format", "json").out)["order"] == 2
    assert "1/2" in cli("show", file).out
    out, err = cli("verify", file, code=2)
    assert out == "" and err == (
        "glmref: mine.json: there is nothing to verify, since the file makes no claims; "
        "`glmref analyze mine.json` says what the method is\n"
    )
    out, err = cli("cite", file, code=2)
    assert out == "" and "has no source to cite; add `source`" in err


def test_a_name_made_of_a_long_file_name_is_cut_at_a_hundred_characters(tmp_path: Path) -> None:
    path = tmp_path / ("Long Name " + "x" * 150 + ".json")
    path.write_text(json.dumps({"A": [["0"]], "b": ["1"]}))
    assert glmref.load(path).name == "long-name-" + "x" * 90


@pytest.mark.parametrize("name", ["ros34pw2", "nystrom-5", "ars-2-3-2", "rk4", "gauss-2"])
def test_the_format_is_the_first_that_has_the_class(name: str) -> None:
    blocks = {k: x for k, x in document(name).items() if k not in (*SAID, "embedded", "dense")}
    found = completed(blocks, "it.json")
    assert found["class"] == document(name)["class"]
    assert found["format"] == FORMATS[found["class"] in SECOND]
    assert not of_second(found) or found["format"] == FORMATS[1]
