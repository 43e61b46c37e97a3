"""What the kernel finds beside a tableau: embedded rows, c, b(theta), any J."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_IDENTITY
from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..findings import Proof
from ..theory.starting_series import stage_slopes
from ..theory.trees import trees
from .algebra import all_of, consistent_values, constants, first_value, is_exact
from .ranges import MAX_ORDER, Known, Range

if TYPE_CHECKING:
    from .kernel import Found, Kernel

_ZERO, _ONE = Exact(0), Exact(1)


def _all_zero(gaps: Sequence[tuple[Scalar, str]], *, exact: bool) -> Known:
    """Return whether numbers are zero: the first that is not decides, else the first that is open.

    A method is exact whatever stands beside it: then the numbers say whether the answer is.
    """
    answers = [gap.is_zero() for gap, _ in gaps]
    exact = exact and all(isinstance(gap, Exact) for gap, _ in gaps)
    truth = all_of(answers)
    if truth:
        return Known(True, exact)
    gap, text = gaps[answers.index(truth)]
    shown = f"{complex(gap):.6g}".replace("+0j", "")
    return Known(truth, exact, f"{text} {shown}", gap.magnitude())


def nystrom_gaps(pair: Any) -> list[tuple[Scalar, str]] | None:
    """Return what the rows of A sum to less c^2 / 2, and those of A' less c, each with its name.

    Parameters
    ----------
    pair : PartitionedGLM
        As :func:`~glmref.method.nystrom.nystrom` makes it; of another pair nothing is known, and
        ``None`` is returned.

    References: Hairer, Norsett, Wanner (1993), II.14: a stage is then the solution to O(h^3).
    """
    s = len(pair.A) if pair.separable else (len(pair.A) - 1) // 2
    slopes = [row[-s:] for row in pair.A_hat]
    values = ((_ZERO,) * s, *linalg.identity(s))
    shaped = len(slopes) == (s + 1 if pair.separable else 2 * s + 1)
    if not shaped or tuple(slopes[: s + 1]) != values or len(pair.A[0]) != len(slopes):
        return None
    found: list[tuple[Scalar, str]] = []
    rows = [row[: s + 1] for row in pair.A[-s:]]
    for i, row in enumerate(rows, 1):
        c = sum(row, _ZERO)
        found.append((sum(row[1:], _ZERO) - c * c / 2, f"row {i} of A sums to c[{i}]^2 / 2 +"))
    for i, (below, row) in enumerate(zip(slopes[s + 1 :], rows, strict=False), 1):
        gap = sum(below, _ZERO) - sum(row, _ZERO)
        found.append((gap, f"row {i} of A' sums to c[{i}] +"))
    return found


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

    def _embedded_difference(self) -> Known:
        """Return the weights of each estimate sum to zero.

        Of q the weight of q' itself is left out.
        """
        if not self.method.embedded:
            return Known(False, True, "the file gives no embedded rows")
        if self.method.embedded[0].values is not None:  # as of every row of class glm
            return self._estimates_of_values()
        b, gaps = self.method.weights, []
        for row in self.method.embedded:
            for n, (weights,) in enumerate(row.estimate(b)):
                slopes = weights[1:] if self.row_claim == NYSTROM_ORDER.key and n == 0 else weights
                total: Scalar = sum(slopes, _ZERO)
                gaps.append((total, f"the weights of the estimate {row.name} sum to"))
        return _all_zero(gaps, exact=self.exact)

    def _estimates_of_values(self) -> Known:
        """Decide that estimates ``h e F + d y`` are 0 at exact values ``u y + h v y'`` of y' = 1.

        ``V u = u, U u = 1, w u = 1, B 1 + V v = u + v``, w the output, have a solution, and
        ``d u = 0`` and ``e 1 + d v = 0`` for all of them: equations linear in (u, v).
        """
        m = self.method
        if not is_exact(m.U, m.B, m.V, (m.output or (),)):
            raise ExactnessError("estimates of several values are judged of exact coefficients")
        both = consistent_values(m.U, m.B, m.V, m.output)
        if all(x[-1].vanishes() for x in both):
            return Known(False, True, "the method is not consistent: there are no u and v")
        w = m.output or first_value(constants(m.U, m.V))
        if w is None:
            raise ExactnessError(
                "several u have V u = u and U u = 1, and they differ where the solution is read: "
                "give `output`"
            )
        gaps, slopes = [], []
        for row in m.embedded:
            (e,) = linalg.sub(linalg.matmul((w,), m.B), row.weights)
            (d,) = linalg.sub(linalg.matmul((w,), m.V), (row.values,))
            total: Scalar = sum(e, _ZERO)
            for x in both:
                u, v, one = x[: len(d)], x[len(d) : -1], x[-1]
                gaps.append(
                    (linalg.dot(d, u), f"for y' = 0 the solution less the row {row.name} is")
                )
                slope = total * one + linalg.dot(d, v)
                slopes.append(
                    (slope, f"for y' = 1 the solution less the row {row.name} is h times")
                )
        exact = self.exact and all(is_exact(x.weights, (x.values,)) for x in m.embedded)
        return _all_zero([*gaps, *slopes], exact=exact)

    def _row_sums(self) -> Known:
        """Decide c = A 1; it is where no c is given. Of Nystrom methods A 1 = c^2 / 2, A' 1 = c."""
        if self.is_pair:
            gaps = nystrom_gaps(self.method)
            if gaps is None:
                raise ExactnessError("sums of rows are those of a file of class nystrom")
            return _all_zero(gaps, exact=self.exact)
        c = self.method.abscissae_given
        if c is None:
            return Known(True)
        gaps = [
            (sum(row, _ZERO) - x, f"row {i} of A sums to c[{i}] +")
            for i, (row, x) in enumerate(zip(self.method.A, c, strict=True), 1)
        ]
        return _all_zero(gaps, exact=self.exact)

    def _dense_end(self) -> Known:
        """Decide b(1) = b."""
        if self.method.dense is None:
            return Known(False, True, "the file gives no dense output")
        gaps = [
            (sum(row, _ZERO) - x, f"b[{i}](1) differs from b[{i}] by")
            for i, (row, x) in enumerate(
                zip(self.method.dense, self.method.weights[0], strict=True), 1
            )
        ]
        return _all_zero(gaps, exact=self.exact)

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
        columns = linalg.transpose(m.dense)
        exact = self.exact and is_exact(m.dense)
        slopes = stage_slopes(m.A)
        lower, proved, sizes = 0, True, [0.0]
        for n in range(1, MAX_ORDER[0] + 1):
            for t in trees(n):
                weights = slopes(t)
                for power in range(1, max(n, len(columns)) + 1):
                    value: Scalar = _ZERO
                    if power <= len(columns):
                        value = linalg.dot(columns[power - 1], weights)
                    if power == n:
                        value = value - Exact(1) / t.density
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
