"""The vectors: made again byte for byte, proved again from the files, true to the contract."""

import hashlib
import json
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.canonical import laid_out
from glmref.catalogue.lookup import data_root, load
from glmref.conformance.bench import Bench
from glmref.conformance.faults import NOTES
from glmref.conformance.generate import METHODS, checksums, document_of
from glmref.conformance.run_cases import RunCases
from glmref.conformance.scheme import ball_field, enclosed_step, step_over
from glmref.conformance.step_cases import StepCases
from glmref.conformance.vector_problems import problems
from glmref.conformance.vectors import file_names, vectors_of
from glmref.exact import ball
from glmref.method import Method

FOLDER = data_root() / "vectors"
DECIMAL = re.compile(r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]+)?")


def no_float(text: str) -> object:
    raise AssertionError(f"{text} is a JSON float")


def read(path: Path) -> dict:
    return json.loads(path.read_text(encoding="utf-8"), parse_float=no_float)


def cases() -> list[tuple[str, dict]]:
    return [(name, case) for name in METHODS for case in read(FOLDER / f"{name}.json")["cases"]]


#: Files that are made in a second each; the others are made again in the slow tests.
QUICK = ("rk4", "ab-2", "leapfrog", "stormer-verlet", "forest-ruth-4", "pair-4-4")


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "name", [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in METHODS]
)
def test_the_file_comes_out_of_its_generator_byte_for_byte(name: str) -> None:
    text = laid_out(document_of(load(name), name))
    assert (FOLDER / f"{name}.json").read_text(encoding="utf-8") == text, (
        "run `python -m glmref.conformance.generate` and say in the changelog what was wrong"
    )


def test_the_files_are_those_of_the_generator_and_their_hashes_are_listed() -> None:
    assert file_names() == sorted(METHODS)
    assert (FOLDER / "SHA256SUMS").read_text(encoding="utf-8") == checksums(FOLDER)


def test_a_changed_digit_anywhere_changes_the_hash() -> None:
    listed = dict(
        reversed(line.split("  ")) for line in (FOLDER / "SHA256SUMS").read_text().splitlines()
    )
    text = (FOLDER / "rk4.json").read_text(encoding="utf-8")
    place = [m.start() for m in re.finditer(r"[0-9]", text)]
    for at in place[:: len(place) // 50]:
        changed = text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :]
        assert hashlib.sha256(changed.encode()).hexdigest() != listed["rk4.json"]


@pytest.mark.slow
def test_every_file_is_valid_against_the_schema() -> None:
    validators = pytest.importorskip("jsonschema").Draft202012Validator
    schema = read(data_root() / "schema" / "glmref-vectors-1.schema.json")
    validators.check_schema(schema)
    validator = validators(schema)
    for path in FOLDER.glob("*.json"):
        assert [e.message for e in validator.iter_errors(read(path))] == [], path.name
    document = read(FOLDER / "rk4.json")
    for wrong in (
        {**document, "extra": 1},
        {**document, "digits": "40"},
        {**document, "cases": [{**document["cases"][0], "h": 0.125}]},
        {key: x for key, x in document.items() if key != "coefficients"},
    ):
        assert not validator.is_valid(wrong)


def test_ids_are_unique_and_name_claim_method_and_problem() -> None:
    ids = [case["id"] for _, case in cases()]
    assert len(set(ids)) == len(ids) >= 240
    for name, case in cases():
        assert case["id"].split("/")[1:] == [name, case["problem"]]
        assert case["problem"] in problems()


def test_a_third_of_the_cases_are_traps_and_every_flag_is_noted_and_explained() -> None:
    flagged = [case for _, case in cases() if case["flags"]]
    assert 3 * len(flagged) >= len(cases())
    contract = (FOLDER / "README.md").read_text(encoding="utf-8")
    table = contract.partition("## Flags")[2].partition("\n## ")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| ")]
    listed = {flag for row in rows for flag in re.findall(r"[A-Z][A-Za-z]+", row)}
    used = {flag for case in flagged for flag in case["flags"]}
    assert used == listed == set(NOTES)
    for name in METHODS:
        document = read(FOLDER / f"{name}.json")
        mine = {flag for case in document["cases"] for flag in case["flags"]}
        assert set(document["notes"]) == mine


def test_every_wrong_result_is_off_by_a_million_rounding_errors() -> None:
    for _, case in cases():
        if "wrong" not in case:
            continue
        right = case["solution"][-1:] if case["kind"] == "trajectory" else case["output"]
        least = 10**6 * Fraction(case["rounding"]) / 2**53
        assert {x["flag"] for x in case["wrong"]} == set(case["flags"])
        for wrong in case["wrong"]:
            gap = max(
                abs(Fraction(a) - Fraction(b))
                for row, other in zip(wrong["output"], right, strict=True)
                for a, b in zip(row, other, strict=True)
            )
            assert gap > least, (case["id"], wrong["flag"])


def test_numbers_are_decimals_of_at_most_40_digits_and_inputs_are_doubles() -> None:
    for _, case in cases():
        for key in ("input", "output", "y0", "solution", "exact"):
            rows = case.get(key, [])
            for text in (x for row in rows for x in (row if isinstance(row, list) else [row])):
                assert DECIMAL.fullmatch(text), (case["id"], text)
                mantissa = text.partition("e")[0].lstrip("-").replace(".", "").lstrip("0")
                assert len(mantissa) <= 40
                if key in ("input", "y0") and case["kind"] in ("step", "start", "finish"):
                    exactly = Fraction(float(text)) == Fraction(text)
                    assert exactly or case["id"].startswith("symmetric")
        assert Fraction(case["bound"]) <= Fraction(1, 10**37)


def stage_rows(case: dict) -> list[list[str]]:
    stages = case["stages"]
    return stages["Q"] + stages["P"] if isinstance(stages, dict) else stages


def proved(name: str, case: dict) -> bool:
    """Whether ball arithmetic, from the file's numbers alone, confirms stages and output."""
    method, field = load(name), ball_field(problems()[case["problem"]].expressions)
    given = [[Fraction(x) for x in row] for row in case["input"]]
    guesses = [[ball(Fraction(x)) for x in row] for row in stage_rows(case)]
    # the file shows the stages to 40 digits; a box of 1e-36 around them is mapped into itself
    h, t = Fraction(case["h"]), Fraction(case["t"])
    stages, output = enclosed_step(
        method, field, t, given, h, refined(method, field, t, given, h, guesses)
    )
    bound = float(Fraction(case["bound"]))
    return all(
        (x - Fraction(text)).magnitude() <= bound
        for part, shown in ((stages, stage_rows(case)), (output, case["output"]))
        for row, texts in zip(part, shown, strict=True)
        for x, text in zip(row, texts, strict=True)
    )


def refined(
    method: Method, field: object, t: Fraction, given: list, h: Fraction, guesses: list
) -> list:
    """Improve stages of 40 digits to 60 by iterating on midpoints."""
    for _ in range(40):

        def solve(index, update, guesses=guesses):
            return [[x.midpoint() for x in row] for row in update([guesses[i] for i in index])]

        start = [[ball(x) for x in row] for row in given]
        to_ball = lambda x: x if hasattr(x, "midpoint") else ball(x)  # noqa: E731
        stages, _ = step_over(method, field, ball(t), start, ball(h), to_ball, solve)
        guesses = [[x.midpoint() for x in row] for row in stages]
    return guesses


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["rk4", "gauss-2", "gsymplectic-n", "forest-ruth-4"])
def test_steps_are_proved_again_from_the_file_and_a_changed_digit_is_refuted(name: str) -> None:
    case = next(c for c in read(FOLDER / f"{name}.json")["cases"] if c["id"].startswith("step"))
    assert proved(name, case)
    text = case["output"][0][-1]
    for at in (3, len(text) // 2, len(text) - 1):
        digit = str((int(text[at]) + 5) % 10)
        output = [
            [*case["output"][0][:-1], text[:at] + digit + text[at + 1 :]],
            *case["output"][1:],
        ]
        assert not proved(name, {**case, "output": output}), at


def test_a_method_without_a_file_gets_its_vectors_when_it_is_asked_for() -> None:
    vectors = vectors_of("midpoint-explicit")
    assert "midpoint-explicit" not in file_names()
    assert {case.kind for case in vectors.cases} == {"step", "trajectory", "order"}
    assert sum(bool(case.wrong) for case in vectors.cases) >= 3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["verner-efficient-6-5", "tanaka-yamashita-7-6"])
def test_the_bound_of_a_run_shows_something_where_entries_are_large(name: str) -> None:
    """Added up over eight steps in absolute values it was 1e24 roundings, and every run passed."""
    method: Any = load(name)
    runs = RunCases(Bench(method, name))
    assert float(runs.trajectory(problems()["pendulum"])["rounding"]) < 1e6


@pytest.mark.slow
def test_wrong_results_beyond_all_numbers_are_no_part_of_a_vector() -> None:
    """A step of the stages in another order overflows; the vectors could not be read."""
    method: Any = load("feagin-14-printed")
    steps = StepCases(Bench(method, "feagin-14-printed"))
    cubic = problems()["cubic"]
    case = steps.step("step", cubic, Fraction(1, 8))
    assert all(abs(float(x)) < 1e300 for w in case["wrong"] for row in w["output"] for x in row)
