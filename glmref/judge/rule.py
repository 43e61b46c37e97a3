"""What a rule is: a theorem, its hypotheses, its conclusion; the one place where rules refuse."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeAlias, TypeVar, cast

from .arithmetic import Number
from .refusals import SIZE, Document, NotShown, as_list, as_object, as_text, keys, shown, whole
from .trees import Tree, read_tree, show

if TYPE_CHECKING:
    from .document import Method
    from .proof import Proof


W = TypeVar("W")
C = TypeVar("C", bound="Case")


@dataclass(frozen=True)
class Fails:
    """A hypothesis does not hold, and the tree at which it does not; false as a truth value."""

    at: Tree

    def __bool__(self) -> bool:
        return False


@dataclass(frozen=True)
class Bound:
    """What is shown of an order: of the method, its stages, its start or its finish.

    Parameters
    ----------
    quantity : str
        ``"order"``, ``"stage-order"``, ``"start"`` or ``"finish"``.
    low, high : int or None
        The order is at least `low` and at most `high`, where shown.
    identity : bool
        Whether the principal part is the identity: the solution itself is carried.
    trees : bool or str
        Which trees count: False for all, True for Nystrom trees, else ``"paths"`` or
        ``"nystrom-paths"``, which stand for these.
    """

    quantity: str
    low: int | None = None
    high: int | None = None
    identity: bool = False
    trees: bool | str = False

    @property
    def kind(self) -> tuple[bool, bool | str]:
        """Return the principal part and the trees."""
        return self.identity, self.trees

    @property
    def enclosed(self) -> bool:
        """Tell whether both bounds are shown and agree."""
        return self.low is not None and self.low == self.high

    def meet(self, other: Bound) -> Bound:
        """Return both bounds; refuse those of another kind of order."""
        if self.kind != other.kind:
            raise NotShown(f"bounds of two kinds of {self.quantity}")
        low = self.low if other.low is None else other.low
        return replace(self, low=low, high=self.high if other.high is None else other.high)


@dataclass(frozen=True)
class Truth:
    """What is shown to be true or false of the method."""

    of: str
    holds: bool = True


@dataclass(frozen=True)
class RowOrder:
    """The order of the method with the weights of a row of `embedded`, between two bounds."""

    row: str
    low: int
    high: int  # 20, the largest order that a claim may name, where no bound is shown


@dataclass(frozen=True)
class Bounded:
    """The powers of V of a component are bounded."""

    colour: str


class Space(NamedTuple):
    """One eigenvalue of V: V N = zeta N and W V = zeta W with W N = I."""

    zeta: Number
    W: list
    N: list


@dataclass(frozen=True)
class Spectrum:
    """All eigenvalues of modulus 1 of V of a component; all are semisimple."""

    colour: str
    spaces: tuple[Space, ...]


@dataclass(frozen=True)
class Reversal:
    """The L by colour that exchange the values of a step with those of its reversal."""

    L: Mapping[str, list]


@dataclass(frozen=True)
class Replaced:
    """A method that makes the same steps, which the parts that follow are about."""

    method: Method


Conclusion = Bound | Truth | RowOrder | Bounded | Spectrum | Reversal | Replaced


Order: TypeAlias = int
Flag: TypeAlias = bool
#: What the members of witnesses are, and their readers, by the name of the type of the field.
READERS: dict[str, tuple[str, Callable[[object, str], object]]] = {
    "Order": ("no order", lambda value, why: whole(value)),
    "int": ("no number", lambda value, why: whole(value, -1, SIZE)),
    "Flag": ("not true", lambda value, why: shown(value is True or None, why)),
    "str": ("no text", as_text),
    "list": ("no list", as_list),
    "Tree": ("no tree", lambda value, why: read_tree(value)),
    "Document": ("no object", as_object),
}


@dataclass(frozen=True)
class NoWitness:
    """The witness of a part that needs none."""


def read_witness(kind: type[W], value: object, where: str = "witness") -> W:
    """Return a witness as a dataclass, each member read by the type of its field.

    A field without a default is needed. Its key is its name, or the `key` of its metadata.
    """
    named = {x.metadata.get("key", x.name): x for x in fields(cast("type[NoWitness]", kind))}
    needed = " ".join(key for key, x in named.items() if x.default is MISSING)
    keys(value, needed, " ".join(named), where)
    found = {}
    for key, member in as_object(value).items():
        what, read = READERS[str(named[key].type).partition(" ")[0]]
        found[named[key].name] = read(member, f"{key!r} of the {where} is {what}")
    return kind(**found)


class Case:
    """One part of a certificate while a rule is applied to it.

    Families of rules derive from it and add, as cached properties, the values that several of
    their hypotheses look at, so that each is computed once and by one function.

    Parameters
    ----------
    proof : Proof
        The certificate: its statement, its method, what other parts have shown.
    witness : dataclass
        The witness of the part; a family declares of which class it is.
    """

    witness: object

    def __init__(self, proof: Proof, witness: object) -> None:
        self.proof, self.witness, self.method = proof, witness, proof.method

    def shows(self, about: str, holds: bool) -> Conclusion:
        """Return what a rule about a claim shows that holds, or is a lower bound, or else."""
        return Truth(about, holds)

    @cached_property
    def claimed(self) -> list:
        """Return the numbers of the list that the claim declares."""
        return self.proof.claimed(self.proof.declared)

    def known(self, quantity: str) -> Bound:
        """Return the bounds that parts before this one have shown."""
        return self.proof.known.get(quantity, Bound(quantity))


class HypothesisFails(NotShown):
    """A hypothesis of a rule does not hold; the sentence is made when it is read."""

    def sentence(self) -> str:
        """Return the rule, where the hypothesis fails, and the hypothesis."""
        rule, hypothesis, outcome = self.args
        place = f" at tree {show(outcome.at)}" if isinstance(outcome, Fails) else ""
        return f"{rule} needs{place}: {sentence_of(hypothesis)}"


def sentence_of(hypothesis: Callable[..., object]) -> str:
    """Return the first sentence of the docstring of a hypothesis, on one line."""
    text = re.sub(r"\s+", " ", (hypothesis.__doc__ or hypothesis.__name__).strip())
    return text.partition(". ")[0].rstrip(".")


@dataclass(frozen=True)
class Rule(Generic[C]):
    """A theorem that a part of a certificate is an instance of.

    Parameters
    ----------
    name : str
        The name in certificates.
    about : str
        The claim, or the quantity, that the conclusion is about.
    direction : str
        ``"at least"``, ``"at most"``, ``"holds"`` or ``"fails"``.
    theorem : str
        What follows from the hypotheses.
    source : str
        Author, year and number of the theorem, or where it is proved.
    witness : type
        The dataclass of the witness.
    case : callable
        Makes the case from the proof and the witness.
    hypotheses : tuple of callable
        Functions of the case that return True, False or `Fails`. The docstring of each is the
        sentence that must hold.
    conclusion : callable
        Returns what is shown when all hypotheses hold; else :meth:`Case.shows` does.
    """

    name: str
    about: str
    direction: str
    theorem: str
    source: str
    witness: type
    case: Callable[[Proof, object], C]
    hypotheses: tuple[Callable[[C], bool | Fails], ...]
    conclusion: Callable[[C], Conclusion] | None = None

    def apply(self, proof: Proof, witness: Document) -> Conclusion:
        """Return what a part shows, or refuse with the first hypothesis that fails."""
        case = self.case(proof, read_witness(self.witness, witness))
        for hypothesis in self.hypotheses:
            outcome = hypothesis(case)
            if not outcome:
                raise HypothesisFails(self.name, hypothesis, outcome)
        if self.conclusion is None:
            return case.shows(self.about, self.direction in ("holds", "at least"))
        return self.conclusion(case)


def either_way(
    names: str, about: str, theorem: str, source: str, case: Callable[[Proof, object], C],
    holds: tuple[Callable[[C], bool | Fails], ...], fails: tuple[Callable[[C], bool | Fails], ...],
) -> tuple[Rule, Rule]:  # fmt: skip
    """Return the rule that a claim holds and the one that it fails; none needs a witness."""
    first, second = names.split()
    return (Rule(first, about, "holds", theorem, source, NoWitness, case, holds),
            Rule(second, about, "fails", theorem, source, NoWitness, case, fails))  # fmt: skip
