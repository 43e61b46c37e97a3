"""The adapters that are shipped: ours and scipy's pass; others where their library is there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from glmref.claims import UsageError, Verdict
from glmref.conformance.adapter import SHIPPED, load_adapter
from glmref.conformance.adapters.compiled import Adapter as Compiled
from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.conformance.checks import Suite
from glmref.conformance.subject import Subject
from glmref.conformance.vectors import file_names


def all_hold(adapter: Any) -> int:
    findings = Suite(Subject(adapter)).findings()
    assert [x for x in findings if x.verdict is not Verdict.HOLDS] == []
    return len(findings)


def test_the_reference_engine_passes_every_check_of_every_method() -> None:
    assert all_hold(Reference()) >= 400


def test_a_method_without_vectors_is_judged_all_the_same() -> None:
    assert all_hold(Reference(("heun-3", "adams-nordsieck-3", "position-verlet"))) >= 40


@pytest.mark.parametrize("name", file_names())
def test_the_generated_code_of_the_compiled_engine_passes(name: str) -> None:
    all_hold(Compiled((name,), engine="interpreted"))


@pytest.mark.parametrize("name", ["rk4", "gauss-2", "gsymplectic-n", "stormer-verlet"])
def test_compiled_kernels_pass(name: str) -> None:
    all_hold(Compiled((name,)))


@pytest.mark.slow
def test_compiled_kernels_of_every_method_pass() -> None:
    all_hold(Compiled())


def test_scipy_passes() -> None:
    pytest.importorskip("scipy")
    assert all_hold(load_adapter("scipy")) >= 40


@pytest.mark.peers
@pytest.mark.parametrize(
    ("name", "library"),
    [("diffrax", "diffrax"), ("heyoka", "heyoka"), ("rebound", "rebound"), ("nodepy", "nodepy")],
)
def test_a_peer_passes(name: str, library: str) -> None:
    pytest.importorskip(library)
    all_hold(load_adapter(name))


def test_every_shipped_adapter_has_a_module() -> None:
    from importlib.util import find_spec

    assert all(find_spec(place.partition(":")[0]) for place in SHIPPED.values())


class Plain:
    """The least that is an adapter."""

    methods: Any = ("rk4",)

    def step(self, *_: Any) -> np.ndarray:
        raise NotImplementedError("not today")


def test_what_an_adapter_does_not_offer_is_not_judged() -> None:
    found = Suite(Subject(Plain())).findings()
    assert {x.verdict for x in found} == {Verdict.OPEN}
    assert found[0].witness == "not offered: not today"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"methods": ()}, "`methods`"),
        ({"methods": None}, "`methods`"),
        ({"methods": ("rk5",)}, "no method named"),
        ({"methods": {"mine": {"speed": 3}}}, "claims 'speed'"),
        ({"tolerance": 2}, "`tolerance`"),
        ({"tolerance": {"rk4": "small"}}, "`tolerance`"),
        ({"epsilon": True}, "`epsilon`"),
        ({"starts": "somehow"}, "`starts`"),
        ({"step": None}, "`step` or `solve`"),
        ({"methods": {"mine": {"order": 4}}, "problems": ("moon",)}, "must name some of"),
    ],
)
def test_an_adapter_that_is_none_is_refused_with_a_sentence(changes: dict, words: str) -> None:
    cls = type("Bad", (Plain,), changes)
    with pytest.raises(UsageError) as caught:
        Suite(Subject(cls()))
    assert words in str(caught.value)
