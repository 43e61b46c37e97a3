"""Rules for symmetry (section 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from .arithmetic import Fraction, Number, tick
from .document import Component, Method
from .linalg import combine, identity, inverse_matrix, minus, rank, solve, times
from .numbers import may_vanish, vanishes
from .refusals import beyond, require
from .rule import Case, Reversal, Rule

SYMMETRY = "Butcher, Hill, Norton, Symmetric general linear methods (2016)"


@dataclass(frozen=True)
class Exchange:
    """L and P of one method; of a pair L, L_hat and the P on the stages Q and P."""

    L: list
    P: list | None = None
    L_hat: list | None = None
    P_Q: list | None = None
    P_P: list | None = None


@dataclass(frozen=True)
class Turned:
    """A component with V^-1, L, and P on the slopes and on the stages: what must vanish of them."""

    m: Component
    back: list
    L: list
    slopes: list
    stages: list

    def of_L(self) -> list:
        """Return L^2 - I."""
        return minus(times(self.L, self.L), identity(self.m.r))

    def of_V(self) -> list:
        """Return L V^-1 L - V."""
        return minus(times(self.L, self.back, self.L), self.m.V)

    def of_B(self) -> list:
        """Return B - V L B P."""
        mirrored = times(self.m.V, self.L, self.m.B)
        return minus(self.m.B, [[row[x] for x in self.slopes] for row in mirrored])

    def of_U(self) -> list:
        """Return U - P U L V."""
        mirrored = times(self.m.U, self.L, self.m.V)
        return minus(self.m.U, [mirrored[x] for x in self.stages])

    def of_A(self) -> list:
        """Return A + P A P - U V^-1 B."""
        moved = [[self.m.A[x][y] for y in self.slopes] for x in self.stages]
        return minus(combine(self.m.A, moved), times(self.m.U, self.back, self.m.B))


class SymmetricCase(Case):
    """A part about the involutions L and P that exchange a step with its reversal."""

    witness: Exchange

    @cached_property
    def by_colour(self) -> dict[str, tuple[list, list, list]]:
        """Return by colour L, P on the slopes and P on the stages, as they are written."""
        x, pair = self.witness, self.method.pair
        own = (x.L, x.L_hat, x.P_Q, x.P_P) if pair else (x.L, x.P)
        given = [y for y in own if y is not None]
        fine = len(given) == len(own) == sum(y is not None for y in vars(x).values())
        require(fine, "the witness has other members than L and P of the components")
        if not pair:
            self.method.single()
            return {"o": (given[0], given[1], given[1])}
        L, L_hat, P_Q, P_P = given
        return {"f": (L, P_P, P_Q), "k": (L_hat, P_Q, P_P)}

    @cached_property
    def L(self) -> dict[str, list]:
        """Return L by colour."""
        read = self.method.numbers.matrix
        return {c: read(L) for c, (L, _, _) in self.by_colour.items()}

    def P(self, colour: str) -> tuple[list, list]:
        """Return the places of the slopes and of the stages of a component."""
        return self.by_colour[colour][1:]

    @cached_property
    def turned(self) -> list[Turned]:
        """Return the components with V^-1, L and P."""
        return [Turned(m, inverse_matrix(m.V), self.L[c], *self.P(c))
                for c, m in self.method.parts.items()]  # fmt: skip


def is_involution(p: list, n: int) -> bool:
    """Tell whether p is a 0-based list of n places that exchanges them."""
    fine = all(type(x) is int for x in p) and sorted(p) == list(range(n))
    return fine and all(p[x] == k for k, x in enumerate(p))


def P_are_involutions(case: SymmetricCase) -> bool:
    """Each P is an involution of the stages."""
    return all(
        is_involution(p, n)
        for c, m in case.method.parts.items()
        for p, n in zip(case.P(c), (len(m.B[0]), len(m.A)), strict=True)
    )


def P_agree_where_stages_are_shared(case: SymmetricCase) -> bool:
    """P_Q = P_P where the pair is not separable."""
    return not case.method.pair or case.method.separable or case.P("f")[0] == case.P("f")[1]


def L_are_involutions(case: SymmetricCase) -> bool:
    """L^2 = I."""
    return all(vanishes(x.of_L()) for x in case.turned)


def V_are_regular(case: SymmetricCase) -> bool:
    """V is regular."""
    return all(rank(m.V) == m.r for m in case.method.parts.values())


def L_reverses_V(case: SymmetricCase) -> bool:
    """L V^-1 L = V."""
    return all(vanishes(x.of_V()) for x in case.turned)


def B_is_reversed(case: SymmetricCase) -> bool:
    """B = V L B P."""
    return all(vanishes(x.of_B()) for x in case.turned)


def U_is_reversed(case: SymmetricCase) -> bool:
    """U = P U L V."""
    return all(vanishes(x.of_U()) for x in case.turned)


def A_is_reversed(case: SymmetricCase) -> bool:
    """A + P A P = U V^-1 B."""
    return all(vanishes(x.of_A()) for x in case.turned)


# ---------------------------------------------------------------------------- no reversal


class Search:
    """All involutions P with A + P A P = U V^-1 B, by backtracking; those of Q stand first."""

    def __init__(self, method: Method) -> None:
        blocks = []
        for m in method.parts.values():
            blocks.append((m.A, times(m.U, inverse_matrix(m.V), m.B)))
        self.n, self.kinds = len(blocks[0][0]), [0] * len(blocks[0][0])
        self.turns = list(range(self.n))
        if method.separable:
            (A, M), (A_hat, M_hat) = blocks
            self.kinds += [1] * len(A_hat)
            blocks, self.n = [(corners(A, A_hat), corners(M, M_hat))], len(self.kinds)
            # by turns: every condition is about a stage Q and a stage P
            self.turns = sorted(range(self.n), key=lambda i: i - len(A) * self.kinds[i])
        self.blocks, self.steps = blocks, 0
        self.P: list[int | None] = [None] * self.n
        self.told: dict[tuple[int, ...], bool] = {}

    def found(self) -> Iterator[list[int]]:
        """Yield every involution that continues what is placed."""
        self.steps += 1
        if self.steps > 100_000:
            beyond()
        k = next((i for i in self.turns if self.P[i] is None), None)
        if k is None:
            yield [x for x in self.P if x is not None]
            return
        for x in reversed(range(k, self.n)):  # the mirror image of k first
            if self.P[x] is None and self.kinds[x] == self.kinds[k]:
                self.P[k], self.P[x] = x, k
                if self.fits(k, x):
                    yield from self.found()
                self.P[k] = self.P[x] = None

    def fits(self, k: int, x: int) -> bool:
        """Tell whether the condition may hold at two places, with all that are placed."""
        tick()
        known = {i: y for i, y in enumerate(self.P) if y is not None}
        pairs = [(i, j) for e in (k, x) for o in known for i, j in ((e, o), (o, e))]
        return all(self.fits_at(i, j, known[i], known[j]) for i, j in pairs)

    def fits_at(self, *places: int) -> bool:
        """Tell whether A_ij + A_(Pi)(Pj) may be M_ij, at the places i, j, Pi and Pj."""
        if places not in self.told:
            i, j, k, x = places
            self.told[places] = all(may_vanish(A[i][j] + A[k][x] - M[i][j]) for A, M in self.blocks)
        return self.told[places]


def corners(M: list, N: list) -> list:
    """Return the matrix with M right above and N left below."""
    zero = Fraction(0)
    return [[zero] * len(M) + row for row in M] + [row + [zero] * len(M[0]) for row in N]


@dataclass(frozen=True)
class Singular:
    """The colour of a component whose V is singular."""

    singular: str | None = None


class NotSymmetricCase(Case):
    """A part about all involutions that a method may have."""

    witness: Singular

    def no_reversal(self, colour: str, P: list[int]) -> bool:
        """Tell whether the linear conditions on L contradict or have one solution, no involution.

        They are U V^-1 = P U L, V^-1 B = L B P, V L = L V^-1.
        """
        m, back = self.method.part(colour), inverse_matrix(self.method.part(colour).V)
        n_Q = len(self.method.parts["f"].A) if self.method.separable else 0
        Q_of, P_of = (P[:n_Q], [x - n_Q for x in P[n_Q:]]) if n_Q else (P, P)
        stages, slopes = (P_of, Q_of) if colour == "k" else (Q_of, P_of)
        x, unique = solve(*conditions(m, back, stages, slopes))
        if x is None:
            return True
        L = [x[i * m.r : i * m.r + m.r] for i in range(m.r)]
        return unique and not vanishes(minus(times(L, L), identity(m.r)))


def conditions(m: Component, back: list, stages: list[int], slopes: list[int]) -> tuple[list, list]:
    """Return rows and right sides of the linear conditions on the entries of L."""
    left, right, r, rows, values = times(m.U, back), times(back, m.B), m.r, [], []

    def add(value: Number, coefficients: list) -> None:
        row = [Fraction(0)] * (r * r)
        for (i, j), x in coefficients:
            row[i * r + j] = row[i * r + j] + x
        rows.append(row)
        values.append(value)

    for s, j in product(range(len(m.U)), range(r)):
        add(left[s][j], [((k, j), m.U[stages[s]][k]) for k in range(r)])
    for i, s in product(range(r), range(len(m.B[0]))):
        add(right[i][s], [((i, k), m.B[k][slopes[s]]) for k in range(r)])
    for i, j in product(range(r), range(r)):
        add(Fraction(0), [((k, j), m.V[i][k]) for k in range(r)]
            + [((i, k), -back[k][j]) for k in range(r)])  # fmt: skip
    return rows, values


def the_V_named_is_singular(case: NotSymmetricCase) -> bool:
    """With `singular` V of the component named is singular."""
    colour = case.witness.singular
    return colour is None or rank(case.method.part(colour).V) < case.method.part(colour).r


def no_P_has_an_L(case: NotSymmetricCase) -> bool:
    """Else for every P that the stages allow a component has no L."""
    return case.witness.singular is not None or all(
        any(case.no_reversal(c, P) for c in case.method.parts) for P in Search(case.method).found()
    )


SYMMETRY_RULES = (
    Rule(
        "symmetric", "symmetric", "holds", "the definition", SYMMETRY, Exchange, SymmetricCase,
        (P_are_involutions, P_agree_where_stages_are_shared, V_are_regular, L_are_involutions,
         L_reverses_V, B_is_reversed, U_is_reversed, A_is_reversed),
        lambda case: Reversal(case.L),
    ),
    Rule(
        "not-symmetric", "symmetric", "fails", "no L and P satisfy the definition", SYMMETRY,
        Singular, NotSymmetricCase, (the_V_named_is_singular, no_P_has_an_L),
    ),
)  # fmt: skip
