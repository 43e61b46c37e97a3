"""What the judge keeps of one certificate changes no later answer."""

import copy
import json
import random
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from glmref import judge
from glmref.cli.certifying import write_certificates
from glmref.judge.fields import Numbers
from glmref.judge.proof import record_of
from glmref.judge.refusals import Beyond

from .test_forged_certificates import EULER, certificate

#: An exact method with a start and a finish, a composition with an enclosure, multistep methods.
NAMES = ("gsymplectic-n", "suzuki-4", "yoshida-6-midpoint", "milne-simpson", "am-2")


def forged(value: dict[str, Any], other: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """The other verdict, another number declared, other parts, a proof or start with an error."""
    found = copy.deepcopy(value)
    said, text = found["statement"], json.dumps(found)
    kind = rng.randrange(5)
    if kind == 0:
        said["verdict"] = "fails" if said["verdict"] == "holds" else "holds"
    elif kind == 1:
        declared = said["declared"]
        said["declared"] = declared + 1 if type(declared) is int else not declared
        found["document"].get("claims", {}).pop(said["claim"], None)
    elif kind == 2:
        found["parts"] = copy.deepcopy(other["parts"])
    elif kind == 3:
        found["parts"] = found["parts"][:-1] or found["parts"]
    else:
        places = [k for k, c in enumerate(text) if c.isdigit()]
        k = rng.choice(places)
        found = json.loads(f"{text[:k]}{rng.randint(1, 9)}{text[k + 1 :]}")
    return found


@pytest.fixture(scope="module")
def true(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    folder = tmp_path_factory.mktemp("certificates")
    write_certificates(list(NAMES), folder)
    return [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.iterdir())]


def test_answers_do_not_depend_on_the_certificates_before(true: list[dict[str, Any]]) -> None:
    rng = random.Random(7)
    asked = [*true, *(forged(x, rng.choice(true), rng) for x in true)]

    def fresh() -> Iterator[tuple[bool, str]]:
        for value in asked:
            record_of.cache_clear()
            yield judge.verdict(value)

    expected = list(fresh())
    assert all(accepted for accepted, _ in expected[: len(true)])
    for _ in range(2):
        order = list(range(len(asked)))
        rng.shuffle(order)
        order.sort(key=lambda k: asked[k]["statement"]["method"])
        for k in order:
            assert judge.verdict(asked[k]) == expected[k]


@pytest.mark.parametrize("stop", [Beyond("time is up"), KeyboardInterrupt()])
def test_a_constant_that_was_not_read_to_the_end_is_read_again(monkeypatch, stop):
    start = {"A": [["0"]], "B": [["k-1/2"]], "u": ["1"]}
    d = {**EULER, "constants": {"k": "1/2"}, "starting": start}
    series = {"order": 1, "principal": "free", "trees": "all"}
    parts = [("order-at-least", series), ("order-at-most", {**series, "tree": "[o]"}),
             ("start-at-least", {"q": 1}), ("start-at-most", {"q": 1})]  # fmt: skip
    true, read, stops = certificate(d, "starting-order", 1, "holds", parts), Numbers.read, [stop]
    record_of.cache_clear()

    def stopped(self: Numbers, text: object, *rest: Any) -> Any:
        if text == "1/2" and stops:
            raise stops.pop()
        return read(self, text, *rest)

    monkeypatch.setattr(Numbers, "read", stopped)
    try:
        assert not judge.verdict(true)[0]
    except KeyboardInterrupt:
        assert isinstance(stop, KeyboardInterrupt)
    assert not stops
    assert judge.verdict(true)[0]


def test_two_threads_complete_no_series_at_once(true: list[dict[str, Any]]) -> None:
    record_of.cache_clear()
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert all(accepted for accepted, _ in pool.map(judge.verdict, true))
    finally:
        sys.setswitchinterval(before)
