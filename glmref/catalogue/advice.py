"""Which method to take for which kind of problem: one list for `compare`, report and choose.md.

The order is that of the measurements behind docs/choose.md and docs/multivalue.md: the fewest
evaluations at equal error first. On separable systems the first choice stayed bounded in all runs
of ten million steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..method import Method
from .claims import SYMPLECTIC
from .lookup import document, load

#: How a method carries on over long runs, by what its file says.
LOST, GROWS, BOUNDED, DRIFTS, UNKNOWN = "lost", "grows", "bounded", "drifts", "not recorded"
RECORDED, PREDICTED = "recorded as bounded", "predicted as bounded"
WATCHED, OBSERVED = "watched", "observed as bounded"
#: What these words mean.
MEANINGS = {
    BOUNDED: "symplectic with one value, so that no parasitic part can grow",
    RECORDED: "not symplectic; the energy error stayed bounded over the ten million steps that the "
    "file records",
    GROWS: "the energy error grows within ten million steps, as predicted on this orbit or by the "
    "file of the method",
    PREDICTED: "not symplectic; no parasitic part is predicted to become large on this orbit in "
    "ten million steps",
    OBSERVED: "not symplectic; no growing parasitic part was reported over a million steps of this "
    "orbit",
    WATCHED: "not symplectic; whether a parasitic part grows depends on the system, and a notice "
    "reports it",
    LOST: "the orbit is lost within ten million steps, as predicted or reported on this one or "
    "recorded in the file of the method",
    DRIFTS: "not symplectic: the energy error grows with time",
    UNKNOWN: "the file records no long run",
}
#: Steps up to which a method is recommended whose long runs grow or are lost.
SHORT = 100_000


@dataclass(frozen=True)
class Advice:
    """What to take for one kind of problem."""

    need: str  #: The problem, in words.
    take: tuple[str, ...]  #: Methods, the first choice first.
    why: str  #: Why the first choice, in one clause of at most twenty words.
    kind: str = ""  #: What `compare` calls it, ``""`` where it cannot tell.
    compared: tuple[str, ...] = ()  #: Further methods that `compare` measures.
    more: str = ""  #: What docs/choose.md adds, in whole sentences of Markdown.

    def limited(self, name: str) -> bool:
        """Return whether a method is for short runs only, as its file records."""
        return long_runs(load(name), document(name).get("notes", [])) in (LOST, GROWS)


ADVICE: tuple[Advice, ...] = (
    Advice(
        "second order, q'' = g(q)",
        ("multistep-rkn-8", "blanes-moan-rkn-6-14", "kahan-li-8", "pair-rkn-6-8b"),
        "fewest evaluations, at small constant steps; not symplectic (the splittings are), "
        "but bounded in 31 runs of ten million steps",
        "second order",
        ("multistep-rkn-10", "stormer-verlet", "blanes-moan-rkn-6-11", "gauss-4", "gauss-5"),
        "Shorter runs, or `renew=10_000`, also take `multistep-rkn-10` ({doc}`multivalue`). Of the "
        "explicit partitioned general linear methods, called pairs, for up to 100,000 steps also "
        "`pair-rkn-6-7b`. At 1e-9 the best pair needs fewer force evaluations than ten splittings "
        "on 17 of 19 problems, with cheap forces not always less time ({doc}`pairs`).",
    ),
    Advice(
        "separable p' = -V'(q), q' = T'(p)",
        ("multistep-8", "blanes-moan-6", "kahan-li-8", "pair-6-8"),
        "explicit, with the fewest evaluations; not symplectic (the splittings are), but bounded "
        "in 31 runs of ten million steps",
        "separable",
        ("stormer-verlet", "blanes-moan-4", "gauss-4", "gauss-5"),
        "For up to 100,000 steps also `pair-6-9`. At 1e-9 the best general pair needs fewer force "
        "evaluations than the best general splitting on 15 of 19 problems. The `rkn` pairs have "
        "order 4 only here. Yoshida's triple jump is `forest-ruth-4` as an explicit splitting, and "
        "`yoshida-4` with implicit midpoint steps.",
    ),
    Advice(
        "Hamiltonian, not separable",
        ("multistep-strong-8", "gauss-4", "gauss-5", "gauss-8"),
        "explicit; 0.23 of the evaluations of the best Gauss method at 1e-9; an orbit can be lost, "
        "with a notice",
        "Hamiltonian",
        ("multistep-strong-8b", "multistep-general-8", "gauss-2", "gauss-3", "s5i1-w3"),
        "The first is not symplectic; of 29 systems it lost two in ten million steps, kept in a "
        "transformed time ({doc}`close-encounters`), where `gauss-4` is symplectic. On the double "
        "pendulum, at 1e-9, `gauss-4` takes 0.42 to 0.80 of the time of six G-symplectic methods; "
        "the seventh, `order8-s5i1-w3`, takes 0.87 of its time ({doc}`order6-measurements`). On "
        "Kepler's orbit with eccentricity 0.6 `gauss-7` and `gauss-8` are the fastest of "
        "`gauss-3` to `gauss-8` ({doc}`engine`).",
    ),
    Advice(
        "charges in fields, rotating frames: q' = f(p), p' = g(q, p)",
        ("multistep-kinetic-8", "multistep-kinetic-12", "gauss-4"),
        "explicit; 0.28 of the evaluations of the best Gauss method at 1e-9; an orbit can be lost, "
        "with a notice",
        "semi-separable",
        ("multistep-kinetic-6", "multistep-kinetic-10", "gauss-5", "cooper-verner-8"),
        "Write the system in velocities. The first needs 0.21 at 1e-9, 0.24 at 1e-6. `-8` and "
        "`-12` lost three of seven systems in ten million steps, with a notice; `compare` watches "
        "a million of yours ({doc}`velocities`). With damping or driving take the last row.",
    ),
    Advice(
        "Hamiltonian, large, stages that require Newton's method",
        ("gauss-3", "gauss-4"),
        "symplectic; the engine separates the stages",
        more="`s5i2-w3` and `s5i1-w3` take 0.7 to 0.9 of `gauss-3`'s time on one chain, 1.0 to "
        "1.3 on another. Both lose Kepler's orbit within ten million steps, `s5i1-w3` the "
        "pendulum too.",
    ),
    Advice(
        "quadratic invariants (rigid body, angular momentum)",
        ("gauss-2", "gauss-3"),
        "conserved exactly in y itself",
        more="A G-symplectic method conserves them in the form of G only.",
    ),
    Advice(
        "stiff and dissipative",
        ("radau-iia-3", "sdirk-4", "tr-bdf2"),
        "L-stable; no symplectic method is",
        more="A symplectic method does not damp stiff transients ({doc}`scene-results`).",
    ),
    Advice(
        "not stiff, short time, no invariant to conserve",
        ("dormand-prince-5", "rk4"),
        "explicit; an adaptive code chooses h: scipy's RK45 (the same tableau) or DOP853",
        "general",
        ("cooper-verner-8", "gauss-4", "radau-iia-3", "sdirk-4"),
        "Conservation properties do not help there.",
    ),
)


def candidates(kind: str) -> tuple[str, ...]:
    """Return the methods that are measured on a kind of problem, the recommended ones first."""
    found = next(one for one in ADVICE if one.kind == kind)
    return (*found.take, *found.compared)


def long_runs(method: Method, notes: Sequence[str]) -> str:
    """Return how a method does on long runs: what its notes record, else by its structure."""
    said = " ".join(notes)
    if "has a notice" in said:
        return WATCHED
    if "lost" in said:
        return LOST
    if "grow" in said:
        return GROWS
    if "stays bounded" in said:
        return RECORDED
    if method.claims.get(SYMPLECTIC.key) is True:
        return BOUNDED
    return DRIFTS if method.is_one_step else UNKNOWN
