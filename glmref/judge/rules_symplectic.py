"""Rules for quadratic forms (section 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import NamedTuple

from .arithmetic import Fraction, Number
from .document import Method
from .linalg import (
    apply,
    combine,
    dot,
    entries,
    minus,
    placewise,
    solve,
    star,
    times,
    transpose,
)
from .numbers import apart, conj, vanishes
from .refusals import require, shown
from .rule import Case, Flag, NoWitness, Rule

FORMS = "Butcher, Hewitt, The existence of symplectic general linear methods (2009)"
QUADRATIC = "Lasagni (1988); Sanz-Serna (1988); Hairer, Lubich, Wanner (2006), section VI.4"


class Defects(NamedTuple):
    """Left minus right side of the identities of a form: lists of matrices."""

    kept: list  # G = V^* G V
    outside: list  # D U = B^* G V
    inside: list  # D A + A^* D = B^* G B
    real: list  # D = D^*
    alike: list  # G = G^*; of pairs that are not separable D_P = D_Q

    @property
    def all(self) -> list:
        """Return the entries of all."""
        return [x for matrices in self for x in entries(matrices)]


def form_defects(
    method: Method, G: list, D: tuple[list, ...], star_: Callable[[list], list] = star
) -> Defects:
    """Return the defects of the form G with the diagonal D, for pairs (D_P, D_Q).

    One method is a pair of itself.
    """
    parts = list(method.parts.values())
    q, p, both = parts[0], parts[-1], [[*D[0], *D[-1]]]
    require([len(D[0]), len(D[-1])] == [len(p.U), len(q.U)], "a D has not one entry for each stage")

    def rows_times(d: list, M: list) -> list:
        return transpose([placewise(len(d), [d, column]) for column in transpose(M)])

    inside = [placewise(len(row), [row, D[-1]]) for row in star_(q.A)]  # A^* D
    alike = [] if method.separable else [minus([D[0]], [D[-1]])]
    return Defects(
        [minus(G, times(star_(q.V), G, p.V))],
        [
            minus(rows_times(D[0], p.U), times(star_(q.B), G, p.V)),
            minus(rows_times(D[-1], q.U), times(star_(p.B), star_(G), q.V)),
        ][: len(parts)],
        [minus(combine(rows_times(D[0], p.A), inside), times(star_(q.B), G, p.B))],
        [minus(both, star_(transpose(both)))],
        alike if method.pair else [minus(G, star_(G))],
    )


class Given(NamedTuple):
    """All that the file gives of a form; what it does not give is missing."""

    G: list | None
    D: dict[str, list]


def given(method: Method) -> Given:
    """Return what the file gives of a form."""
    names = () if method.kind == "pair-sweep" else names_of_D(method)
    G = method.form() if "G" in method.document else None
    return Given(G, {name: method.list(name) for name in names if name in method.document})


def names_of_D(method: Method) -> tuple[str, ...]:
    """Return the keys of D."""
    return ("D_P", "D_Q") if method.pair else ("D",)


class FormCase(Case):
    """A part about forms: what the file gives, u^* G u."""

    @cached_property
    def given(self) -> Given:
        """Return what the file gives of a form."""
        return given(self.method)

    def energy(self, G: list) -> Number:
        """Return u^* G u, for pairs u^* G u^."""
        first, last = next(iter(self.method.parts)), list(self.method.parts)[-1]
        return dot([conj(x) for x in self.method.u(first)], apply(G, self.method.u(last)))


@dataclass(frozen=True)
class Form:
    """G, and D of one method, D_P and D_Q of a pair."""

    G: list
    D: list | None = None
    D_P: list | None = None
    D_Q: list | None = None


class WitnessCase(FormCase):
    """A part about the form of a witness."""

    witness: Form

    @cached_property
    def G(self) -> list:
        """Return G."""
        return self.method.numbers.matrix(self.witness.G)

    @cached_property
    def D(self) -> dict[str, list]:
        """Return D, of pairs D_P and D_Q."""
        own = {name: x for name, x in vars(self.witness).items() if name != "G" and x is not None}
        require(set(own) == set(names_of_D(self.method)), "the witness has another D")
        return {name: self.method.numbers.vector(own[name]) for name in names_of_D(self.method)}

    @cached_property
    def defects(self) -> Defects:
        """Return the defects of the form."""
        return form_defects(self.method, self.G, tuple(self.D.values()))


def G_is_that_of_the_file(case: WitnessCase) -> bool:
    """G is that of the file, where it gives one."""
    return case.given.G is None or vanishes(minus(case.G, case.given.G))


def D_is_that_of_the_file(case: WitnessCase) -> bool:
    """Each D is that of the file, where it gives it."""
    return all(vanishes(minus([case.D[name]], [own])) for name, own in case.given.D.items())


def V_keeps_G(case: WitnessCase) -> bool:
    """V^* G V = G, of pairs V^* G V^ = G."""
    return vanishes(case.defects.kept)


def D_fits_U(case: WitnessCase) -> bool:
    """D U = B^* G V, of pairs D_P U^ = B^* G V^ and D_Q U = B^^* G^* V."""
    return vanishes(case.defects.outside)


def D_fits_A(case: WitnessCase) -> bool:
    """D A + A^* D = B^* G B, of pairs D_P A^ + A^* D_Q = B^* G B^."""
    return vanishes(case.defects.inside)


def D_is_real(case: WitnessCase) -> bool:
    """D is real."""
    return vanishes(case.defects.real)


def G_is_hermitian_or_D_shared(case: WitnessCase) -> bool:
    """G = G^*; of a pair that is not separable D_P = D_Q."""
    return vanishes(case.defects.alike)


def form_is_not_0_at_u(case: WitnessCase) -> bool:
    """u^* G u is not 0."""
    return apart(case.energy(case.G))


class GivenCase(FormCase):
    """A part that refutes the form of the file."""

    @property
    def G(self) -> list:
        """Return G of the file."""
        return shown(self.given.G, "the file gives no G")

    @cached_property
    def D(self) -> tuple[list, ...]:
        """Return D of the file; what is missing is B^* G u, by D U = B^* G V times u."""
        G, own = self.G, self.given.D
        m, last = self.method.parts, list(self.method.parts)[-1]
        first, *second = names_of_D(self.method)
        q = next(iter(m.values()))
        found = [own.get(first) or apply(star(q.B), apply(G, self.method.u(last)))]
        for name in second:
            value = own.get(name)
            found.append(value or apply(star(m["k"].B), apply(star(G), self.method.u("f"))))
        return tuple(found)


def file_gives_G(case: GivenCase) -> bool:
    """The file gives G."""
    return case.given.G is not None


def given_form_is_none(case: GivenCase) -> bool:
    """With G and D of the file an identity does not hold, or u^* G u is 0."""
    if any(map(apart, form_defects(case.method, case.G, case.D).all)):
        return True
    return vanishes(case.energy(case.G))


class NoFormCase(FormCase):
    """A part about all forms of a method."""


def file_gives_no_G(case: NoFormCase) -> bool:
    """The file gives no G."""
    return case.given.G is None


def method_is_real(case: Case) -> bool:
    """The method is real: of complex methods this is not covered."""
    return all(conj(x) == x for x in entries(M for m in case.method.parts.values() for M in m))


def form_at_u_follows_from_the_identities(case: NoFormCase) -> bool:
    """u^* G u is a linear combination of the identities for symmetric G and real D."""
    units = list(unit_forms(case.method))
    rows = [form_defects(case.method, *x).all for x in units]
    combination, _ = solve(rows, [case.energy(G) for G, _ in units])
    return combination is not None


def unit_forms(method: Method) -> Iterator[tuple[list, tuple[list, ...]]]:
    """Yield (G, D) through a basis: each G with D = 0, then each D with G = 0."""
    m, other = next(iter(method.parts.values())), list(method.parts.values())[-1]
    slopes = [len(x.B[0]) for x in method.parts.values()]
    for places in unit_matrices(m.r, other.r, not method.pair):
        yield filled(m.r, other.r, places), tuple(filled(1, n, ())[0] for n in slopes)
    shared = method.pair and not method.separable
    for at in range(slopes[0] if shared else sum(slopes)):
        (flat,) = filled(1, sum(slopes), [(0, at), (0, at + slopes[0] if shared else at)])
        D = (flat[: slopes[0]], flat[slopes[0] :]) if method.pair else (flat,)
        yield filled(m.r, other.r, ()), D


def unit_matrices(rows: int, columns: int, symmetric: bool) -> list[list[tuple[int, int]]]:
    """Return the places of the ones of each matrix of a basis, or of the symmetric ones."""
    return [[(i, j), (j, i) if symmetric else (i, j)]
            for i, j in product(range(rows), range(columns))
            if i <= j or not symmetric]  # fmt: skip


def filled(rows: int, columns: int, places: Sequence[tuple[int, int]]) -> list:
    """Return the matrix with ones at these places."""
    return [[Fraction(int((i, j) in places)) for j in range(columns)] for i in range(rows)]


@dataclass(frozen=True)
class Several:
    """Whether the reason is that a component carries several values."""

    several_values: Flag = field(default=False, metadata={"key": "several-values"})


class QuadraticCase(Case):
    """A part about the form G = 1, D = b of methods that carry one value."""

    witness: Several

    @cached_property
    def several(self) -> bool:
        """Tell whether a component carries several values."""
        return any(m.r > 1 for m in self.method.parts.values())

    @cached_property
    def defects(self) -> list:
        """Return the defects, with transposes for conjugate transposes."""
        D = tuple(m.B[0] for m in self.method.parts.values())
        return self.proof.of_method(
            ("quadratic",), lambda: form_defects(self.method, [[Fraction(1)]], D, transpose).all
        )


def the_solution_is_carried(case: QuadraticCase) -> bool:
    """Each component carries one value with U = 1 and V = 1."""
    parts = case.method.parts.values()
    return all(m.r == 1 and m.V == [[1]] and m.U == [[1]] * len(m.U) for m in parts)


def products_of_weights_are_met(case: QuadraticCase) -> bool:
    """b_i a_ij + b_j a_ji = b_i b_j; of pairs b_i a^_ij + b^_j a_ji = b_i b^_j.

    Where the pair is not separable b = b^ too.
    """
    return vanishes(case.defects)


def several_values_are_carried(case: QuadraticCase) -> bool:
    """With `several-values` a component carries several values."""
    return case.several or not case.witness.several_values


def else_the_solution_is_carried(case: QuadraticCase) -> bool:
    """Else each component carries one value with U = 1 and V = 1."""
    return case.several or the_solution_is_carried(case)


def else_a_product_of_weights_is_not_met(case: QuadraticCase) -> bool:
    """Else an identity of `quadratic` does not hold."""
    return case.several or any(map(apart, case.defects))


FORM_RULES = (
    Rule(
        "form", "g-symplectic", "holds", "the definition", FORMS, Form, WitnessCase,
        (G_is_that_of_the_file, D_is_that_of_the_file, V_keeps_G, D_fits_U, D_fits_A, D_is_real,
         G_is_hermitian_or_D_shared, form_is_not_0_at_u),
    ),
    Rule(
        "given-form-fails", "g-symplectic", "fails",
        "the form is that of the file; a D that it does not give can only be B^* G u",
        FORMS, NoWitness, GivenCase, (file_gives_G, given_form_is_none),
    ),
    Rule(
        "no-form", "g-symplectic", "fails",
        "a form of a real method has a real part, which is one; where u^* G u is a combination of "
        "the identities it is 0 for every form",
        FORMS, NoWitness, NoFormCase,
        (file_gives_no_G, method_is_real, form_at_u_follows_from_the_identities),
    ),
    Rule(
        "quadratic", "symplectic", "holds", "the definition", QUADRATIC, NoWitness, QuadraticCase,
        (the_solution_is_carried, products_of_weights_are_met),
    ),
    Rule(
        "not-quadratic", "symplectic", "fails", "the definition", QUADRATIC, Several, QuadraticCase,
        (several_values_are_carried, else_the_solution_is_carried,
         else_a_product_of_weights_is_not_met),
    ),
)  # fmt: skip
