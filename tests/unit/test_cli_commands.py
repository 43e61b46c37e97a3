"""The commands: what they print, in each format, and the exit code that says how it went."""

import csv
import io
import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.shell_completion import ShellComplete

from glmref import __version__
from glmref.catalogue.lookup import document, names
from glmref.cli import EXAMPLES, HIDDEN, group, main
from glmref.findings import Finding, Verdict
from glmref.prove import verifier as verification

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process."""
    return lambda *arguments: (main(arguments), *capsys.readouterr())


@pytest.fixture
def overclaimed(tmp_path: Path) -> str:
    """A right method with a wrong claim."""
    doc = document("rk4")
    file = tmp_path / "mine.json"
    file.write_text(json.dumps({**doc, "name": "mine", "claims": {"order": 5, "explicit": True}}))
    return str(file)


def test_version_and_help_name_the_program(run: Run) -> None:
    assert run("--version") == (0, f"glmref {__version__}\n", "")
    code, out, err = run("--help")
    assert (code, err) == (0, "") and "  General linear methods, checked exactly.\n" in out
    for command, example in EXAMPLES.items():
        assert f"\n  {command.name} " in out
        _, page, _ = run(str(command.name), "--help")
        assert f"Example: {example}" in " ".join(page.split())
    for command, new in HIDDEN.items():
        assert f"\n  {command.name} " not in out
        assert new in " ".join(run(str(command.name), "--help")[1].split())


@pytest.mark.parametrize("line", [*EXAMPLES.values()])
def test_the_example_of_a_command_is_read(line: str) -> None:
    """Every word of an example names a command, an option, or what one takes."""
    with group.make_context("glmref", line.split()[1:]) as context:
        name, command, rest = group.resolve_command(
            context, [*context._protected_args, *context.args]
        )
        assert command.make_context(name, rest, parent=context).params


#: An old command line and the new one: the same exit code and the same output.
SAME = """
check TABLEAU = verify TABLEAU
check TABLEAU --order 3 = verify TABLEAU --order 3
check TABLEAU --order 2 --format json = verify TABLEAU --order 2 --format json
certify rk4 = verify rk4 --certificates -
export rk4 --to c = convert rk4 --to c
export rk4 --to csv = convert rk4 --to csv
import TABLE --from csv = convert TABLE --from csv
cite rk4 gauss-2 = show rk4 gauss-2 --bibtex
errata --verdict misprint = list --errata --verdict misprint
errata 'order 6' --format csv = list 'order 6' --errata --format csv
audit TABLEAU --from python = audit TABLEAU
lint TABLEAU --format github = audit --lines TABLEAU --format=github
probe reference --method rk4 = conformance reference --identify --method=rk4
board --recipe scipy = conformance --recipe scipy
"""


@pytest.mark.parametrize(("old", "new"), [x.split(" = ") for x in SAME.strip().split("\n")])
def test_an_old_name_does_what_the_new_one_does(run, tmp_path, old, new):
    tableau, table = tmp_path / "tableau.json", tmp_path / "table.csv"
    tableau.write_text('{"A": [[0, 0], ["1/2", 0]], "b": [0, 1], "order": 2}')
    table.write_text(run("export", "rk4", "--to", "csv")[1])
    places = {"TABLEAU": str(tableau), "TABLE": str(table)}
    first, second = (run(*(places.get(x, x) for x in shlex.split(line))) for line in (old, new))
    assert first[:2] == second[:2]


def test_a_table_of_one_package_is_converted_for_another(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "rk4.csv"
    table.write_text(run("convert", "rk4", "--to", "csv")[1])
    code, out, _ = run("convert", str(table), "--from", "csv", "--to", "latex")
    assert (code, out.count("tabular")) == (
        0,
        run("convert", "rk4", "--to", "latex")[1].count("tabular"),
    )


def test_no_command_is_a_usage_error_that_shows_the_help(run: Run) -> None:
    code, out, err = run()
    assert (code, out) == (2, "")
    assert "Usage: glmref" in err


@pytest.mark.slow
def test_verify_fails_with_exit_1_where_a_claim_fails(run: Run, overclaimed: str) -> None:
    code, out, err = run("verify", overclaimed)
    assert (code, err) == (1, "")
    assert "FAILS  exact     order     declared 5, found 4; tree " in out
    assert "holds  exact     explicit  yes" in out
    assert "1 hold, 1 fail, 0 open" in out


@pytest.mark.slow
def test_verify_json_has_the_shape_of_its_format(run: Run, overclaimed: str) -> None:
    code, out, _ = run("verify", "euler", overclaimed, "--format", "json")
    assert code == 1
    record = json.loads(out)
    assert list(record) == ["format", "findings", "summary"]
    assert record["format"] == "glmref-findings-1"
    verdicts = {(f["method"], f["claim"]): f["verdict"] for f in record["findings"]}
    assert verdicts["euler", "order"] == "holds"
    assert verdicts["mine", "order"] == "fails"
    assert record["summary"]["fails"] == 1


@pytest.mark.slow
def test_verify_csv_and_junit_hold_the_same_findings(run: Run, overclaimed: str) -> None:
    _, out, _ = run("verify", "euler", overclaimed, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(out)))
    _, out, _ = run("verify", "euler", overclaimed, "--format", "junit")
    cases = list(ElementTree.fromstring(out).iter("testcase"))
    assert [(r["method"], r["claim"]) for r in rows] == [
        (c.get("classname"), c.get("name")) for c in cases
    ]
    assert [r["verdict"] for r in rows].count("fails") == 1
    assert [len(c.findall("failure")) for c in cases].count(1) == 1


@pytest.mark.slow
def test_only_restricts_what_is_checked(run: Run, overclaimed: str) -> None:
    _, out, _ = run(
        "verify", "gsymplectic-n", "--only", "order", "--only", "growth", "--format", "json"
    )
    assert [f["claim"] for f in json.loads(out)["findings"]] == ["order", "growth"]
    assert run("verify", overclaimed, "--only", "explicit")[0] == 0
    assert run("verify", overclaimed, "--only", "order")[0] == 1
    code, out, _ = run("verify", "rkf45-3554", "rk4", "--only", "order", "--format", "json")
    assert [f["claim"] for f in json.loads(out)["findings"]] == ["refutes order", "order"]


def found(verdict: Verdict) -> Finding:
    return Finding("it", "order", 4, verdict, None, witness="no matter")


@pytest.mark.parametrize(
    ("verdicts", "code"),
    [
        ([Verdict.HOLDS], 0),
        ([Verdict.HOLDS, Verdict.FAILS], 1),
        ([Verdict.HOLDS, Verdict.OPEN], 3),
        ([Verdict.OPEN, Verdict.FAILS], 1),
    ],
)
def test_exit_code_follows_the_verdicts(run, monkeypatch, verdicts, code):
    monkeypatch.setattr(
        verification, "verify_file", lambda name, **options: [found(v) for v in verdicts]
    )
    assert run("verify", "euler")[0] == code


def test_bad_input_beside_a_failure_is_exit_2_and_keeps_the_failure(run, overclaimed):
    code, out, err = run("verify", overclaimed, "no-such-method")
    assert code == 2
    assert "FAILS" in out
    assert err.startswith("glmref: there is no method named")
    code, out, _ = run("verify", "no-such-method", "euler", "--format", "junit")
    assert code == 2
    assert len(list(ElementTree.fromstring(out).iter("error"))) == 1


def test_analyze_table_and_csv_say_the_same(run: Run) -> None:
    _, table, _ = run("analyze", "gsymplectic-n")
    assert "\norder " in table
    assert "growth mu at -1" in table
    _, text, _ = run("analyze", "gsymplectic-n", "--format", "csv")
    rows = dict(list(csv.reader(io.StringIO(text)))[1:])
    assert json.loads(rows["order"]) == 4
    assert json.loads(rows["symmetric"])["holds"] is True


@pytest.mark.slow
def test_analyze_shows_the_modified_equation(run: Run, tmp_path: Path) -> None:
    code, table, _ = run("analyze", "gsymplectic-n", "--modified")
    assert code == 0 and "conjugate-symplectic to order              at least 6" in table
    assert re.search(r"h\^4 H\(\[oooo\]\) times +-1/4320", table)
    found = json.loads(run("analyze", "rk4", "--modified", "--format", "json")[1])["modified"]
    assert found["conjugate_symplectic"]["order"] == 4 and found["conjugate_symplectic"]["fails"]
    assert "modified" not in json.loads(run("analyze", "rk4", "--format", "json")[1])
    # a file of one's own is looked at in a process apart; why there is nothing is an answer
    own = tmp_path / "own.json"
    own.write_text('{"A": [["1/2"]], "b": [1]}')
    assert "Hamiltonian to order" in run("analyze", str(own), "--modified")[1]
    assert "additive" in run("analyze", "ars-2-2-2", "--modified")[1].split("modified equation")[1]


@pytest.mark.slow
def test_analyze_says_the_same_interval_in_every_format(run: Run) -> None:
    """An end that is not proved is null in the proved part, and its measured value stands apart."""
    _, table, _ = run("analyze", "t115-i")
    record = json.loads(run("analyze", "t115-i", "--format", "json")[1])
    assert record["stability_measured"]
    for key, end in record["stability_measured"].items():
        assert record["stability"][key] is None
        assert f"{end:.12g}" in table and ", measured" in table
    assert "stability_measured" not in json.loads(run("analyze", "rk4", "--format", "json")[1])
    whole = json.loads(run("analyze", "gauss-2", "--format", "json")[1])["stability"]
    assert (whole["real"], whole["imaginary"]) == (
        "infinity",
        "infinity",
    )  # not null: JSON has no inf
    assert "the negative real axis" in run("analyze", "gauss-2")[1]


def test_analyze_leaves_with_3_where_something_is_not_decided(run: Run) -> None:
    code, out, _ = run("analyze", "gauss-2-seven-digits", "--format", "json")
    record = json.loads(out)
    decided = [record["g_symplectic"]["holds"], record["symmetric"]["holds"]]
    decided += [record[k] for k in ("preconsistent", "consistent", "zero_stable")]
    decided += [record["parasitism_free"]]
    assert code == (3 if None in decided else 0)
    assert record["proof"] == "measured"


@pytest.mark.slow
def test_analyze_needs_no_true_claim(run: Run, overclaimed: str) -> None:
    code, out, _ = run("analyze", overclaimed, "--format", "json")
    assert code == 0
    assert json.loads(out)["order"] == 4


def test_list_shows_every_method_of_a_class_and_no_other(run: Run) -> None:
    _, out, _ = run("list", "--format", "json")
    rows = json.loads(out)["methods"]
    assert [row["name"] for row in rows] == names("methods")
    _, out, _ = run("list", "--class", "splitting", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert {row["class"] for row in rows} == {"splitting"}
    assert "stormer-verlet" in {row["name"] for row in rows}


def test_list_broken_names_the_claim_that_fails(run: Run) -> None:
    code, out, _ = run("list", "--broken")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()[2:]] == names("broken")
    (line,) = (x for x in out.splitlines() if x.startswith("rkf45-3554 "))
    assert line.split()[1:4] == ["rk", "order", "DigitsSwapped"]


def test_errata_by_id_by_text_and_by_verdict(run: Run) -> None:
    code, out, _ = run("errata", "1.1-euler-form")
    assert code == 0
    assert out.startswith("1.1-euler-form  right, exact\n")
    assert len(out.splitlines()) < 12
    _, out, _ = run("errata", "--verdict", "wrong", "--format", "json")
    records = json.loads(out)["errata"]
    assert {r["verdict"] for r in records} == {"wrong"}
    _, out, _ = run("errata", "3.8", "--format", "csv")
    assert len(list(csv.DictReader(io.StringIO(out)))) > 1
    _, out, _ = run("errata", "--method", "thesis-3-8-printed")
    assert "a_21 = -11/72" in out


@pytest.mark.parametrize(
    ("words", "begun", "wanted"),
    [
        ("show", "gauss-", "gauss-2"),
        ("verify rk4", "yoshida-4", "yoshida-4"),
        ("problems", "kep", "kepler"),
        ("compare", "dou", "double-pendulum"),
        ("run", "start-", "start-zero"),
        ("run", "resonance-", "resonance-map"),
        ("derive", "two", "two-stage"),
    ],
)
def test_names_are_completed(words: str, begun: str, wanted: str) -> None:
    """Each command completes what it takes, and nothing that is wrong on purpose."""
    found = ShellComplete(group, {}, "glmref", "_GLMREF_COMPLETE").get_completions(
        words.split(), begun
    )
    offered = {item.value for item in found if item.type == "plain"}
    assert wanted in offered
    assert all(name.startswith(begun) for name in offered)
    assert not offered & set(names("broken"))


def test_certify_says_which_folder_cannot_be_made(run: Run, tmp_path: Path) -> None:
    """A file stands where the folder should be: the sentence names it."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    code, _, err = run("certify", "rk4", "--output", str(tmp_path / "file" / "out"))
    assert code == 2
    assert f"{str(tmp_path / 'file')!r} is a file; name another folder" in err


def test_an_empty_input_of_check_says_what_to_write(run, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("  \n"))
    code, out, err = run("check", "-")
    assert (code, out) == (2, "") and err.startswith("glmref: the standard input is empty; write {")


def test_the_list_shows_the_order_that_a_method_is_known_by(run: Run) -> None:
    rows = {
        x["name"]: x["order"] for x in json.loads(run("list", "--format", "json")[1])["methods"]
    }
    assert None not in (rows["dormand-prince-rkn-4-3"], rows["feagin-10-printed"])
    names = ("dormand-prince-rkn-8-6", "dormand-prince-rkn-12-10", "blanes-moan-rkn-6-11", "rk4")
    assert [rows[x] for x in names] == [8, 12, 6, 4]


def test_a_rosenbrock_method_is_analysed_and_drawn_in_its_own_terms(run, tmp_path):
    code, out, _ = run("analyze", "ros3-printed")
    rows = dict(x.split(maxsplit=1) for x in out.splitlines() if x.startswith("stages"))
    assert code == 0 and rows == {"stages": "3"}
    assert "order                                      3 to " in out
    assert "order of row embedded" in out and "embedded embedded" not in out
    code, out, _ = run("show", "ros3-printed", "--plot", str(tmp_path / "r.svg"))
    assert code == 0 and (tmp_path / "r.svg").read_text().startswith("<")
    assert "class rosenbrock: 3 stages, 1 value\n" in out


def test_what_does_not_apply_to_an_imex_method_is_not_listed(run: Run) -> None:
    """And its implicit part is analysed: ARS(2,3,2) of Ascher, Ruuth and Spiteri is L-stable."""
    code, out, _ = run("analyze", "ars-2-3-2")
    assert code == 0
    for word in ("symplectic", "symmetric", "parasitism", "not decided", "growth"):
        assert word not in out
    assert re.search(r"^L-stable, part 2 +yes$", out, re.MULTILINE) and "part 1" not in out
    code, out, _ = run("analyze", "ars-2-3-2", "--format", "json")
    record = json.loads(out)
    assert record["stability_parts"]["2"]["L"] is True and "symmetric" not in record


def test_a_refused_export_names_the_formats_that_hold_the_method(run: Run) -> None:
    """LaTeX holds no Rosenbrock method, so that it does not hold every method."""
    _, _, err = run("export", "dormand-prince-rkn-12-10", "--to", "petsc")
    assert err.endswith("is a Runge-Kutta-Nystrom method; json, csv and latex hold it\n")
    _, _, err = run("export", "ros3-printed", "--to", "latex")
    assert err.endswith("json and csv hold it, and latex does not\n")


def test_signs_of_residuals_agree_within_an_analysis(run: Run) -> None:
    _, out, _ = run("analyze", "dimsim-2-type-1")
    assert "has residual 0.333333" in out and "largest 0.333333 at tree [oo]" in out
    assert "by which the" in out


def test_a_claim_of_sizes_that_fails_is_written_as_a_person_writes_it(run: Run) -> None:
    _, out, _ = run("verify", "verner-robust-8-7-digit")
    assert "declared b 8 to 2.4e-41, embedded 7 to 8.0e-42; row b: tree " in out
    assert "not decided" not in out and "{" not in out


def test_a_terminal_is_told_what_is_being_analysed(run, monkeypatch):
    assert "analyzing" not in run("analyze", "rk4")[2]  # no terminal, no progress
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    _, out, err = run("analyze", "rk4")
    assert "\r\x1b[Kanalyzing rk4 ..." in err and err.endswith("\r\x1b[K") and out.startswith("rk4")


def test_the_keys_of_the_json_of_the_commands_are_documented(run: Run) -> None:
    page = (Path(__file__).parents[2] / "docs" / "your-tableau.md").read_text(encoding="utf-8")
    for command, key in ((("verify", "rk4"), "findings"), (("list", "--broken"), "methods")):
        record = json.loads(run(*command, "--format", "json")[1])
        (line,) = [x for x in page.splitlines() if x.startswith(f"| `{record['format']}`")]
        for word in (*(record.keys() - {"format"}), *record[key][0]):
            assert f"`{word}`" in line, (command, word)
