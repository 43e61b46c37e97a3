"""Systems q' = f(p), p' = g(q, p): recognised, and run with one evaluation of g a step."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from glmref import compare, solve
from glmref.catalogue.advice import ADVICE
from glmref.catalogue.lookup import data_root, load
from glmref.catalogue.reader import load_document
from glmref.derive.general_multistep import general_document
from glmref.derive.halves import EndedHalf, GeneralHalf
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.forms import explicit_after_velocity, same_point
from glmref.errors import UsageError
from glmref.findings import Verdict
from glmref.method import Method
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.prove.facts import facts_of
from glmref.scenes.comparing import kind_of
from tests.build import SOURCE, floats

F = Fraction
#: Two halves of order 6, with an implicit one of q.
Q6 = EndedHalf((F(1, 5), F(-3, 4)), explicit=False)
P6 = EndedHalf((F(1, 2), F(-1, 3)), True)


def method(q: GeneralHalf, p: GeneralHalf) -> Method:
    document = general_document("found", q, p, title="found")
    return load_document({**document, "source": SOURCE, "claims": {"order": q.order}})


PAIR = method(Q6, P6)
TRAP = problem("magnetic-trap")
cosines = st.fractions(min_value=F(-15, 16), max_value=F(15, 16), max_denominator=16)


@given(st.lists(cosines, min_size=1, max_size=3, unique=True), st.booleans(), st.booleans())
@settings(max_examples=20)
def test_a_half_has_its_order_and_starts_and_ends_at_the_solution(c, minus_one, explicit):
    half = EndedHalf(tuple(c), minus_one, explicit)
    block = half.block()
    A, U, B, V, w = (block[key] for key in ("A", "U", "B", "V", "output"))
    assert U[0] == w
    assert A[1] == [sum(x * row[i] for x, row in zip(w, B, strict=True)) for i in (0, 1)]
    assert (A[1][1] == 0) == explicit
    x = 0.05
    pole = min(float(np.arccos(float(max(c)))), 2.0)
    assume(pole > 0.3)
    step = np.exp(x) * np.eye(len(V)) - np.array(V, dtype=float)
    slopes = np.array(B, dtype=float) @ np.array([1.0, np.exp(x)])
    found = np.array(w, dtype=float) @ np.linalg.solve(step, slopes)
    scale = sum(abs(float(u)) for u in half.residues) + 1
    left = abs(found - 1 / x - float(half.error_constant) * x ** (half.order - 1))
    assert left < 1e-12 / x * scale + 4 * scale * (x / pole) ** (half.order + 1) / pole


def test_the_order_holds_and_the_step_reads_the_same_backwards() -> None:
    facts = facts_of(PAIR)
    for claim, value in (("order", 6), ("order-identity", 6), ("symmetric", True)):
        assert facts.judge(claim, value).verdict is Verdict.HOLDS, claim
    for claim, value in (("order", 7), ("explicit", True), ("parasitism-free", True)):
        assert facts.judge(claim, value).verdict is Verdict.FAILS, claim


def test_a_half_with_a_changed_cosine_is_neither() -> None:
    """The values of other roots, or an update that is not cut in the middle."""
    document = general_document("found", Q6, P6, title="found")
    document["source"] = SOURCE
    document["q"]["V"][1][1] = "41/100"
    facts = facts_of(load_document(document))
    assert facts.judge("order", 6).verdict is Verdict.FAILS
    document = general_document("found", Q6, P6, title="found")
    document["source"] = SOURCE
    document["q"]["B"][1] = document["q"]["B"][1][::-1]
    assert facts_of(load_document(document)).judge("symmetric", True).verdict is Verdict.FAILS


def test_such_a_pair_is_recognised() -> None:
    assert explicit_after_velocity(PAIR)
    assert same_point(PAIR)
    # the half of p needs its own slope: then an equation has to be solved
    assert not explicit_after_velocity(method(P6, Q6))
    explicit = method(GeneralHalf((F(1, 2),), True), GeneralHalf((F(1, 3), F(-1, 4))))
    assert not same_point(explicit)


def field(t: float, y: Any) -> Any:
    B = 1 + y[0] ** 2
    return np.array([y[2], y[3], B * y[3] - y[0], -B * y[2] - 2 * y[1]])


def hidden(t: float, y: Any) -> Any:
    return field(t, np.array([float(x) for x in y]))


@pytest.mark.parametrize(
    ("given", "engine"),
    [
        (TRAP, "compiled"),
        (Problem(f=field, y0=[1, 0, 0, 0.5]), "compiled"),
        (Problem(f=hidden, dq=lambda p: p, y0=[1, 0, 0, 0.5]), "interpreted"),
    ],
)
def test_one_evaluation_a_step_however_f_is_given(given: Problem, engine: str) -> None:
    expected = solve(TRAP, PAIR, h=0.05, steps=40, engine="reference")
    found = solve(given, PAIR, h=0.05, steps=40, engine=engine)
    assert found.evaluations == 40
    assert np.abs(found.y - expected.y).max() < 1e-13


@pytest.mark.slow
def test_an_ensemble_takes_the_same_steps() -> None:
    y0 = np.array([TRAP.y0, np.array(TRAP.y0) * 1.25])
    found = solve_ensemble(TRAP, PAIR, y0, h=0.05, steps=40)
    alone = solve(TRAP, PAIR, h=0.05, steps=40)
    assert np.abs(found.y[0, 0] - alone.y[-1]).max() < 1e-14


@pytest.mark.slow
def test_separable_systems_take_one_force() -> None:
    found = solve("kepler", PAIR, h=0.01, steps=100)
    expected = solve("kepler", "gauss-6", h=0.01, steps=100)
    assert found.evaluations == 100
    assert np.abs(found.y - expected.y).max() < 1e-6


def test_systems_with_other_velocities_are_refused() -> None:
    with pytest.raises(UsageError, match="is not separable, where found has implicit stages"):
        solve("shear", method(P6, Q6), h=0.05, steps=40)
    with pytest.raises(UsageError, match="`f` and its part `dq` disagree at the start"):
        solve(Problem(f=hidden, dq=lambda p: 2 * p, y0=[1, 0, 0, 0.5]), PAIR, h=0.05, steps=40)


def test_the_page_prints_what_is_measured() -> None:
    page = (data_root().parent / "docs/velocities.md").read_text(encoding="utf-8")
    whole = json.loads((data_root() / "measurements/nonseparable.json").read_text("utf-8"))
    record, names = whole["semi-separable"], [f"multistep-kinetic-{p}" for p in (8, 10, 12)]
    counts = {(x["problem"], x["tolerance"]): x["methods"] for x in record["evaluations"]}
    means: dict[tuple[str, str, float], list[float]] = {}
    for (_, tolerance), found in counts.items():
        gauss = min(x for k, x in found.items() if k.startswith("gauss") and x)
        for name in (*names, "multistep-general-8", "multistep-general-8b"):
            for rival, x in (("gauss", gauss), ("dop853", found["scipy-dop853"])):
                if x and found[name]:
                    means.setdefault((name, rival, tolerance), []).append(found[name] / x)
    mean = {k: f"{np.exp(np.mean(np.log(x))):.2f}" for k, x in means.items()}
    eight, _, twelve = names
    g = [mean[name, "gauss", t] for t in (1e-9, 1e-6) for name in (eight, twelve)]
    d = [mean[name, "dop853", 1e-9] for name in (eight, twelve)]
    assert f"needs {g[0]} and `{twelve}` {g[1]} of the best Gauss" in page
    assert f"$10^{{-6}}$ the means are {g[2]} and {g[3]} (`-8`, `-12`)" in page
    assert f"of DOP853, where that reached $10^{{-9}}$, they are {d[0]} and {d[1]}." in page
    (advice,) = (x for x in ADVICE if x.kind == "semi-separable")
    assert advice.take[:2] == (eight, twelve) and f"{g[0]} of the evaluations" in advice.why
    assert f"The first needs {g[1]} at 1e-9, {g[3]} at 1e-6." in advice.more
    lost, other = (
        {x["problem"] for x in record["long"] if x["method"] == name and x["reported"]}
        for name in (eight, twelve)
    )
    assert (
        lost == other
        and len(lost) == 3
        and len(counts) == 2 * 7
        and "three of seven" in advice.more
    )
    general = [mean[f"multistep-general-{x}", "gauss", 1e-9] for x in ("8", "8b")]
    assert f"need {general[0]} and {general[1]} of Gauss here" in page
    for x in record["long"]:
        gone = x["energy"] is None or x["energy"] > 1e-3
        assert x["reported"] is not None or not gone  # no silent loss


@pytest.mark.parametrize(
    ("f", "found"),
    [
        ({"x": "v", "v": "-x - v/10"}, "general"),  # damping
        ({"x": "u", "y": "v", "u": "(1 + x**2)*v", "v": "-(1 + x**2)*u"}, "semi-separable"),
        ({"x": "u", "y": "v", "u": "(1 + x**2)*v", "v": "-(1 + x)*u"}, "general"),
    ],
)
def test_forces_that_only_turn_velocities_are_recognised(f: dict[str, str], found: str) -> None:
    assert kind_of(Problem.from_equations(f, dict.fromkeys(f, 1))) == found
    assert kind_of(Problem(f=field, y0=[1, 0, 0, 0.5])) == "semi-separable"


@pytest.mark.slow
def test_compare_watches_a_long_run_of_the_orbit() -> None:
    found = {
        name: compare(name, methods=["multistep-kinetic-8"], tolerance=1e-6)
        for name in ("magnetic-trap", "dipole-charge")
    }
    labels = {name: one.candidates[0].long_runs for name, one in found.items()}
    assert labels == {"magnetic-trap": "observed as bounded", "dipole-charge": "lost"}
    assert found["magnetic-trap"].recommended and found["dipole-charge"].recommended is None


@pytest.mark.parametrize(("order", "bound"), [(8, 0.167), (10, 0.232), (12, 0.177)])
def test_a_gyration_is_stable_up_to_the_bound_of_the_page(order: int, bound: float) -> None:
    """p' = i omega p: the half of p alone, with its stages."""
    m: Any = load(f"multistep-kinetic-{order}")
    c = m.components[1]
    A, U, B, V = (floats(M) for M in (c.A, c.U, c.B, c.V))

    def radius(z: float) -> float:
        step = V + 1j * z * B @ np.linalg.solve(np.eye(len(A)) - 1j * z * A, U)
        return float(np.abs(np.linalg.eigvals(step)).max())

    assert max(map(radius, np.linspace(bound / 40, bound, 40))) < 1 + 1e-6
    assert radius(bound + 0.003) > 1 + 1e-3
    page = (data_root().parent / "docs/velocities.md").read_text(encoding="utf-8")
    assert f"{bound}$" in page


@pytest.mark.slow
def test_the_step_has_to_suit_the_strongest_field_of_the_orbit() -> None:
    given = problem("dipole-charge")
    assert given.hamiltonian is not None
    whole = {}
    for h, steps in ((0.0008, 1_000_000), (0.0016, 500_000), (0.0266, 20_000)):
        found = solve(given, "multistep-kinetic-8", h=h, steps=steps, every=steps // 400)
        energy = np.array([float(given.hamiltonian(y)) for y in found.y])
        whole[h] = float(np.abs(energy / energy[0] - 1).max()), found.suspect
    assert whole[0.0008][0] < 1e-14  # rounding, which differs by processor
    assert whole[0.0016][0] < 1.5e-13  # what the start makes, of order 8
    assert whole[0.0008][1] is None
    assert whole[0.0016][1] is None
    assert whole[0.0266][1] is not None

    def frequency(y: np.ndarray) -> float:
        steps = 1e-6 * np.eye(6)[3:]
        columns = [(given.f(0.0, y + e) - given.f(0.0, y - e))[3:] / 2e-6 for e in steps]
        return float(np.abs(np.linalg.eigvals(np.array(columns)).imag).max())

    orbit = solve(given, "gauss-6", h=0.01, t_end=450, every=5)
    found = np.maximum.accumulate([frequency(y) for y in orbit.y])
    at = {t: f"{found[np.searchsorted(orbit.t, t) - 1]:.1f}" for t in (40, 450)}
    assert at == {40: "2.6", 450: "9.6"}


def test_a_growing_parasitic_part_is_reported() -> None:
    """Damping and driving of one sign: g_p is not skew, and every method grows."""
    equations = {"x": "v", "v": "-x + v*(1 - v**2 - x**2)/10"}
    cycle = Problem.from_equations(equations, {"x": 1, "v": 0})
    found = solve(cycle, PAIR, h=0.05, steps=20_000)
    assert found.suspect is not None
    assert "see docs/velocities.md" in " ".join(found.notices)
    assert solve(TRAP, PAIR, h=0.02, steps=20_000).suspect is None
