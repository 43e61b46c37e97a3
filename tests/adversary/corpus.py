"""Files that together notice every mutant of the kernel: shipped ones, and deceivers."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

from .deceive import doc, shipped, texts

NAMES = (
    "butcher-effective-5", "g4123", "gsymplectic-n-order-2",
    "rk4", "gauss-2", "bdf-2", "bdf-3", "leapfrog", "milne-simpson", "am-1", "ab-2",
    "gsymplectic-n", "gsymplectic-p", "gsymplectic-n-start-3-6", "milne-predictor", "trapezoidal",
    "stormer-verlet", "symplectic-euler-a", "yoshida-6-midpoint", "pair-4-4", "t115-i",
    "radau-iia-2", "lobatto-iiic-2", "kutta-3", "heun-2", "blanes-moan-rkn-4",
    "bdf-7", "ark-4-v-preconsistent", "gsymplectic-n-d-scaled", "gsymplectic-n-parasitism-free",
    "gsymplectic-p-growth", "gauss-2-seven-digits", "bdf-3-a-stable", "gauss-2-l-stable",
    "leapfrog-growth-sign", "pair-idle-value", "pair-4-5-not-palindromic", "radau-iia-2-symmetric",
    "rk4-a44-one", "rk4-abscissae-ones", "rk4-symplectic", "s4-v-transposed", "explicit-2-step-order-3",
    "symplectic-euler-b-symmetric", "thesis-3-8-symmetric", "trapezoidal-l-stable",
    "thesis-start-3-6-printed", "am-2-error-constant", "butcher-effective-5-classical",
    "lobatto-iiia-iiia-3", "pair-4-4-start-p-sign", "thesis-adams-moulton-printed",
    "mclachlan-atela-4-digits-swapped", "gsymplectic-n-p-pair", "explicit-euler-pair-symplectic",
)  # fmt: skip


def _glm(A: Any, U: Any, B: Any, V: Any, **claims: Any) -> dict[str, Any]:
    named = {k.replace("_", "-"): x for k, x in claims.items()}
    return doc("glm", named, A=texts(A), U=texts(U), B=texts(B), V=texts(V))


def documents() -> Iterator[tuple[str, dict[str, Any]]]:
    """Deceivers and their twins, each with a name."""
    one = [["1"]]
    yield "jordan in V", _glm([[1]], [[1, 0, 0]], [[1], [0], [0]], [[1, 0, 0], [0, 1, 1], [0, 0, 1]],
                              a_stable=True, l_stable=True, zero_stable=True, growth=[],
                              parasitism_free=True)  # fmt: skip
    yield "jordan on the axis", _glm([["1/2", 0], [0, "1/2"]], [[1, 0], [0, 1]], [[1, 1], [0, 1]],
                                     [[1, 0], [0, 1]], a_stable=True)  # fmt: skip
    yield "hidden pole", _glm([[1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 1], [0, 0]],
                              [[1, 0], [0, 0]], a_stable=True)  # fmt: skip
    yield "no hidden pole", _glm([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 1], [0, 0]],
                                 [[1, 0], [0, 0]], a_stable=True, l_stable=True)  # fmt: skip
    yield "inner zero", _glm([[0]], [[1, 0, 1]], [[1], [1], [0]],
                             [[1, 0, 0], [0, -1, 0], [0, 0, 0]], parasitism_free=True)  # fmt: skip
    yield "idle pole", _glm([[1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 0]],
                            [[1, 0], [0, 0]], a_stable=True)  # fmt: skip
    triple = ([[0] * 3] * 3, [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
              [[1, 0, 0], [0, -2, -1], [0, 0, -3]], [[1, 0, 0], [0, -1, 0], [0, 0, -1]])  # fmt: skip
    for name, numbers in (("right", ["3", "2"]), ("missing", []), ("twice", ["2", "2"])):
        yield f"multiple growth, {name}", _glm(*triple, growth=numbers, parasitism_free=False)
    nilpotent = (triple[0], triple[1], [[1, 0, 0], [0, 0, -1], [0, 0, 0]], triple[3])
    yield "nilpotent growth", _glm(*nilpotent, growth=["0", "0"], parasitism_free=True)
    double = ([[0]], [[1, 0]], [[1], [0]], [[1, 0], [0, 1]])
    yield "double one", _glm(*double, growth=["0"], parasitism_free=True, zero_stable=True,
                             abscissae=["0"],
                             order=1, consistent=True, preconsistent=True)  # fmt: skip
    yield "double one, seen", _glm([[0]], [["1/2", "1/2"]], [[1], [1]], [[1, 0], [0, 1]], order=1,
                                   growth=["0"], consistent=True, parasitism_free=True)  # fmt: skip
    yield "double one, growing", _glm([[0, 0], [0, 0]], [[1, 0], [1, 1]], [[1, 0], [-1, 1]],
                                      [[1, 0], [0, 1]], growth=["1"], parasitism_free=False)  # fmt: skip
    yield "not consistent", _glm([[0]], [[1]], [["1/2"]], one, consistent=True, order=1,
                                 preconsistent=True, abscissae=["0"])  # fmt: skip
    yield "not preconsistent", _glm([[0], ], [[2]], [[1]], [["1/2"]], preconsistent=True,
                                    consistent=True, order=1, g_symplectic=True)  # fmt: skip
    yield "second value", _glm([["1/2"]], [[0, 1]], [[0], [1]], [["1/2", 0], [0, 1]], order=2,
                               order_identity=2, abscissae=["1/2"], symmetric=False)  # fmt: skip
    yield "idle value", _glm([["1/2"]], [[1, 0]], [[1], [0]], [[1, 0], [0, 2]], symmetric=True,
                             symmetric_reduced=True)  # fmt: skip
    yield "no form", _glm([[0]], [[1, 0]], [[1], [1]], [[1, 0], [0, 0]], g_symplectic=True)
    low = shipped("rk4")
    low["claims"] = {"order": 3, "order-identity": 2, "stage-order": 0}
    yield "order too low", low
    other = shipped("bdf-7")
    other["broken"] = {**other["broken"], "found": "another reason"}
    yield "another reason", other
    mixed = doc("partitioned", {"order": 1, "symplectic": False, "order-identity": 1}, separable=True,
                q={"A": [["0"]], "U": [["1"]], "B": [["1"]], "V": [["1"]]},
                p={"A": [["1"]], "U": [["1", "0"]], "B": [["1"], ["0"]],
                   "V": [["1", "0"], ["0", "-1"]]})  # fmt: skip
    yield "one value and two", mixed
    start = _glm([[0]], [[1, 0]], [[1], [0]], [[1, 0], [0, 1]], order=1, starting_order=1)
    start["starting"] = {"A": [["0"]], "B": [["0"], ["0"]], "u": ["1", "0"]}
    yield "start, double one", start
    second = _glm([[0]], [[1, 0]], [[1], [0]], [[1, 0], [1, 0]], abscissae=["1"])
    yield "output is the second value", {**second, "output": ["0", "1"]}
    grows = {"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["0"]], "V": [["1", "0"], ["0", "2"]]}
    euler = {"A": [["0"]], "U": one, "B": one, "V": one}
    yield "one half grows", doc("partitioned", {"parasitism-free": True}, q=grows, p=euler)
    yield "effective", _glm([[0, 0], ["1/2", 0]], [[1], [1]], [[0, 1]], one, effective_order=2)
    yield "implicit cycle", _glm([[0, 1], [1, 0]], [[1], [1]], [["1/2", "1/2"]], one, explicit=True)
    yield (
        "explicit backwards",
        _glm([[0, 1], [0, 0]], [[1], [1]], [["1/2", "1/2"]], one, explicit=True),
    )
    for radius in ("1/2", "3/2"):
        yield f"inner {radius}", _glm([[0]], [[1, 0]], [[1], [0]], [[1, 1], [0, radius]],
                                      zero_stable=True, parasitism_free=True, growth=[])  # fmt: skip
    yield "rotation", _glm([["1/2"]], [[1, 0, 0]], [[1], [0], [0]],
                           [[1, 0, 0], [0, "3/5", "-4/5"], [0, "4/5", "3/5"]], zero_stable=True,
                           growth=["0", "0"], parasitism_free=True)  # fmt: skip
    balls = {"digits": 3}
    for claims in ({"zero-stable": True}, {"explicit": True, "order": 1}):
        yield "block of balls", doc("glm", claims, A=[["0"]], U=[["1", "0", "0"]],
                                    B=[["1"], ["1"], ["1"]],
                                    V=[["1", "0.333", "0.7"], ["0", "0.25", "0.5"],
                                       ["0", "0.125", "-0.25"]], **balls)  # fmt: skip
    for corner in ("1", "-1"):  # two blocks on the circle, coupled: open
        yield f"coupled {corner}", doc("glm", {"zero-stable": True}, A=[["0"]], U=[["1", "0"]],
                                       B=[["1"], ["0"]], V=[["1", "0.333"], ["0", corner]],
                                       **balls)  # fmt: skip
    yield "decimal start", _decimal_start()
    yield "decimal finish", _decimal_finish()
    # eigenvalues of M(iy) that meet on the circle for one irrational y, or for none
    for name, a, b in (("collision", "1/10", "-1/5"), ("no collision", "1/3", "-2/3")):
        A = [["1/4", "1/4-sqrt(3)/6", 0], ["1/4+sqrt(3)/6", "1/4", 0], [0, 0, a]]
        U, B = [[1, 0], [1, 0], [0, 1]], [["1/2", "1/2", 1], [0, 0, b]]
        yield name, _glm(A, U, B, [[1, 0], [0, -1]], a_stable=True)
    yield "unstable balls", doc("lmm", {"zero-stable": True}, alpha=["-5.000", "4.000", "1"],
                                beta=["2.0", "4.0", "0"], **balls)  # fmt: skip
    yield "leapfrog in balls", doc("lmm", {"zero-stable": True, "growth": [], "g-symplectic": True},
                                   alpha=["-1.000", "0", "1"], beta=["0", "2.000", "0"], **balls)  # fmt: skip
    yield "rk in balls", doc("rk", {"order": 2, "symplectic": True, "stage-order": 1,
                                    "abscissae": ["1/2"], "consistent": True, "explicit": False,
                                    "symmetric": True}, A=[["0.500"]], b=["1"], **balls)  # fmt: skip
    yield "rk in wrong balls", doc("rk", {"order": 1, "symplectic": True, "symmetric": True,
                                          "abscissae": ["1/2"], "explicit": True},
                                   A=[["0.625"]], b=["1"], **balls)  # fmt: skip
    yield "idle stage in balls", doc("rk", {"order": 2, "stage-order": 2}, b=["1/2", "1/2", "0"],
                                     A=[["0"] * 3, ["1/2", "1/2", "0"], ["0.500", "0.500", "0"]],
                                     **balls)  # fmt: skip
    yield "imaginary pole", doc("rk", {"a-stable": True}, A=[["i"]], b=["1"], field="complex")
    halves = {"q": {"A": one, "U": one, "B": one, "V": one},
              "p": {"A": [["0"]], "U": one, "B": one, "V": one}}  # fmt: skip
    claims = {"explicit": True, "order": 1, "symplectic": True, "symmetric": False, "reducible": False,
              "preconsistent": True, "consistent": True, "zero-stable": True}  # fmt: skip
    yield "shared pair", doc("partitioned", claims, **halves)
    rule = {"A": [["1/2"]], "b": ["1"], "A_hat": [["1/2"]], "b_hat": ["1"]}
    yield "symmetric shared pair", doc("partitioned-rk", {"symmetric": True, "symplectic": True,
                                                          "order": 2}, **rule)  # fmt: skip
    both = {key: shipped("gsymplectic-n")[key] for key in "AUBV"}
    yield "growth of a shared pair", doc("partitioned", {"parasitism-free": True}, q=both, p=both)
    yield "U in balls", doc("glm", {"consistent": True, "preconsistent": True}, A=[["0"]],
                            U=[["1.000"]], B=one, V=one, **balls)  # fmt: skip
    half = {"q": {"A": one, "U": [["1.000"]], "B": one, "V": one}, "p": halves["p"]}
    yield "one half in balls", doc("partitioned", {"g-symplectic": True}, **half, **balls)
    yield (
        "separable pair",
        doc("partitioned", {**claims, "nystrom-order": 1}, separable=True, **halves),
    )
    yield from _enclosures()


def _decimal_start() -> dict[str, Any]:
    """An exact method with a start of few digits: nothing encloses it."""
    d = shipped("gsymplectic-n")
    d["digits"] = 2
    d["starting"]["B"][1][0] = "0.14"
    d["claims"] = {"starting-order": d["starting"]["order"], "order": d["claims"]["order"]}
    return d


def _decimal_finish() -> dict[str, Any]:
    d = shipped("g4123")
    d["digits"] = 2
    d["finishing"]["b"][0] = "0.14"
    d["claims"] = {"finishing-order": d["claims"]["finishing-order"], "order": d["claims"]["order"]}
    return d


def _enclosures() -> Iterator[tuple[str, dict[str, Any]]]:
    tiny = "1/1" + "0" * 80
    for name in ("yoshida-6-midpoint", "t115-i", "pair-4-4"):
        base = shipped(name)
        for claim, value in (("order", base["claims"]["order"] - 2), ("growth", [tiny]),
                             ("order-identity", base["claims"]["order"] + 2)):  # fmt: skip
            d = copy.deepcopy(base)
            d["claims"] = {"order": base["claims"]["order"], claim: value}
            d.pop("starting", None), d.pop("finishing", None)
            yield f"{name} {claim} {value}", d
        d = copy.deepcopy(base)
        d.pop("starting", None), d.pop("finishing", None)
        d["claims"] = {"symmetric": True}
        yield f"{name} without an order", d
        equations = d["enclosure"]["equations"]
        growth = [x for x in equations if x.startswith("growth")]
        if growth:
            e = copy.deepcopy(base)
            e["enclosure"]["equations"][equations.index(growth[-1])] = growth[0]
            yield f"{name} one growth twice", e
    d = shipped("yoshida-6-midpoint")
    d["X"][0][0] = f"1+{tiny}"
    yield "X not one", d
    d = shipped("t115-i")
    d["X"][0] = [f"1+{tiny}" for _ in d["X"][0]]
    yield "X not one anywhere", d
    d = shipped("pair-4-4")
    d["b"][-1] += f"+{tiny}"
    yield "no palindrome", d
    d = shipped("yoshida-6-midpoint")
    d["claims"] = {"order": 6, "abscissae": ["0"] * len(d["X"][0])}
    yield "abscissae that no equation fixes", d
    for start in (1, 4):  # what is carried starts with zero up to order 1
        d = shipped("pair-4-4")
        d.pop("starting", None)
        d["claims"] = {"order": 4, "nystrom-order": 2, "starting-order": start}
        yield f"Nystrom order below the order, start {start}", d
    d = shipped("rk4")
    d["digits"], d["enclosure"] = 75, {"equations": ["order o"], "radius": "1e-60"}
    yield "enclosure of rk", d
