"""A member that is missing or odd gets one sentence of the judge, never an error of the program."""

import json
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest

from glmref import judge
from glmref.judge.command import main
from glmref.judge.refusals import Refused
from tests.inside import at
from tests.inside import changed as put_in_copy

from .test_both_ways import ROWS
from .test_hypotheses import certificate_of

DEEP: list[Any] = []
for _ in range(500):
    DEEP = [DEEP]
ODD = [None, [], {}, 10**40, -1, "", True, 0.5, [[]], "x" * 300, [None], {"a": None}, "9" * 5000, DEEP]  # fmt: skip
#: A row by rule: together they have every rule and every class of file.
KINDS = {(row["parts"][-1]["rule"], row["document"]["class"]): name for name, row in ROWS.items()}


def places(value: object, before: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every member, of long lists of the first two only."""
    keys = list(value) if isinstance(value, dict) else range(min(2, len(value))) if isinstance(value, list) else ()  # fmt: skip
    for key in keys:
        yield (*before, key)
        yield from places(value[key], (*before, key))  # type: ignore[index]


def changed(certificate: dict[str, Any], draw: Random) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the certificate without each member, and with two odd values in its place."""
    for path in places(certificate):
        for value in ("removed", *draw.sample(ODD, 2)):
            other = put_in_copy(certificate, path, value)
            if value == "removed":
                del at(other, path[:-1])[path[-1]]
            yield f"{path}: {value!r:.40}", other


@pytest.mark.sampled(6, whole=len(KINDS))
@pytest.mark.parametrize("name", sorted(KINDS.values()))
def test_a_member_that_is_missing_or_odd_gets_one_sentence(name: str) -> None:
    for what, certificate in changed(certificate_of(ROWS[name]), Random(name)):
        try:
            sentence = judge.judged(certificate)
        except Refused as refused:
            sentence = str(refused)
        except Exception as error:
            raise AssertionError(what) from error
        assert sentence and "\n" not in sentence


def test_what_is_too_deep_is_no_certificate(tmp_path: Any, capsys: pytest.CaptureFixture) -> None:
    path = tmp_path / "deep.json"
    certificate = certificate_of(ROWS["midpoint-of-order-3"])
    path.write_text(json.dumps({**certificate, "base": DEEP}), encoding="utf-8")
    assert main([str(path)]) == 2
    assert "lists and objects stand more than 100 deep inside each other" in capsys.readouterr().err
