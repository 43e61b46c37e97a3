"""Rules of the kernel for structure: symplectic and G-symplectic methods, symmetric ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method.preconsistency import preconsistency_vector
from ..system.budget import fits
from ..theory.coefficients import difference
from ..theory.starting_series import NoOrderOne, NotPreconsistent, Prepared
from .algebra import (
    all_of,
    bilinear,
    full_rank,
    involutions,
    is_exact,
    scaled,
    vanishes,
)
from .ranges import Known

_ZERO, _ONE = Exact(0), Exact(1)
#: Whose slopes a component uses: its own, or of a pair those of the other one.
OTHER: Mapping[str, str] = {"o": "o", "f": "k", "k": "f"}


class FormRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        blocks: dict[str, tuple[Matrix, Matrix, Matrix, Matrix]]
        is_pair: bool
        shared: bool
        exact: bool
        one_step: bool
        method: Any
        _components: dict[str, Prepared]

    # -- forms -------------------------------------------------------------------------------------

    def _symplectic(self, witness: Mapping[str, Any]) -> Known:
        """Decide b_i a_ij + b_j a_ji = b_i b_j (Sanz-Serna; Lasagni; Suris 1988); pairs: hats.

        Hairer, Lubich, Wanner (2006), theorems VI.4.3 and VI.4.6.
        """
        if not self.one_step:
            return Known(False, True, "a method that carries several values has no symplectic step")
        for _, U, _, V in self.blocks.values():
            ones = [x - 1 for row in (*U, *V) for x in row]
            if vanishes([ones]) is not True:
                raise ExactnessError("U and V of a method that carries one value must be 1")
        if self.is_pair:
            (A, _, (b,), _), (A_hat, _, (b_hat,), _) = self.blocks["f"], self.blocks["k"]
        else:
            A, _, (b,), _ = self.blocks["o"]
            A_hat, b_hat = A, b
        identity = tuple(
            tuple(
                b[i] * A_hat[i][j] + b_hat[j] * A[j][i] - b[i] * b_hat[j] for j in range(len(b_hat))
            )
            for i in range(len(b))
        )
        answers = [vanishes(identity)]
        if self.shared:
            answers.append(vanishes([difference(b, b_hat)]))
        return Known(all_of(answers), self.exact)

    def _g_symplectic(self, witness: Mapping[str, Any]) -> Known:
        """Judge whether some (G, D) satisfies the identities and u^* G u is not 0.

        Butcher and Hewitt, Numer. Algorithms 51 (2009) 33. A given or proposed form is checked.
        Where none is given and none works, the identities are a real-linear system in (G, D); that
        all its solutions have u^* G u = 0 is found by elimination, so that no form exists.
        """
        vectors = [
            preconsistency_vector(c) if is_exact(c.U, c.V) else None for c in self.method.components
        ]
        if any(x is None for x in vectors):
            if all(is_exact(b[1], b[3]) for b in self.blocks.values()):
                return Known(False, True, "the method is not preconsistent: no form counts")
            try:
                vectors = [c.u if c.certain else None for c in self._components.values()]
            except NoOrderOne as reason:
                raise ExactnessError(f"the form is not decided: {reason}") from reason
            except NotPreconsistent as reason:
                return Known(False, self.exact, f"not preconsistent, no form counts: {reason}")
            if any(x is None for x in vectors):
                raise ExactnessError("whether V u = u, U u = 1 is not decided within the digits")
        if not all(full_rank((*linalg.sub(V, linalg.identity(len(V))), *U), len(V))
                   for _, U, _, V in self.blocks.values()):  # fmt: skip
            raise ExactnessError("V u = u and U u = 1 do not determine u")
        u, u_hat = vectors[0], vectors[-1]
        assert u is not None
        assert u_hat is not None
        form = witness.get("form")
        if form is not None:
            G, diagonals = form
            residuals = self._form_residuals(G, diagonals)
            seen = bilinear(u, G, u_hat).is_zero()
            answers = [*map(vanishes, residuals), None if seen is None else not seen]
            truth = all_of(answers)
            if truth is True or witness.get("given"):
                return Known(truth, self.exact and is_exact(G, diagonals))
        if not self.exact:
            raise ExactnessError("no form was proved or excluded within the digits")
        return Known(self.some_form(u, u_hat) is not None)

    def _form_residuals(self, G: Matrix, diagonals: Sequence[Vector]) -> list[Matrix]:
        """Return the left minus right of the identities.

        The last one says that D is real, G Hermitian.
        """
        star, matmul, sub = linalg.conjugate_transpose, linalg.matmul, linalg.sub
        imaginary = (tuple(x.imag for d in diagonals for x in d),)
        if not self.is_pair:
            A, U, B, V = self.blocks["o"]
            (d,) = diagonals
            dA = scaled(d, A)
            return [
                sub(G, matmul(star(V), G, V)),
                sub(scaled(d, U), matmul(star(B), G, V)),
                sub(linalg.add(dA, star(dA)), matmul(star(B), G, B)),
                sub(G, star(G)),
                imaginary,
            ]
        (A, U, B, V), (A_, U_, B_, V_) = self.blocks["f"], self.blocks["k"]
        d_p, d_q = diagonals
        residuals = [
            sub(G, matmul(star(V), G, V_)),
            sub(scaled(d_p, U_), matmul(star(B), G, V_)),
            sub(scaled(d_q, U), matmul(star(B_), star(G), V)),
            sub(linalg.add(scaled(d_p, A_), star(scaled(d_q, A))), matmul(star(B), G, B_)),
            imaginary,
        ]
        if self.shared:
            residuals.append((difference(d_p, d_q),))
        return residuals

    def some_form(self, u: Vector, u_hat: Vector) -> tuple[Matrix, list[Vector]] | None:
        """Return a form (G, D) with u^* G u^ not 0, over exact numbers.

        ``None`` proves that none exists.

        The space of all forms is eliminated.
        """
        values, equations = self.form_system(u, u_hat)
        system = tuple(
            row for row in zip(*equations, strict=True) if any(not x.vanishes() for x in row)
        )
        space = linalg.nullspace(system) if system else list(linalg.identity(len(values)))
        chosen = next((x for x in space if linalg.dot(x, values).is_zero() is False), None)
        if chosen is None:
            return None
        units = self._form_units(len(u), len(u_hat))
        G = linalg.zeros(len(u), len(u_hat))
        diagonals: list[Vector] = [(_ZERO,) * len(d) for d in units[0][1]]
        for x, (unit, parts) in zip(chosen, units, strict=True):
            G = linalg.add(G, linalg.scale(x, unit))
            diagonals = [
                tuple(a + x * b for a, b in zip(d, part, strict=True))
                for d, part in zip(diagonals, parts, strict=True)
            ]
        return G, diagonals

    def form_system(self, u: Vector, u_hat: Vector) -> tuple[list[Scalar], list[list[Scalar]]]:
        """Return the real-linear system of (G, D).

        Returns
        -------
        tuple[list[Scalar], list[list[Scalar]]]
            For each real unit of (G, D) its u^* G u, and the entries of the identities.
        """
        units = self._form_units(len(u), len(u_hat))
        equations: list[list[Scalar]] = []
        for G, d in units:
            flat = [x for m in self._form_residuals(G, d) for row in m for x in row]
            imaginary = [] if self.is_real else [x.imag for x in flat]
            equations.append([x.real for x in flat] + imaginary)
        values = [bilinear(u, G, u_hat).real for G, _ in units]
        return values, equations

    @property
    def is_real(self) -> bool:
        """Whether all entries are real."""
        return all(x.is_real() for b in self.blocks.values() for m in b for row in m for x in row)

    def _form_units(self, rows: int, columns: int) -> list[tuple[Matrix, list[Vector]]]:
        """Return a basis of all (G, D) over the real numbers, G Hermitian where it is square."""
        real = self.is_real
        factors = (_ONE,) if real else (_ONE, Exact(-1).sqrt())
        units: list[tuple[Matrix, list[Vector]]] = []
        lengths = [len(self.blocks["o"][0])] if not self.is_pair else [
            len(self.blocks["k"][0]), len(self.blocks["f"][0])
        ]  # fmt: skip
        nil: list[Vector] = [(_ZERO,) * n for n in lengths]
        stages = sum(lengths)
        fits(rows * columns + stages, rows * columns + (rows + columns + stages) * stages, "(G, D)")
        for i, j, x in product(range(rows), range(columns), factors):
            if not self.is_pair and (j < i or (i == j and x is not _ONE)):
                continue
            G = [[_ZERO] * columns for _ in range(rows)]
            G[i][j] = x
            if not self.is_pair:
                G[j][i] = x.conjugate()
            units.append((tuple(map(tuple, G)), nil))
        zero = linalg.zeros(rows, columns)
        for k, n in enumerate(lengths):
            for i in range(n):
                unit = tuple(_ONE if j == i else _ZERO for j in range(n))
                units.append((zero, [unit if m == k else x for m, x in enumerate(nil)]))
        return units

    # -- symmetry ----------------------------------------------------------------------------------

    def _symmetric(self, witness: Mapping[str, Any]) -> Known:
        """Judge whether the method of the file equals its adjoint as it stands.

        Butcher, "B-Series" (2021), section 7.6. A proposed (L, P) is checked. Otherwise *every*
        involution P of the stages that A + P A P = U V^-1 B may allow is found by a search that is
        complete or says that it was cut off; for each, the conditions on L that follow from
        L^2 = I, namely P U L = U V^-1, L B P = V^-1 B and V L = L V^-1, are linear: they contradict
        each other, or have one solution, whose square is looked at.
        """
        try:
            inverses = {c: linalg.inverse(b[3]) for c, b in self.blocks.items()}
        except ExactnessError:
            if all(is_exact(b[3]) for b in self.blocks.values()):
                return Known(False, True, "V is singular: no step can be reversed")
            raise
        proposed = witness.get("involutions")
        if proposed is not None:
            answers = []
            Ls, exchanges = proposed
            for c, L in zip(self.blocks, Ls, strict=True):
                residuals = self._symmetry_residuals(c, inverses[c], L, exchanges)
                answers += [vanishes(m) for m in residuals]
            if all(P[P[i]] == i for P in exchanges.values() for i in range(len(P))):
                if self.shared and len({tuple(P) for P in exchanges.values()}) > 1:
                    answers.append(None)
                if all_of(answers) is True:
                    return Known(True, self.exact)
        return self._not_symmetric(inverses)

    def _symmetric_reduced(self, witness: Mapping[str, Any]) -> Known:
        """Return the same for the method without the values that are never reached or never seen.

        A proposed method with the same A is that method where U V^k B agree for k < r + r' (by
        Cayley and Hamilton then for all k: stages see the same) and where it is itself minimal:
        minimal methods with equal U V^k B differ by a change of basis only (Kalman 1963).
        """
        smaller = witness.get("reduced")
        if smaller is None:
            raise ExactnessError("the method without idle values was not found")
        if len(smaller.A) != len(self.blocks["o"][0]):
            raise ExactnessError(
                "the method has equal or idle stages, which are not taken out here"
            )
        A, U, B, V = self.blocks["o"]
        if vanishes(linalg.sub(A, smaller.A)) is not True:
            raise ExactnessError("the method without idle values has another A")
        left, right = U, smaller.U
        for _ in range(len(V) + len(smaller.V)):
            gap = linalg.sub(linalg.matmul(left, B), linalg.matmul(right, smaller.B))
            if vanishes(gap) is not True:
                raise ExactnessError("the method without idle values is not equivalent")
            left, right = linalg.matmul(left, V), linalg.matmul(right, smaller.V)
        kind: Any = type(self)
        inner = kind(smaller)
        if inner._reducible({}).truth is not False:
            raise ExactnessError("the reduced method is not minimal")
        return replace(inner._symmetric(witness), exact=self.exact)

    def _symmetry_residuals(
        self, c: str, inverse: Matrix, L: Matrix, exchanges: Mapping[str, Sequence[int]]
    ) -> list[Matrix]:
        """Return L^2 - I, L V^-1 L - V, B - V L B P, U - P U L V, A + P A P - U V^-1 B."""
        A, U, B, V = self.blocks[c]
        # stages of this component, where its rows of A and U belong, and its slopes
        rows = exchanges[c]
        columns = exchanges[OTHER[c]]
        matmul, sub = linalg.matmul, linalg.sub
        turned = tuple(tuple(A[i][j] for j in columns) for i in rows)
        return [
            sub(matmul(L, L), linalg.identity(len(L))),
            sub(matmul(L, inverse, L), V),
            sub(B, matmul(V, L, tuple(tuple(row[j] for j in columns) for row in B))),
            sub(U, matmul(tuple(U[i] for i in rows), L, V)),
            sub(linalg.add(A, turned), matmul(U, inverse, B)),
        ]

    def exchange_problem(
        self, inverses: Mapping[str, Matrix]
    ) -> tuple[list[tuple[Matrix, Matrix, int, int]], list[int]]:
        """Return relations and group sizes of the search for exchanges: stages Q first, then P."""
        relations = []
        offset = {"o": 0, "f": 0, "k": 0}
        if not self.shared:
            offset["k"] = len(self.blocks["f"][0])  # stages Q first, then stages P
        for c, (A, U, B, _) in self.blocks.items():
            target = linalg.matmul(U, inverses[c], B)
            relations.append((A, target, offset[c], offset[OTHER[c]]))
        sizes = [len(self.blocks[c][0]) for c in self.blocks]
        if self.shared:
            sizes = sizes[:1]
        return relations, sizes

    def _not_symmetric(self, inverses: Mapping[str, Matrix]) -> Known:
        relations, sizes = self.exchange_problem(inverses)
        exchanges = involutions(relations, sizes)
        if exchanges is None:
            return Known(None, self.exact, "the search for an exchange of stages was cut off")
        for P in exchanges:
            split = dict.fromkeys(self.blocks, P)
            if not self.shared:
                n = len(self.blocks["f"][0])
                split = {"f": P[:n], "k": tuple(i - n for i in P[n:])}
            if not any(self._excluded(c, inverses[c], split) for c in self.blocks):
                return Known(
                    None, self.exact, "an exchange of stages was neither proved nor excluded"
                )
        return Known(False, self.exact)

    def _excluded(self, c: str, inverse: Matrix, exchanges: Mapping[str, Sequence[int]]) -> bool:
        """Return whether no L goes with these exchanges of stages; exact numbers only."""
        _, U, B, V = self.blocks[c]
        if not is_exact(U, B, V):
            return False
        r, s = len(V), len(U)
        columns = exchanges[OTHER[c]]
        PU = tuple(U[i] for i in exchanges[c])
        BP = tuple(tuple(row[j] for j in columns) for row in B)
        U_back, B_back = linalg.matmul(U, inverse), linalg.matmul(inverse, B)
        rows: list[list[Scalar]] = []

        def add(entries: Mapping[int, Scalar], value: Scalar) -> None:
            row: list[Scalar] = [_ZERO] * (r * r + 1)
            for place, x in entries.items():
                row[place] = x
            row[-1] = -value
            rows.append(row)

        for i, k in product(range(s), range(r)):  # P U L = U V^-1
            add({a * r + k: PU[i][a] for a in range(r)}, U_back[i][k])
        for a, j in product(range(r), range(len(B[0]))):  # L B P = V^-1 B
            add({a * r + b: BP[b][j] for b in range(r)}, B_back[a][j])
        for a, k in product(range(r), repeat=2):  # V L = L V^-1
            row: list[Scalar] = [_ZERO] * (r * r + 1)
            for b in range(r):
                row[b * r + k] = row[b * r + k] + V[a][b]
                row[a * r + b] = row[a * r + b] - inverse[b][k]
            rows.append(row)
        solutions = linalg.nullspace(tuple(map(tuple, rows)))
        whole = [x for x in solutions if x[-1].is_zero() is False]
        if not whole:
            return True  # the conditions contradict each other
        if len(solutions) > 1:
            return False
        flat = [x / whole[0][-1] for x in whole[0][:-1]]
        L = tuple(tuple(flat[a * r : a * r + r]) for a in range(r))
        return vanishes(linalg.sub(linalg.matmul(L, L), linalg.identity(r))) is False
