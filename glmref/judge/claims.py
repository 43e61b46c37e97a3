"""Tables of classes and claims: their keys, and which parts prove which statement (1, 7)."""

from __future__ import annotations

from collections.abc import Mapping

COMMON = "$schema format name title class field broken notes digits constants claims source"

CLASSES = {  # needed keys, optional keys
    "glm": ("A U B V", "G D output starting finishing embedded"),
    "rk": ("A b", "starting finishing c embedded dense unknowns enclosure"),
    "lmm": ("alpha beta", "starting finishing"),
    "one-leg": ("alpha beta", "G starting finishing"),
    "sweep": ("D X V G", "unknowns enclosure starting finishing"),
    "composition": ("base gamma", "starting finishing"),
    "splitting": ("first a b", "unknowns enclosure starting"),
    "additive": ("parts", "embedded"),
    "nystrom": ("A b b_prime c", "A_prime embedded"),
    "rosenbrock": ("alpha gamma b", "embedded unknowns enclosure"),
    "partitioned-rk": ("A b A_hat b_hat", "starting separable"),
    "partitioned": ("q p", "G D_P D_Q separable starting"),
    "pair-sweep": ("stages b c V V_hat G", "w v unknowns enclosure starting"),
}

PAIRS = {"splitting", "partitioned-rk", "partitioned", "pair-sweep", "nystrom"}

FORMATS = ("glmref-method-1", "glmref-method-2")

SECOND_FORMAT = {"embedded", "c", "dense", "nystrom", "rosenbrock"}  # keys and classes

ORDERS = ("order", "order-identity", "effective-order", "nystrom-order", "w-order")

PROVES = {
    "preconsistent": ("preconsistent", "not-preconsistent"),
    "consistent": ("consistent", "no-order-1"),
    "symplectic": ("quadratic", "not-quadratic"),
    "g-symplectic": (
        "preconsistent form|form",
        ("given-form-fails|not-preconsistent|preconsistent no-form|no-form|"
         "preconsistent given-form-fails")),
    "conjugate-symplectic": ("quadratic conjugate|form conjugate", "conjugate-symplectic-at-most"),
    "symmetric": ("symmetric", "not-symmetric"),
    "symmetric-reduced": ("equivalent irreducible symmetric",
                          "equivalent irreducible not-symmetric"),
    "explicit": ("explicit", "implicit"),
    "reducible": ("reducible", "irreducible"),
    "zero-stable": ("bounded*", "unbounded"),
    "a-stable": ("bounded a-stable", "unbounded not-a-stable|not-a-stable"),
    "l-stable": ("bounded a-stable l-limit", "not-l-limit|unbounded not-a-stable|not-a-stable"),
    "parasitism-free": ("residues|bounded* unshared|eigen* growth",
                        "unbounded|residues|eigen* grows"),
    "growth": ("residues|bounded* unshared|eigen* growth",
               "unbounded|residues|bounded* unshared|eigen* grows"),
    "second-order-growth": ("eigen* second-order", "eigen* other-second-order"),
    "abscissae": ("abscissae", "other-abscissae|no-order-1"),
    "error-constant": ("error-constant", "other-error-constant"),
    "embedded-difference": ("differences", "no-differences"),
    "row-sums": ("row-sums", "no-row-sums"),
    "dense-end": ("dense-end", "no-dense-end"),
    "dense-order": ("dense|not-dense", "dense|not-dense"),
    "embedded-order": ("row+", "row+|row"),
    "order-to-digits": ("to-digits", "not-to-digits"),
}  # fmt: skip


def alternatives(claim: str, truth: bool, often: Mapping[str, int], more: str = "") -> list[list]:
    """Return the lists of rules each of which proves a claim true or false, with `more` of them.

    A rule whose name ends in a key of `often` stands so many times in a row.
    """
    texts = PROVES.get(claim, ("", ""))[not truth] + more
    return [[x.rstrip("*+") for x in text.split() for _ in range(often.get(x[-1], 1))]
            for text in texts.split("|") if text]  # fmt: skip


MODIFIED = {  # orders of the underlying one-step method, on systems y' = f(y)
    "hamiltonian-to-order": "hamiltonian", "energy-order": "energy",
    "conjugate-symplectic-order": "conjugate-symplectic",
}  # fmt: skip

SECOND = {"stage-order": "stage-order", "starting-order": "start",
          "nystrom-starting-order": "start", "finishing-order": "finish", **MODIFIED}  # fmt: skip

VALUES = (
    "growth",
    "second-order-growth",
    "abscissae",
    "error-constant",
    "embedded-order",
    "order-to-digits",
)

ABSENT = {  # claim: key of the document that it is about, the value where there is none
    "embedded-order": ("embedded", {}), "embedded-difference": ("embedded", False),
    "row-sums": ("c", True), "dense-end": ("dense", False), "dense-order": ("dense", 0),
    "starting-order": ("starting", 0), "finishing-order": ("finishing", 0),
}  # fmt: skip

ADDITIVE = {  # claims of methods for a sum of right-hand sides
    "order", "order-identity", "effective-order", "stage-order", "preconsistent", "consistent",
    "zero-stable", "explicit", "embedded-order", "embedded-difference", "order-to-digits",
    "abscissae",
}  # fmt: skip

OF_PAIRS = {"nystrom-order", "nystrom-starting-order", "reducible"}

OF_ONE_METHOD = {"a-stable", "l-stable", "abscissae", "error-constant", "symmetric-reduced",
                 "conjugate-symplectic", "second-order-growth", "finishing-order", "dense-order",
                 "dense-end", "row-sums", *MODIFIED}  # fmt: skip

ROSENBROCK = {"order", "w-order", "a-stable", "l-stable", "embedded-order", "embedded-difference",
              "order-to-digits"}  # fmt: skip

LOOKS_AT = {  # rules, and keys of witnesses, that look at exact zeros or at these matrices only
    "explicit": "", "absent": "", "several-values": "", "bounded": "V", "unbounded": "V",
    "singular": "V", "unshared": "V",
    "preconsistent": "UV", "not-preconsistent": "UV", "consistent": "UBV",
}  # fmt: skip


#: Claims about decimals that the rules for exact numbers decide too, with intervals for numbers.
AS_EXACT = {
    "preconsistent", "consistent", "zero-stable", "symplectic", "g-symplectic", "symmetric",
    "parasitism-free", "growth", "abscissae", "embedded-difference", "row-sums", "dense-end",
    "dense-order", "error-constant", "explicit", "reducible", "embedded-order",
}  # fmt: skip


def lacks_block(claim: str, kind: str) -> bool:
    """Tell whether a claim is about a key that files of a class cannot have.

    A pair without a start begins with (y0, 0, ..), so that its start has an order.
    """
    starts = claim == "starting-order" and kind in PAIRS
    keys = " ".join(CLASSES[kind]).split()
    return claim in ABSENT and not starts and ABSENT[claim][0] not in keys


def concerns(claim: str, kind: str) -> bool:
    """Tell whether a claim is about methods such as those of a class."""
    if kind == "rosenbrock":
        return claim in ROSENBROCK
    if kind == "additive":
        return claim in ADDITIVE
    of_others = OF_ONE_METHOD if kind in PAIRS else OF_PAIRS
    return claim != "w-order" and (
        claim not in of_others or (claim, kind) == ("row-sums", "nystrom")
    )
