"""What the kernel finds of V: growth parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix
from ..theory import polynomials as poly
from ..theory.residues import Residue, in_order, residues
from ..theory.root_location import is_schur
from .algebra import all_of, compared, is_exact, vanishes
from .ranges import Known

_ZERO, _ONE = Exact(0), Exact(1)


class GrowthRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        method: Any
        blocks: Any
        is_pair: bool
        shared: bool
        exact: bool
        implied: Any

    def _eigen(self, colour: str, witness: Mapping[str, Any]) -> list[tuple[Any, Matrix, Matrix]]:
        """Check the eigenvalues of modulus 1 that were proposed: all of them, semisimple.

        V N = zeta N, W N = I, |zeta| = 1, the zeta different; and h(V) P = 0, P = I - sum N W, with
        all roots of h inside the circle, so that V has no other such eigenvalue. Then W V = zeta W:
        h(V) is regular on the span of the N, which P therefore takes to 0, so that P is the
        projection to the kernel of h(V) along that span, and W vanishes on the kernel, which V
        keeps.

        Raises
        ------
        ExactnessError
            Where the proposal is missing or wrong.
        """
        proposed = witness.get(colour)
        V = self.blocks[colour][3]
        if proposed is None:
            raise ExactnessError(witness.get("why", "the eigenvalues of V are not decided"))
        parts, h = proposed
        r = len(V)
        rest = linalg.identity(r)
        for n, (zeta, W, N) in enumerate(parts):
            columns = linalg.transpose(tuple(N))
            if (
                (zeta * zeta.conjugate() - 1).is_zero() is not True
                or any((zeta - other).is_zero() is not False for other, _, _ in parts[:n])
                or vanishes(linalg.sub(linalg.matmul(V, columns), linalg.scale(zeta, columns)))
                is not True
                or vanishes(linalg.sub(linalg.matmul(tuple(W), columns), linalg.identity(len(N))))
                is not True
            ):
                raise ExactnessError("an eigenvector of V that was proposed is none")
            rest = linalg.sub(rest, linalg.matmul(columns, tuple(W)))
        if not is_schur(h) or vanishes(linalg.matmul(poly.evaluate_matrix(h, V), rest)) is not True:
            raise ExactnessError("V may have other eigenvalues on the unit circle")
        return list(parts)

    def _growth_matrices(
        self, witness: Mapping[str, Any]
    ) -> list[tuple[Exact, tuple[Matrix, ...]]]:
        """Return zeta^-1 W B U N at each eigenvalue of V of modulus 1, by increasing argument.

        For a pair the coupled matrices at the shared eigenvalues other than 1, and where stages are
        shared also those within each half. At zeta = 1 of one method the principal component is in
        the matrix, with the eigenvalue 1.
        """
        found = []
        if not self.is_pair:
            _, U, B, _ = self.blocks["o"]
            for zeta, W, N in self._eigen("o", witness):
                inner = linalg.matmul(tuple(W), B, U, linalg.transpose(tuple(N)))
                found.append((zeta, (linalg.scale(1 / zeta, inner),)))
            return found
        V, V_hat = (self.blocks[c][3] for c in "fk")
        if not self.shared and is_exact(V, V_hat):
            # components that no eigenvalue pairs do not feed each other: nothing can grow
            ends = map(poly.characteristic_polynomial, (V, V_hat))
            if poly.share_only_one(*ends):
                return []
        parts = {c: self._eigen(c, witness) for c in "fk"}
        for c in "fk":
            for zeta, W, _ in parts[c]:
                if (zeta - 1).is_zero() and len(W) > 1:
                    raise ExactnessError(
                        "1 is a multiple eigenvalue of V, which is not supported for pairs"
                    )
        others = {c: [x for x in parts[c] if not (x[0] - 1).is_zero()] for c in "fk"}
        for zeta, W, N in others["f"]:
            match = [x for x in others["k"] if (x[0] - zeta).is_zero()]
            if not match:
                continue
            halves = {"f": (W, N), "k": match[0][1:]}
            pairs = [("f", "k"), ("k", "f")] + ([("f", "f"), ("k", "k")] if self.shared else [])
            found.append(
                (
                    zeta,
                    tuple(
                        linalg.scale(
                            1 / zeta,
                            linalg.matmul(
                                tuple(halves[a][0]),
                                self.blocks[a][2],
                                self.blocks[b][1],
                                linalg.transpose(tuple(halves[b][1])),
                            ),
                        )
                        for a, b in pairs
                    ),
                )
            )
        if self.shared and len(found) < max(len(x) for x in others.values()):
            raise ExactnessError(
                "V and V^ have different eigenvalues and the stages are shared: not supported"
            )
        return found

    @cached_property
    def _residues(self) -> Mapping[str, tuple[Residue, ...]] | None:
        """The growth parameters of each half, where shared stages and simple roots allow them."""
        return residues(self.method) if self.is_pair and self.shared and self.exact else None

    def _growth(self, declared: list[Scalar], witness: Mapping[str, Any]) -> Known:
        """Judge whether the declared numbers are the eigenvalues of the growth matrices.

        Within one multiple eigenvalue of V their order does not matter: compared are characteristic
        polynomials. For a pair: mu_q and then mu_p at each shared eigenvalue, both of which are
        zero or not whatever the eigenvectors are; other values are not defined. Of a pair whose
        halves share the stages and only the eigenvalue 1: those of q, and then those of p.
        """
        if witness.get("unstable"):
            exact = all(is_exact(b[3]) for b in self.blocks.values())
            return Known(False, exact, "V is not power-bounded: growth parameters are not defined")
        if self.implied is not None and self.implied.growth_zeros is not None:
            count = self.implied.growth_zeros
            if len(declared) != count:
                return Known(
                    False, False, f"{count} growth parameters found, {len(declared)} declared"
                )
            return compared([_ZERO] * count, declared, exact=False)
        if self._residues is not None:
            found = in_order(self._residues)
            if len(found) != len(declared):
                return Known(
                    False, True, f"{len(found)} growth parameters found, {len(declared)} declared"
                )
            return compared(found, declared, exact=True)
        matrices = self._growth_matrices(witness)
        blocks = [
            (zeta, m, bool((zeta - 1).is_zero()))
            for zeta, found in matrices
            for m in (found[:2] if self.is_pair else found)
        ]
        sizes = [len(m) * (len(m[0]) if self.is_pair else 1) - first for _, m, first in blocks]
        if sum(sizes) != len(declared):
            return Known(
                False,
                True,  # the eigenvalues of V alone say how many there are
                f"{sum(sizes)} growth parameters found, {len(declared)} declared",
            )
        answers: list[Known] = []
        at = 0
        for (_, m, first), size in zip(blocks, sizes, strict=True):
            part = declared[at : at + size]
            if self.is_pair:
                entries = [x for row in m for x in row]
                known = compared(entries, part, exact=self.exact, offset=at)
                if any(x.is_zero() is False for x in entries) and any(
                    x.is_zero() is False for x in part
                ):
                    known = Known(None, self.exact, "growth parameters of a pair other than 0 "
                                  "depend on the scaling of the eigenvectors")  # fmt: skip
            elif first and len(m) == 1:  # a simple eigenvalue 1 has no parasitic component
                known = Known(True, self.exact)
            elif size == 1 and not first:
                known = compared(m[0], part, exact=self.exact, offset=at)
            else:
                known = self._same_spectrum(m, [_ONE, *part] if first else part)
            answers.append(known)
            at += size
        truth = all_of([x.truth for x in answers])
        chosen = next((x for x in answers if x.truth is truth), Known(True))
        return replace(
            chosen,
            truth=truth,
            exact=self.exact,
            residual=max((x.residual for x in answers), default=0.0),
        )

    def _same_spectrum(self, matrix: Matrix, numbers: Sequence[Scalar]) -> Known:
        found = poly.characteristic_polynomial(matrix)
        wanted = poly.from_roots(list(numbers))
        answer = all_of([(x - y).is_zero() for x, y in zip(found, wanted, strict=True)])
        shown = ", ".join(f"{complex(x):.6g}" for x in poly.approximate_roots(found))
        return Known(answer, self.exact, f"the growth matrix has the eigenvalues {shown}")
