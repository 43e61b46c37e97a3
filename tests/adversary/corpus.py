"""Files that together notice every mutant of the kernel: shipped ones, and deceivers."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

from .deceive import doc, shipped, texts

NAMES = (
    "butcher-effective-5", "g4123", "gsymplectic-n-order-2",
    "multistep-general-6", "rk4", "gauss-2", "bdf-2", "bdf-3", "leapfrog", "milne-simpson", "am-1", "ab-2",
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
    yield from _undecided_at_order_1()
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
    weights = {"U": [["1"]] * 3, "B": [["1/6", "2/3", "1/6"]], "V": one}
    Q = [["0", "0", "0"], ["-1/4", "3/4", "0"], ["0", "1", "0"]]
    P = [["0", "1", "0"], ["0", "3/4", "-1/4"], ["0", "0", "0"]]
    yield "two times of shared stages", doc("partitioned", {"order": 3}, q={"A": Q, **weights},
                                            p={"A": P, **weights})  # fmt: skip
    for abscissae in (["0", "0"], ["0", "1"]):
        yield "abscissae that are free", _glm([[0, 0], [0, 0]], [[1, 0], [1, 1]], [[1, 0], [0, 0]],
                                              [[1, 0], [0, 1]], abscissae=abscissae)  # fmt: skip
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
    yield from conditions()
    yield from _enclosures()


def conditions() -> Iterator[tuple[str, dict[str, Any]]]:
    """One file for each condition of a rule that no other file turns on."""
    yield from _proofs_in_decimals()
    yield from _pairs()
    yield from _starts()
    yield from _rows()


def _proofs_in_decimals() -> Iterator[tuple[str, dict[str, Any]]]:
    """What is decided where one part alone is in decimals, and starts along the flow."""
    one = [["1"]]
    middle = {"A": [["1/2"]], "U": one, "B": one, "V": one, "digits": 2}
    step = {"A": [["1/2"]], "B": one, "u": ["1"], "order": 2}
    claims = {"order": 2, "starting-order": 2, "finishing-order": 2}
    back = {"A": [["-1/2"]], "b": ["-1"], "order": 2}
    yield "start along the flow", doc("glm", claims, **middle, starting=step, finishing=back)
    for name, method, start, b in (("method", "0.50", "1", "1"), ("start", "1/2", "1.00", "1"),
                                   ("finish", "1/2", "1", "1.00")):  # fmt: skip
        yield f"wrong finish, {name} in decimals", doc(
            "glm", claims, **{**middle, "A": [[method]]},
            starting={**step, "B": [[start]]}, finishing={**back, "b": [b]},
        )  # fmt: skip
    wrong = {"A": [["0"]], "B": [["0"], ["1"]], "u": ["1", "0"]}
    yield "wrong start of a method in decimals", doc(
        "glm", {"order": 2, "starting-order": 2}, digits=2, starting=wrong, A=[["0", "0"], ["0.50", "0"]],
        U=[["1", "0"], ["1", "0"]], B=[["0", "1"], ["0", "0"]], V=[["1", "0"], ["0", "0"]],
    )  # fmt: skip
    yield "error constant in decimals", doc("lmm", {"error-constant": "1/6"}, digits=3,
                                            alpha=["-1.000", "0", "1"], beta=["0", "2.000", "0"])  # fmt: skip
    yield (
        "error constant of another class",
        doc("rk", {"error-constant": "1/6"}, A=[["0"]], b=["1"]),
    )
    yield "double one, wrong growth", _glm([[0, 0], [0, 0]], [[1, 0], [1, 1]], [[1, 0], [-1, 1]],
                                           [[1, 0], [0, 1]], growth=["2"])  # fmt: skip
    yield "order 1 open and order 2 right", doc("rk", {"order": 2}, b=["0.1-0.1", "1"], digits=1,
                                                A=[["0", "0"], ["1/2", "0"]])  # fmt: skip
    unit = [[1, 0], [0, 1]]
    yield "backward Euler twice", _glm(unit, unit, unit, unit, a_stable=True)
    yield "pole on the axis", doc("rk", {"a-stable": True}, A=[["i"]], b=["i"], field="complex")
    yield "fixed eigenvalue -1", _glm([["1/2"]], [[1, 0]], [[1], [0]], [[1, 0], [0, -1]],
                                      a_stable=True)  # fmt: skip
    yield "idle pole beside the midpoint rule", _glm([["1/2", 0], [0, -1]], [[1, 0], [0, 1]],
                                                     [[1, 0], [0, 0]], [[1, 0], [0, 0]],
                                                     a_stable=True)  # fmt: skip
    turn = [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]  # a pole at i, 4 z / (1 - z)^2
    yield "pole at a sample", _glm(turn, [[1, 0], [1, 0], [0, 1], [0, 1]],
                                   [["1/2", "1/2", 0, 0], [0, 0, 0, 4]], [[1, 0], [0, 0]],
                                   a_stable=True)  # fmt: skip
    yield "pole in the left half-plane", doc("rk", {"a-stable": True}, A=[["-1", "0"], ["1", "1"]],
                                             b=["1/2", "1/2"])  # fmt: skip
    yield (
        "equal stages with a negative diagonal",
        doc("rk", {"a-stable": True, "l-stable": True}, A=[["-1", "2"], ["-1", "2"]], b=["0", "1"]),
    )
    for value in ("2.0", "1.0"):  # in decimals, seen by no stage
        yield f"idle value {value}", doc("glm", {"symmetric-reduced": True}, A=[["1/2"]], digits=1,
                                         U=[["1", "0"]], B=[["1"], ["0"]], V=[["1", "0"], ["0", value]])  # fmt: skip
    yield "too large a principal growth", _glm([[0]], [[1, 1]], [[1], [1]], [[1, 0], [0, 1]],
                                               parasitism_free=True)  # fmt: skip
    none = {"A": [["0.50"]], "U": one, "B": one, "V": [["1/2"]]}
    double = {"A": [["0", "0"], ["1.00", "0"]], "U": [["1", "0"], ["0", "1"]],
              "B": [["1/4", "3/4"], ["3/4", "1/4"]], "V": [["1", "0"], ["0", "1"]]}  # fmt: skip
    for name, keys, c in (("no", none, ["1/2"]), ("a double", double, ["0", "1"])):
        yield f"abscissae with {name} eigenvalue 1", doc("glm", {"abscissae": c}, digits=2, **keys)
    # the second stage is used by nobody, and the second value is zero
    yield "decimals without a use", doc(
        "glm", {"consistent": True, "preconsistent": True, "g-symplectic": True}, digits=1,
        A=[["1/2", "0"], ["0", "0"]], U=[["1", "0"], ["1", "0.5"]], B=[["1", "0"], ["0", "0"]],
        V=[["1", "0"], ["0", "0"]],
    )  # fmt: skip
    yield "inconsistent, U in decimals", doc("glm", {"consistent": True}, digits=3, A=[["0"]],
                                             U=[["1.000"]], B=[["1/2"]], V=one)  # fmt: skip


def _pairs() -> Iterator[tuple[str, dict[str, Any]]]:
    """Pairs of which one half decides, or leaves open."""
    # U u = 1 at the first stage, and nearly so at the second, which is used by nobody
    idle = {**_one_value([[1, 0], [0, 0]], [1, 0]), "U": [["1"], ["1.000"]]}
    claims = {"order": 1, "nystrom-order": 1, "consistent": True, "stage-order": 1}
    for separable in (False, True):
        yield f"order of a pair in balls, separable {separable}", doc(
            "partitioned", claims, digits=3, separable=separable, q=idle,
            p=_one_value([[0, 0], [0, 0]], [1, 0]),
        )  # fmt: skip
    # V and V^ with different eigenvalues on the circle, and with decimals in one of them
    turning = {"A": [["0"]], "U": texts([[1, 1, 0, 0]]), "B": texts([[1], [1], [0], [0]]),
               "V": texts([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, "3/5", "-4/5"],
                           [0, 0, "4/5", "3/5"]])}  # fmt: skip
    weak = {"A": [["0"]], "U": texts([[1, 1, 0]]), "B": texts([[1], [0], [0]])}
    for name, last in (("exact", "1/2"), ("decimal", "0.5")):
        for separable in (True, False):
            V = [["1", "0", "0"], ["0", "-1", "0"], ["0", "0", last]]
            yield f"eigenvalues of one half, {name}, separable {separable}", doc(
                "partitioned", {"parasitism-free": True, "zero-stable": True}, digits=1,
                separable=separable, q=turning, p={**weak, "V": V},
            )  # fmt: skip
    still = {"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["0"]], "V": [["1", "0"], ["0", "-1"]]}
    leap = {**still, "U": [["1", "1"]], "B": [["1"], ["1"]]}
    for name, part, numbers in (("none", still, ["1", "0"]), ("some", leap, ["0", "0"]),
                                ("no number", still, ["0"])):  # fmt: skip
        yield f"growth of a pair, {name}", doc("partitioned", {"growth": numbers}, separable=True,
                                               q=part, p=part)  # fmt: skip
    half = {"A": [["0"]], "U": texts([[1, 1, 0]]), "B": texts([[1], [1], [0]]),
            "V": texts([[1, 0, 0], [0, -1, 0], [0, 0, -1]])}  # fmt: skip
    yield (
        "growth of a pair at a double eigenvalue",
        doc("partitioned", {"growth": ["-1", "0", "0", "0"] * 2}, separable=True, q=half, p=half),
    )
    # q' = M^-1 p: a weight in decimals, and stages that are the solution on trees without branches
    for name, q, p in (
        ("a weight in decimals", ([["3/8"]], ["1.000"]), ([["1/2"]], ["1"])),
        ("a stage off the solution", ([[0, 0], ["1/2", 0]], [0, 1]),
         ([["1/3", 0], ["1/6", "1/3"]], [0, 1])),
    ):  # fmt: skip
        yield f"second order, {name}", doc("partitioned", {"order": 1, "nystrom-order": 1}, digits=3,
            separable=True, q=_one_value(*q), p=_one_value(*p))  # fmt: skip
    # one half of a pair: V that may be singular, V that no L turns round
    midpoint = _one_value([["1/2"]], [1])
    for name, V in (
        ("that may be singular", ["0", "0.1-0.1"]),
        ("that is not turned round", ["0", "2"]),
    ):
        two = {"A": [["1/2"]], "U": [["1", "0"]], "B": [["1"], ["1"]], "V": [["1", "0"], V]}
        for separable in (True, False):
            yield f"half with a V {name}, separable {separable}", doc(
                "partitioned", {"symmetric": True}, digits=1, separable=separable, q=midpoint, p=two
            )  # fmt: skip
    nothing = {"A": [["0"]], "U": [["2"]], "B": [["0"]], "V": [["1/2"]]}
    for name, keys in (("u alone", _one_value([[0]], [0])), ("nothing", nothing)):
        yield f"{name} is reached", doc("partitioned", {"reducible": False}, q=keys, p=keys)
    loose = {"A": [["0"]], "U": [["1", "-1"]], "B": [["-1"], ["0"]], "V": [["1", "0"], ["0", "1"]]}
    yield "u of one half is not determined", doc("partitioned", {"g-symplectic": True}, q=loose,
                                                 p=_one_value([[0]], [1]))  # fmt: skip
    perhaps = _one_value([["0.1-0.1"]], [1])
    yield "surely implicit in one half", doc("partitioned", {"explicit": True}, digits=1,
                                             q=_one_value([[1]], [1]), p=perhaps)  # fmt: skip


def _starts() -> Iterator[tuple[str, dict[str, Any]]]:
    """Starts along the flow, off it, and where the series that they must agree with is not unique."""
    one = [["1"]]
    kutta = _one_value([[0, 0, 0], ["1/2", 0, 0], [-1, 2, 0]], ["1/6", "2/3", "1/6"])
    bent = {"A": [["0", "0"], ["1", "0"]], "B": [["1", "-1"]], "u": ["1"], "order": 3}
    yield "start with another principal part", doc("glm", {"order": 3, "starting-order": 3},
                                                   **kutta, starting=bent)  # fmt: skip
    # 1 is a double eigenvalue of both halves: what the second value starts with is free
    double_one = {"A": [["0"]], "U": [["1", "0"]], "B": one * 2, "V": [["1", "0"], ["0", "1"]]}
    for b, u in (("0", "1"), ("5", "1"), ("0", "0")):
        start = {"A": [["0"]], "B": [["0"], [b]], "u": ["1", u], "order": 1}
        start |= {f"{x}_hat": start[x] for x in "ABu"}
        for separable in (False, True):
            yield f"start of a pair with a double one, {b}, {u}", doc(
                "partitioned", {"order": 1, "starting-order": 1, "nystrom-order": 1},
                separable=separable, q=double_one, p=double_one, starting=start,
            )  # fmt: skip
    euler = _one_value([[0]], [1])
    along = {"A": [["0"]], "B": [["1"]], "u": ["1"], "order": 1}
    both = along | {f"{x}_hat": along[x] for x in "ABu"}
    yield "start of a pair that goes ahead", doc("partitioned", {"order": 1, "starting-order": 1},
                                                 separable=True, q=euler, p=euler, starting=both)  # fmt: skip
    d = shipped("multistep-10")  # a stage of its start that nobody uses, of order 1
    d["claims"] = {"starting-order": d["claims"]["starting-order"]}
    for A, B in (("A", "B"), ("A_hat", "B_hat")):
        rows = d["starting"][A]
        d["starting"][A] = [*([*x, "0"] for x in rows), ["7", *["0"] * len(rows[0])]]
        d["starting"][B] = [[*x, "0"] for x in d["starting"][B]]
    yield "start with an idle stage", d
    # Verlet's method that carries h k of the last stage Q, too; the start makes it of order 2, p - 1
    slope = {"A": texts([[0], [1]]), "U": texts([[1, 0]] * 2), "B": texts([[1], [1]]),
             "V": texts([[1, 0], [0, 0]])}  # fmt: skip
    verlet = {**_one_value([["1/2", 0]], ["1/2", "1/2"]), "U": one}
    for b in ("1", "2"):
        start = {"A": [["-1/2"]], "B": [["0"]], "u": ["1"], "A_hat": [["0"]], "B_hat": [["0"], [b]],
                 "u_hat": ["1", "0"], "order": 2}  # fmt: skip
        yield f"start by one stage of order 1, {b}", doc(
            "partitioned", {"order": 2, "nystrom-order": 2, "starting-order": 2,
                            "nystrom-starting-order": 2},
            separable=True, q=verlet, p=slope, starting=start)  # fmt: skip
    yield "start of order 0", doc("glm", {"order": 1, "starting-order": 2}, A=[["0"]], U=one,
                                  B=[["1/2"]], V=one, starting={**along, "order": 2})  # fmt: skip
    for name in ("multistep-10", "quinlan-tremaine-14"):
        d = shipped(name)
        d.pop("starting", None)
        d["claims"] = {"starting-order": 1, "stage-order": 2, "order": d["claims"]["order"]}
        yield f"{name} without a start", d


def _rows() -> Iterator[tuple[str, dict[str, Any]]]:
    """What stands beside a tableau, right, wrong and in decimals."""
    for name in ("bogacki-shampine-3-2", "ros2", "bettis-rkn-5-4"):
        yield name, shipped(name)
    for where, text in (
        (("c", 1), "1/3"), (("c", 1), "0.500"), (("dense", 0, 1), "1"), (("dense", 0, 0), "1.000"),
        (("dense", 0, 2), "14/9"), (("embedded", 0, "b", 0), "1/4"), (("b", 0), "0.222"),
        (("embedded", 0, "b", 1), "0.250"), (("claims", "embedded-order"), {"embedded": 1}),
        (("claims", "embedded-order"), {"embedded": 3}), (("claims", "embedded-order"), {"other": 2}),
        (("claims", "dense-order"), 2), (("claims", "dense-order"), 4), (("claims", "order"), 2),
    ):  # fmt: skip
        d = shipped("bogacki-shampine-3-2")
        d["digits"] = 3
        place: Any = d
        for key in where[:-1]:
            place = place[key]
        place[where[-1]] = text
        yield f"row with {text} at {where}", d
    d = shipped("bogacki-shampine-3-2")  # two rows, the second in decimals
    d["digits"], d["claims"] = 3, {"embedded-order": {"embedded": 2, "first": 1}}
    d["embedded"] = [*d["embedded"], {"name": "first", "b": ["1.000", "0", "0", "0"]}]
    yield "two rows", d
    for key in ("c", "dense", "embedded"):
        d = shipped("bogacki-shampine-3-2")
        del d[key]
        yield f"row without {key}", d


def _one_value(A: Any, b: Any) -> dict[str, Any]:
    return {"A": texts(A), "U": texts([[1]] * len(A)), "B": texts([b]), "V": texts([[1]])}


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


def _undecided_at_order_1() -> Iterator[tuple[str, dict[str, Any]]]:
    """Starts and a finish that digits leave open at order 1, and that are right at order 2."""
    claims = {"order": 2, "starting-order": 2}
    middle = doc("glm", claims, A=texts([[0, 0], ["1/2", 0]]), U=texts([[1, 0], [1, 0]]),
                 B=texts([[0, 1], [0, 0]]), V=texts([[1, 0], [0, 0]]), digits=2)  # fmt: skip
    right = {"A": [["0"]], "B": [["0"], ["0"]], "u": ["1", "0"], "order": 2}
    yield "start of order 2", {**middle, "starting": right}
    for name, more in (("B", {"B": [["0"], ["0.01-0.01"]]}), ("u", {"u": ["1", "0.01-0.01"]})):
        yield f"start open at order 1 by {name}", {**middle, "starting": {**right, **more}}
    claims = {"order": 2, "finishing-order": 2}
    finish = {"A": [["0"]], "b": ["0.01-0.01"], "order": 2}
    yield (
        "finish open at order 1",
        {**middle, "claims": claims, "starting": right, "finishing": finish},
    )


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
