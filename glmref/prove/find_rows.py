"""What the kernel finds of orders beside that of the method: embedded rows, b(theta), any J."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_IDENTITY
from ..errors import ExactnessError
from ..exact import linalg
from ..exact.judging import as_numbers, as_scalar, fast_judge
from ..findings import Proof
from ..theory.starting_series import tableau
from ..theory.trees import trees
from .ranges import MAX_ORDER, Range

if TYPE_CHECKING:
    from .kernel import Found, Kernel


class RowRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        method: Any
        is_pair: bool
        exact: bool
        implied: Any
        judged: Any
        _made: Any

    @cached_property
    def row_kernels(self) -> tuple[tuple[str, Kernel], ...]:
        """Return the kernel of the method with each embedded row as its weights, by name."""
        kind: Any = type(self)
        return tuple(
            (
                x.name,
                kind(
                    self.method.with_row(x),
                    self.implied and self.implied.of_row(x.name),
                    self.judged and partial(self.judged, row=x.name),
                ),
            )
            for x in self.method.embedded
        )

    @property
    def row_claim(self) -> str:
        """The order required of the rows: of a pair that on second-order systems."""
        if self.is_pair and not self.method.additive:
            return NYSTROM_ORDER.key
        return ORDER.key if self.method.is_one_step else ORDER_IDENTITY.key

    def _embedded_order(self, declared: Mapping[str, int]) -> Found:
        """Judge the order of every embedded row; the first that is not as declared decides."""
        kernels, made = dict(self.row_kernels), self._made
        if not kernels or declared.keys() != kernels.keys():
            reason = f"the rows of `embedded` are {', '.join(kernels) or 'none'}"
            return made(False, exact=True, value=None, residual=0.0, reason=reason)
        found = {name: x.find(self.row_claim, declared[name]) for name, x in kernels.items()}
        by_truth = {x.truth: (name, x) for name, x in reversed(found.items())}
        truth = False if False in by_truth else None if None in by_truth else True
        name, decides = by_truth.get(False) or by_truth.get(None) or (
            "", max(found.values(), key=lambda x: x.residual)
        )  # fmt: skip
        return made(
            truth,
            exact=self.exact and all(x.proof is Proof.EXACT for x in found.values()),
            value={key: x.value for key, x in found.items()},
            residual=decides.residual,
            reason=f"row {name}: {decides.reason}" if name else "",
        )

    @property
    def _dense_order(self) -> Range:
        """Every power of theta: ``sum_i dense[i][m] Phi_i(t)`` is 1 / gamma(t) at m + 1 = |t|.

        ``Phi`` is of the tree; at the other powers the sum is 0.
        """
        m = self.method
        if m.dense is None:
            return Range(0, 0, reason="the file gives no dense output")
        if m.in_time is not m or not m.is_one_step:
            raise ExactnessError("dense output is judged where c = A 1 and one value is carried")
        columns, gaps = as_numbers(linalg.transpose(m.dense)), fast_judge().rules_rows.dense_gaps
        exact, series = self.exact and linalg.is_exact(m.dense), tableau({"o": (m.A, ())})
        lower, proved, sizes = 0, True, [0.0]
        for n in range(1, MAX_ORDER[0] + 1):
            for t in trees(n):
                for power, x in enumerate(gaps(columns, series, t.judged), 1):
                    value = as_scalar(x)
                    if value.is_zero() is False:
                        reason = f"the power {power} of theta is off"
                        return Range(
                            lower, n - 1, str(t), value.magnitude(), tuple(sizes[1:]),
                            exact, reason, n - 1,
                        )  # fmt: skip
                    proved = proved and value.is_zero() is True
                    sizes[-1] = max(sizes[-1], 0.0 if value.is_zero() else value.magnitude())
            sizes.append(sizes[-1])
            lower = n if proved else lower
        return Range(lower, None, sizes=tuple(sizes), exact=exact, value=MAX_ORDER[0])

    @property
    def _w_order(self) -> Range:
        """The order with any matrix in the place of the Jacobian."""
        if not self.method.rosenbrock:
            raise ExactnessError("a Rosenbrock method is needed")
        return self.any_matrix.order_range(free=False)

    @cached_property
    def any_matrix(self) -> Kernel:
        """The kernel of a Rosenbrock method with any matrix in the place of the Jacobian."""
        kind: Any = type(self)
        return kind(self.method.with_any_matrix())
