"""Rules for powers of V and growth parameters (section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from .arithmetic import Fraction, Number
from .document import Component
from .linalg import (
    blocks_of,
    characteristic,
    diagonal,
    inverse_matrix,
    is_exact,
    kernel,
    less,
    minus,
    rank,
    scale,
    times,
    transpose,
)
from .numbers import apart, conj, real, sign, squared, total, upper, vanishes
from .polynomials import (
    divide,
    from_roots,
    horner,
    is_schur,
    is_unbounded,
)
from .refusals import whole
from .rule import Bounded, Case, NoWitness, Rule, Space, Spectrum

POWERS = "Gantmacher, The Theory of Matrices (1959), chapter 5; docs/certificates.md, section 5"
GROWTH = (
    "Butcher, Habib, Hill, Norton, The control of parasitism in G-symplectic methods (2014); "
    "docs/certificates.md, section 5"
)


@dataclass(frozen=True)
class Which:
    """The colour of a component."""

    which: str


@dataclass(frozen=True)
class WhichBlock(Which):
    """A component, and a diagonal block of its V by its number."""

    block: int | None = None


@dataclass(frozen=True)
class Eigenvalues(Which):
    """All eigenvalues of modulus 1 of V of a component."""

    zeta: list


@dataclass(frozen=True)
class Place:
    """The place of an eigenvalue among those of parasitic components, -1 for their number."""

    part: int


class PowersCase(Case):
    """A part about the powers of V of one component."""

    witness: Which

    @property
    def colour(self) -> str:
        """Return the colour of the component."""
        return self.witness.which

    @cached_property
    def V(self) -> list:
        """Return V of the component."""
        return self.method.part(self.colour).V

    @cached_property
    def on_the_circle(self) -> list:
        """Return V, or where it holds decimals the diagonal blocks that are not Schur."""
        if is_exact(self.V):
            return [self.V]
        return [block for block in blocks_of(self.V) if not is_schur(characteristic(block))]


class BlockCase(PowersCase):
    """A part about the powers of V, or of a diagonal block of it that the witness names."""

    witness: WhichBlock

    @cached_property
    def V(self) -> list:
        """Return V of the component, or the block."""
        V, block = self.method.part(self.colour).V, self.witness.block
        if block is None:
            return V
        blocks = blocks_of(V)
        return blocks[whole(block, 0, len(blocks) - 1)]


def one_block_is_on_the_circle(case: PowersCase) -> bool:
    """Of V with decimals all diagonal blocks but at most one have all eigenvalues inside."""
    return len(case.on_the_circle) < 2


def powers_are_bounded(case: PowersCase) -> bool:
    """No eigenvalue of V, or of that block, is outside the circle, or defective on it."""
    return not any(map(is_unbounded, case.on_the_circle))


def powers_are_not_bounded(case: PowersCase) -> bool:
    """An eigenvalue of V, or of the block, is outside the circle, or defective on it."""
    return is_unbounded(case.V)


# ---------------------------------------------------------------------------- eigenvalues


class SpectrumCase(PowersCase):
    """A part about all eigenvalues of modulus 1 of one V."""

    witness: Eigenvalues

    @cached_property
    def zeta(self) -> list:
        """Return the numbers of the witness."""
        return [self.method.numbers.number(x) for x in self.witness.zeta]

    @cached_property
    def vectors(self) -> list:
        """Return for each number the basis of N with V N = zeta N."""
        return [kernel(minus(self.V, diagonal([z] * len(self.V)))) for z in self.zeta]

    @property
    def rest(self) -> list:
        """Return det(x I - V) divided by x - zeta, once for each vector."""
        h = characteristic(self.V)
        for z, N in zip(self.zeta, self.vectors, strict=True):
            for _ in N:
                h, _ = divide(h, [-z, Fraction(1)])
        return h

    def spectrum(self) -> Spectrum:
        """Return the eigenvalues with their eigenvectors."""
        return Spectrum(self.colour, tuple(space_of(self.V, z) for z in self.zeta))


def space_of(V: list, zeta: Number) -> Space:
    """Return an eigenvalue of V with N and W, V N = zeta N, W V = zeta W and W N = I."""
    shift = minus(V, diagonal([zeta] * len(V)))
    N, W = transpose(kernel(shift)), kernel(transpose(shift))
    return Space(zeta, times(inverse_matrix(times(W, N)), W), N)


def growth_matrix(x: Space, m: Component, other: Component, y: Space) -> list:
    """Return (1 / zeta) W B U N: how components of a value feed those of another, or its own."""
    return scale(conj(x.zeta), times(x.W, m.B, other.U, y.N))


def V_is_exact(case: SpectrumCase) -> bool:
    """V holds no decimals."""
    return is_exact(case.V)


def eigenvalues_have_modulus_1(case: SpectrumCase) -> bool:
    """Every zeta has the modulus 1."""
    return all(squared(z) == 1 for z in case.zeta)


def half_turn(z: Number) -> int:
    """Return 0 for arguments in [0, pi), 1 for [pi, 2 pi)."""
    if conj(z) == z:
        return 0 if sign(z) > 0 else 1
    return 0 if upper(z) else 1


def comes_before(y: Number, z: Number) -> bool:
    """Tell whether arg y < arg z in [0, 2 pi), for numbers of modulus 1."""
    if half_turn(y) != half_turn(z):
        return half_turn(y) < half_turn(z)
    order = sign(real(y) - real(z))
    return order > 0 if half_turn(y) == 0 else order < 0


def arguments_increase(case: SpectrumCase) -> bool:
    """The zeta stand in the order of increasing argument in [0, 2 pi), each once."""
    return all(comes_before(y, z) for y, z in pairwise(case.zeta))


def all_are_eigenvalues(case: SpectrumCase) -> bool:
    """Every zeta is an eigenvalue of V."""
    return all(case.vectors)


def other_eigenvalues_are_inside(case: SpectrumCase) -> bool:
    """The roots of det(x I - V) that are left after all eigenvectors lie inside the circle."""
    return is_schur(case.rest)


# ---------------------------------------------------------------------------- growth


@dataclass(frozen=True)
class Parasitic:
    """How the components of one eigenvalue of modulus 1 feed each other.

    Parameters
    ----------
    zeta : number
        The eigenvalue. A simple eigenvalue 1 of one method is none of these: it belongs to the
        solution.
    matrices : list of matrix
        (1 / zeta) W B U N; of pairs those between the components.
    principal : int
        1 where the solution is one of the components, else 0.
    """

    zeta: Number
    matrices: list
    principal: int = 0

    @property
    def count(self) -> int:
        """Return the number of growth parameters."""
        return sum(map(len, self.matrices)) - self.principal


class GrowthCase(Case):
    """A part about the growth of all parasitic components."""

    one_matrix_is_enough = False  # to refute
    only_counts = False

    @property
    def free(self) -> bool:
        """Tell whether the claim is that there is no growth, not which."""
        return self.proof.claim == "parasitism-free"

    @cached_property
    def spectra(self) -> dict[str, tuple[Space, ...]]:
        """Return the eigenvalues of modulus 1 that other parts have shown, by colour."""
        return {x.colour: x.spaces for x in self.proof.all_shown(Spectrum)}

    def others(self, colour: str) -> list[Space]:
        """Return the eigenvalues of a component other than 1."""
        return [x for x in self.spectra[colour] if bool(x.zeta - 1)]

    @cached_property
    def parasitic(self) -> dict[int, Parasitic]:
        """Return what may grow, by its place: of `eigen`, of pairs among the shared eigenvalues."""
        if self.method.pair:
            both = [(x, y) for x in self.others("f") for y in self.others("k")
                    if not bool(x.zeta - y.zeta)]  # fmt: skip
            return {k: self.shared(x, y) for k, (x, y) in enumerate(both)}
        m = self.method.single()
        return {
            k: Parasitic(x.zeta, [growth_matrix(x, m, m, x)], int(not bool(x.zeta - 1)))
            for k, x in enumerate(self.spectra["o"])
            if bool(x.zeta - 1) or len(x.W) > 1
        }

    def shared(self, x: Space, y: Space) -> Parasitic:
        """Return how the components of an eigenvalue that both halves of a pair have meet."""
        spaces, m = {"f": x, "k": y}, self.method.parts
        return Parasitic(x.zeta, [
            growth_matrix(spaces[c], m[c], m[e], spaces[e])
            for c, children in self.method.palette for e in children
            if e != c or self.free
        ])  # fmt: skip

    @cached_property
    def by_place(self) -> dict[int, list]:
        """Return the declared parameters of each place."""
        rest = list(self.claimed)
        return {k: [rest.pop(0) for _ in range(x.count)] for k, x in self.parasitic.items()}

    def gap(self, place: int) -> list:
        """Return numbers that are all 0 where the parameters of a place are those declared.

        One method: det(x I - M) minus the product of (x - mu), times x - 1 for the solution.
        Pairs: the entries of the matrices, 0 being declared.
        """
        found = self.parasitic[place]
        if self.method.pair:
            return [x for M in found.matrices for row in M for x in row]
        roots = self.by_place[place] + [Fraction(1)] * found.principal
        return less(characteristic(found.matrices[0]), from_roots(roots))


class GrowsCase(GrowthCase):
    """A part that refutes the growth declared of one place."""

    witness: Place

    @property
    def one_matrix_is_enough(self) -> bool:
        """Tell whether one matrix other than 0 refutes the claim, whatever the others are."""
        return self.free

    @property
    def only_counts(self) -> bool:
        """Tell whether the part is about the number of parameters."""
        return self.witness.part == -1

    @property
    def place(self) -> int:
        """Return the place that the part is about."""
        return self.witness.part


def eigenvalues_of_every_component_are_shown(case: GrowthCase) -> bool:
    """The eigenvalues of V of every component are shown by `eigen`."""
    return set(case.spectra) == set(case.method.parts)


def one_is_not_multiple_in_pairs(case: GrowthCase) -> bool:
    """In a pair 1 is not a multiple eigenvalue of V or V^."""
    if not case.method.pair or case.one_matrix_is_enough:
        return True
    return all(len(x.W) == 1 for found in case.spectra.values() for x in found
               if not bool(x.zeta - 1))  # fmt: skip


def eigenvalues_meet_where_stages_do(case: GrowthCase) -> bool:
    """In a pair that is not separable V and V^ have the same eigenvalues of modulus 1."""
    if not case.method.pair or case.method.separable or case.one_matrix_is_enough:
        return True
    return len(case.parasitic) == len(case.others("f")) == len(case.others("k"))


def parameters_of_pairs_are_numbers(case: GrowthCase) -> bool:
    """For the claim `growth` the eigenvalues that a pair shares, but 1, are simple in both."""
    if not case.method.pair or case.free:
        return True
    return all(len(M) == len(M[0]) == 1 for x in case.parasitic.values() for M in x.matrices)


def growth_matrices_are_0(case: GrowthCase) -> bool:
    """For `parasitism-free` all growth matrices are 0; where 1 is multiple its rank is 1."""
    return not case.free or all(
        rank(M) == x.principal for x in case.parasitic.values() for M in x.matrices
    )


def the_one_is_the_solution(case: GrowthCase) -> bool:
    """Where 1 is multiple, for `parasitism-free`, its growth matrix has the eigenvalue 1."""
    return not case.free or all(
        vanishes(horner(characteristic(x.matrices[0]), Fraction(1)))
        for x in case.parasitic.values() if x.principal
    )  # fmt: skip


def as_many_are_declared(case: GrowthCase) -> bool:
    """For the claim `growth` as many parameters are declared as there are."""
    return case.free or len(case.claimed) == sum(x.count for x in case.parasitic.values())


def declared_of_pairs_are_0(case: GrowthCase) -> bool:
    """The parameters that are declared of a pair are 0, since others depend on the scaling."""
    return not case.method.pair or case.free or case.only_counts or vanishes(case.claimed)


def parameters_are_those_declared(case: GrowthCase) -> bool:
    """For the claim `growth` the parameters are those declared."""
    return case.free or all(vanishes(case.gap(k)) for k in case.parasitic)


def another_number_is_declared(case: GrowsCase) -> bool:
    """For the part -1 the claim is `growth`, and another number of parameters is declared."""
    if not case.only_counts:
        return True
    return not case.free and len(case.claimed) != sum(x.count for x in case.parasitic.values())


def place_is_parasitic(case: GrowsCase) -> bool:
    """The part names an eigenvalue of a parasitic component; a simple 1 is none."""
    return case.only_counts or case.place in case.parasitic


def declared_have_places(case: GrowsCase) -> bool:
    """For a part other than -1 as many parameters are declared as there are."""
    return case.only_counts or as_many_are_declared(case)


def something_grows(case: GrowsCase) -> bool:
    """For `parasitism-free` it is not 0; where 1 is multiple its rank is above 1, or trace 0."""
    if case.only_counts or not case.free:
        return True
    found = case.parasitic[case.place]
    if found.principal:
        M = found.matrices[0]
        nilpotent = rank(M) == 1 and vanishes([total(row[k] for k, row in enumerate(M))])
        return nilpotent or rank(M) > 1
    return any(apart(x) for M in found.matrices for row in M for x in row)


def a_parameter_is_another(case: GrowsCase) -> bool:
    """For the claim `growth` a parameter is another one than declared."""
    return case.only_counts or case.free or any(map(apart, case.gap(case.place)))


GROWTH_RULES = (
    Rule(
        "bounded", "zero-stable", "holds",
        "a block triangular V is power-bounded where all blocks but one are Schur and that one is",
        POWERS, Which, PowersCase, (one_block_is_on_the_circle, powers_are_bounded),
        lambda case: Bounded(case.colour),
    ),
    Rule(
        "unbounded", "zero-stable", "fails", "the powers of V hold those of its blocks",
        POWERS, WhichBlock, BlockCase, (powers_are_not_bounded,),
    ),
    Rule(
        "eigen", "growth", "holds",
        "the eigenvectors span all eigenspaces of modulus 1: the rest of det(x I - V) is Schur",
        POWERS, Eigenvalues, SpectrumCase,
        (V_is_exact, eigenvalues_have_modulus_1, arguments_increase, all_are_eigenvalues,
         other_eigenvalues_are_inside),
        lambda case: case.spectrum(),
    ),
    Rule(
        "growth", "growth", "holds",
        "the components at zeta grow as exp(t M), M = (1/zeta) W B U N; of a pair those feed each "
        "other whose eigenvalues are the same",
        GROWTH, NoWitness, GrowthCase,
        (eigenvalues_of_every_component_are_shown, one_is_not_multiple_in_pairs,
         eigenvalues_meet_where_stages_do, parameters_of_pairs_are_numbers, growth_matrices_are_0,
         the_one_is_the_solution, as_many_are_declared, declared_of_pairs_are_0,
         parameters_are_those_declared),
    ),
    Rule(
        "grows", "growth", "fails",
        "one parameter that is another, or one too many, refutes the list; one matrix other than "
        "0 refutes that nothing grows",
        GROWTH, Place, GrowsCase,
        (eigenvalues_of_every_component_are_shown, one_is_not_multiple_in_pairs,
         eigenvalues_meet_where_stages_do, parameters_of_pairs_are_numbers,
         another_number_is_declared, place_is_parasitic, declared_have_places,
         declared_of_pairs_are_0, something_grows, a_parameter_is_another),
    ),
)  # fmt: skip
