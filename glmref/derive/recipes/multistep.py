"""Explicit symmetric partitioned multistep methods, one or two forces a step: the shipped ones.

Option: ``name`` one shipped method (all of them by default); or ``q`` and ``p``, cosines of the
pairs of roots of the two halves, fractions separated by blanks (``q`` empty: for second-order
systems). With ``slopes``, a number for each cosine of ``p``, and ``weight``, a step has two kicks:
how its first drift reads each pair, and the weight of the first kick in the sum. With
``constants``, for second-order systems with one kick, the error begins with C x^{2 m}, or with C'
x^{2 m - 2} where there are two, instead of x^{2 m + 2}, m the number of cosines.

The shipped numbers were found by `campaigns.partitioned.multistep_search` and `two_kicks_search`
of commit b3e1529d; everything else follows from them exactly (:mod:`glmref.derive.multistep`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ...errors import UsageError
from ...findings import Proof
from ..multistep import TwoKicks, multistep_document, two_kick_document
from .derivation import Derivation, Progress, Statement, chosen, complete_exactly, completed
from .sources import derived_source, long_notes

OPTIONS: Mapping[str, str] = dict.fromkeys(("name", "q", "p", "slopes", "weight", "constants"), "")

_LISTS = ("q", "p", "slopes", "constants")


@dataclass(frozen=True)
class Shipped:
    """Cosines of the two halves, and notes for the file.

    With two kicks a step also the slopes of the first drift, and the weight of the first kick.
    """

    q: Sequence[Fraction]
    p: Sequence[Fraction]
    notes: Sequence[str] = ()
    slopes: Sequence[Fraction] = ()
    weight: Fraction = Fraction(0)
    constants: Sequence[Fraction] = ()

    @property
    def order(self) -> int:
        """The order p."""
        return 2 * (len(self.p) + 1 - len(self.constants))

    def document(self, name: str) -> dict[str, Any]:
        """Return the document without claims and source."""
        title = title_of(self.order, second=not self.q, forces=2 if self.slopes else 1)
        if not self.slopes:
            constants = self.constants
            return multistep_document(name, self.q, self.p, title=title, constants=constants)
        if self.q or self.constants:
            raise UsageError(
                "methods with two kicks are for second-order systems: no `q`, and no `constants`"
            )
        return two_kick_document(name, TwoKicks(self.p, self.slopes, self.weight), title=title)


def _over(whole: int, *numbers: int) -> list[Fraction]:
    return [Fraction(x, whole) for x in numbers]


#: Labels that `campaigns/partitioned/test_multistep.py` compares with the data they name.
_BOUNDED = (
    "Over ten million steps from its starting method its energy error stays bounded, which here is "
    "less than tenfold over the last two decades, on seven orbits of five problems, see "
    "data/measurements/multistep-long.json."
)
_GROWS = (
    "Over ten million steps from its starting method its energy error or its carried values grow "
    "on {}, see data/measurements/multistep-long.json."
)

SHIPPED: Mapping[str, Shipped] = {
    "multistep-8": Shipped(_over(256, 168, 7, -186), _over(256, 99, -102, -241), notes=(_BOUNDED,)),
    "multistep-10": Shipped(
        _over(256, 210, 195, 4, -79),
        _over(256, 172, 39, 84, -163),
        notes=(_GROWS.format("henon-heiles and toda"),),
    ),
    "multistep-rkn-8": Shipped((), _over(256, 20, -71, -224), notes=(_BOUNDED,)),
    "multistep-rkn-10": Shipped(
        (), _over(256, -227, -135, 23, 102), notes=(_GROWS.format("toda and outer-solar-system"),)
    ),
    "multistep-rkn-12": Shipped(
        (), _over(256, 102, 146, 53, -96, -232), notes=(_GROWS.format("toda and kepler at 1/10"),)
    ),
    "multivalue-rkn-10": Shipped(
        (),
        _over(2048, 1156, -935, -1116, -2003),
        notes=(_GROWS.format("kepler at 1/10 and kepler at 3/10"),),
        slopes=_over(2048, 5757, 4153, -367, 1589),
        weight=Fraction(1038, 2048),
    ),
    "multivalue-rkn-12": Shipped(
        (),
        _over(2048, 1267, -569, -1398, -1525, -1874),
        notes=(_GROWS.format("henon-heiles, toda and kepler at 1/10"),),
        slopes=_over(2048, 6024, -457, 423, 3504, 1251),
        weight=Fraction(1002, 2048),
    ),
}


#: What is claimed of a symmetric multistep method besides its orders.
CLAIMS: Mapping[str, Any] = {
    "preconsistent": True,
    "consistent": True,
    "zero-stable": True,
    "explicit": True,
    "g-symplectic": False,
    "symmetric": True,
    "parasitism-free": True,
    "reducible": False,
}


def title_of(order: int, *, second: bool, forces: int = 1) -> str:
    """Return one line for the file."""
    systems = "second-order" if second else "separable"
    kind = "multistep" if forces == 1 else "multivalue"
    many = "one force evaluation" if forces == 1 else "two force evaluations"
    return (
        f"Explicit symmetric partitioned {kind} method of order {order} with {many}, for "
        f"{systems} systems"
    )


def claims_of(order: int, *, second: bool) -> dict[str, Any]:
    """Return what the construction promises; :func:`derive` proves it."""
    orders = (
        {
            "order": 2,
            "order-identity": 2,
            "nystrom-order": order,
            "starting-order": 2,
            "nystrom-starting-order": order,
        }
        if second
        else {"order": order, "order-identity": order, "starting-order": order}
    )
    return {**orders, **CLAIMS}


def _complete(
    name: str, numbers: Shipped, where: str
) -> tuple[dict[str, Any], Sequence[Statement]]:
    """Build a document and prove its claims.

    Raises
    ------
    ExactnessError
        When a claim is not proved.
    """
    second, order = not numbers.q, numbers.order
    document = numbers.document(name)
    source = derived_source(where, "multistep", "docs/multivalue.md")
    notes = [*numbers.notes, *long_notes(name)]
    complete_exactly(document, claims_of(order, second=second), source, notes)
    systems = "second-order" if second else "separable"
    text = (
        f"{name}: order {order} on {systems} systems, start of the same order, symmetric, "
        f"parasitism-free"
    )
    return document, [Statement(text, Proof.EXACT)]


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Build and prove the shipped methods, or the one with given cosines.

    Raises
    ------
    UsageError
        For a name that is not shipped, or cosines that cannot be read.
    """
    if options["p"]:
        try:
            given = {key: [Fraction(x) for x in options[key].split()] for key in _LISTS}
            weight = Fraction(options["weight"] or 0)
        except (ValueError, ZeroDivisionError) as error:
            raise UsageError(
                "`q`, `p`, `slopes` and `constants` must be fractions with blanks between, and "
                f"`weight` one ({error})"
            ) from None
        q, p, slopes, constants = (given[key] for key in _LISTS)
        numbers = Shipped(q, p, slopes=slopes, weight=weight, constants=constants)
        kind = "multivalue" if numbers.slopes else "multistep"
        name = f"{kind}-{'' if numbers.q else 'rkn-'}{numbers.order}-found"
        where = f"cosines {options['q']}; {options['p']}"
        if numbers.slopes:
            where += f"; slopes {options['slopes']}, weight {weight}"
        if numbers.constants:
            where += f"; error constants {options['constants']}"
        return completed("multistep", {name: numbers}, _complete, progress, where)
    if any(options[key] for key in OPTIONS if key not in ("name", "p")):
        raise UsageError(
            "`q`, `slopes`, `weight` and `constants` are of a method with given cosines: give `p`"
        )
    return completed("multistep", chosen(options["name"], SHIPPED), _complete, progress)
