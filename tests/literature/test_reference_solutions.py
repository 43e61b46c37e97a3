"""Reference states against other people's digits, and derived again in high precision.

The digits in reference_solutions.json, of 200 bits, come from another implementation, the Taylor integrator heyoka;
at 130 bits it gives the same, but for Hénon-Heiles at t = 1000. The others are printed in the
sources named.
"""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from glmref.catalogue.lookup import data_root
from glmref.conformance.taylor import taylor_states
from glmref.problems import names, problem
from glmref.problems.reference import Reference
from tests.build import high
from tools.collocation import collocation_states

# 200 bits: (problem, t) -> state
_FILE = Path(__file__).with_name("reference_solutions.json")
OTHER = {
    (name, int(t)): tuple(state)
    for name, states in json.loads(_FILE.read_text(encoding="utf-8")).items()
    for t, state in states.items()
}


def shipped(name, t, **parameters) -> Reference:
    """The reference of a problem at one time."""
    found = problem(name, **parameters).references
    return next(r for r in found if r.t == Fraction(t))


def difference(ours, theirs):
    """Largest difference relative to the largest component."""
    context = high(60)
    ours, theirs = [[context.mpf(x) for x in y] for y in (ours, theirs)]
    size = max(abs(x) for x in theirs)
    return max(abs(x - y) for x, y in zip(ours, theirs, strict=True)) / size


def body_by_body(state):
    """From the test set's order (all x, all y, all x', all y') to ours."""
    columns = np.array(state, dtype=object).reshape(2, 2, -1)
    return columns.transpose(0, 2, 1).reshape(-1).tolist()


def with_momenta(state):
    """Angles and angular velocities of the double pendulum to angles and momenta."""
    context = high(60)
    q1, q2, v1, v2 = [context.mpf(x) for x in state]
    c = context.cos(q1 - q2)
    return [q1, q2, 2 * v1 + v2 * c, v2 + v1 * c]


IN_OUR_COORDINATES = {"pleiades": body_by_body, "double-pendulum": with_momenta}


@pytest.mark.parametrize(("name", "t"), OTHER)
def test_references_agree_with_another_implementation_to_32_digits(name, t):
    theirs = IN_OUR_COORDINATES.get(name, list)(OTHER[name, t])
    # printed with 35 significant digits per component; chaos magnifies by 1e28 on the way to the
    # Hénon-Heiles state at t = 1000, of which 200 bits leave 32 digits (and 130 bits only 11)
    assert difference(shipped(name, t).state, theirs) < 1e-32


# name, parameters, t, digits as printed, relative difference that the printed digits allow, source
PRINTED = [
    (*(row[x] for x in ("name", "parameters", "t")), {int(k): x for k, x in row["digits"].items()},
     row["allowed"], row["source"])
    for row in json.loads(_FILE.with_name("printed_solutions.json").read_text(encoding="utf-8"))
]  # fmt: skip


@pytest.mark.parametrize(("name", "parameters", "t", "printed", "allowed", "source"), PRINTED)
def test_references_agree_with_printed_digits(name, parameters, t, printed, allowed, source):
    ours = shipped(name, t, **parameters).state
    for i, digits in printed.items():
        assert difference([ours[i]], [digits]) < allowed


@pytest.mark.parametrize("orbit", [1, 2])
def test_arenstorf_orbits_close_as_far_as_their_printed_digits_go(orbit):
    p = problem("arenstorf", orbit=orbit)
    (reference,) = p.references
    start = p.on(high(60)).y0
    gap = difference(reference.state, start)
    # 29 digits of the speed, magnified by the orbit's instability of about 1e2 to 1e3
    assert 1e-30 < gap < 1e-24


def test_figure_eight_closes_to_its_eight_digits():
    p = problem("figure-eight")
    (reference,) = p.references
    assert 1e-9 < difference(reference.state, p.on(high(60)).y0) < 1e-6


@pytest.mark.parametrize("t", [10, 100])
def test_pendulum_references_agree_with_elliptic_functions(t):
    p = problem("pendulum")
    assert difference(shipped("pendulum", t).state, p.on(high(60)).solution(t)) < 1e-36


# every entry of every file: (problem, parameters, t), and the state
ENTRIES = [
    (path.stem, entry["parameters"], entry["t"], entry)
    for path in sorted((data_root() / "solutions").glob("*.json"))
    for entry in json.loads(path.read_text(encoding="utf-8"))["solutions"]
]


def test_what_has_no_closed_form_has_a_reference():
    listed = {name for name, *_ in ENTRIES}
    for name in names():
        free = name.startswith("fault") or name == "pythagorean"
        assert problem(name).exact or name in listed or free, name


@pytest.mark.parametrize(("name", "parameters", "t", "entry"), ENTRIES)
def test_problems_find_their_entries(name, parameters, t, entry):
    reference = shipped(name, t, **parameters)
    assert list(reference.state) == entry["state"] and reference.agreement < 1e-28
    assert len(reference.state) == problem(name, **parameters).dimension


@pytest.mark.parametrize(("name", "parameters", "t", "entry"), ENTRIES)
def test_invariants_at_the_references_are_those_of_the_start(name, parameters, t, entry):
    p, context = problem(name, **parameters), high(60)
    exact = p.on(context)
    end = np.array([context.mpf(x) for x in entry["state"]], dtype=object)
    for key, value in {**exact.invariants, **exact.quadratic, "H": exact.hamiltonian}.items():
        if value is not None:
            before, after = value(exact.y0), value(end)
            # stiff springs magnify an error in y by up to 1e4
            allowed = 1e6 * max(float(entry["agreement"]), 1e-38) * (1 + abs(before))
            assert abs(after - before) < allowed, (key, float(after - before))


QUICK = {("pendulum", "10"), ("henon-heiles", "10")}
STIFF = ("robertson", "hires", "van-der-pol", "oregonator")


def marked(cases, quick=()):
    """Cases with their own names, slow ones marked."""
    return [
        pytest.param(
            *case,
            marks=() if (case[0], case[2]) in quick else pytest.mark.slow,
            id=f"{case[0]}-{case[2][:8]}-{'-'.join(case[1].values())}",
        )
        for case in cases
    ]


@pytest.mark.sampled(len(QUICK), whole=10)
@pytest.mark.parametrize(("name", "parameters", "t", "entry"), marked(ENTRIES, QUICK))
def test_references_are_derived_again(name, parameters, t, entry):
    p = problem(name, **parameters)
    if name in STIFF:
        (end,) = collocation_states(p, [t], digits=14, stages=8)
        allowed = 1e-12
    else:
        # chaos takes 28 digits on the way to t = 1000
        (end,) = taylor_states(p, [t], digits=48 if t == "1000" else 22)
        allowed = 1e-15
    # steps are right to 1e-22 (1e-14 and better); the flow magnifies the sum of their errors
    assert difference(end, entry["state"]) < allowed


TWO_WAYS = ("arenstorf", "double-pendulum", "lotka-volterra", "nonseparable-chain", "rigid-body")
OTHERWISE = [case for case in ENTRIES if case[0] in TWO_WAYS]


@pytest.mark.sampled(0, whole=4)
@pytest.mark.parametrize(("name", "parameters", "t", "entry"), marked(OTHERWISE))
def test_taylor_states_are_derived_again_by_collocation(name, parameters, t, entry):
    (end,) = collocation_states(problem(name, **parameters), [t], digits=13, stages=8)
    # the highest coefficient of a step is 1e-13; the end of a step is right to its square nearly,
    # and the satellite's orbit magnifies by 1e3
    assert difference(end, entry["state"]) < 1e-11
