"""Newton's method on a large chain beside LAPACK: ``python -m tools.measure.compare_band``.

The reference is written with numpy and scipy from the textbook: Gauss with three stages in the
variables of Butcher (1976), one real and one complex band factored by gbtrf, the Jacobian of the
beginning of a step, kept while five rounds suffice, iterated until the change is round-off. It
knows the order (q_0, p_0, q_1, p_1, ...) in which the chain is a band, and its right-hand side is
vectorised. Processor time of one thread, in turn.
"""

from __future__ import annotations

import statistics
import sys
from typing import Any

import numpy as np
from scipy.linalg import lapack

from glmref import load, problem
from glmref.engine.kernel import prepare
from tools.measure.timing import interleaved

LAPACK: Any = lapack
LOWER, UPPER = 3, 1
_KEPT = 5  # rounds of a step up to which its matrices serve the next


class Reference:
    """Gauss with three stages on the non-separable chain with band matrices."""

    def __init__(self, sites: int, coupling: float, h: float) -> None:
        self.m, self.c, self.h, n = sites, coupling, h, 2 * sites
        method: Any = load("gauss-3")
        self.A = np.array([[float(x) for x in row] for row in method.A])
        self.b = np.array([float(x) for x in method.B[0]])
        values: Any
        T: Any
        values, T = (np.asarray(x, dtype=complex) for x in np.linalg.eig(self.A))
        real, pair = int(np.argmin(abs(values.imag))), int(np.argmax(values.imag))
        inverse: Any = np.linalg.inv(T)
        self.real, self.pair = float(values[real].real), complex(values[pair])
        self.into = inverse[real].real, inverse[pair]
        self.back = T[:, real].real, T[:, pair]
        self.bands = np.zeros((2 * LOWER + UPPER + 1, n))
        self.kept = False

    def f(self, y: np.ndarray) -> np.ndarray:
        """Return the right-hand side of stages (..., n) in the order (q_0, p_0, ...)."""
        q, p, out = y[..., 0::2], y[..., 1::2], np.empty_like(y)
        pull = -2 * q
        pull[..., 1:] += q[..., :-1]
        pull[..., :-1] += q[..., 1:]
        out[..., 0::2] = p * (1 + q * q)
        out[..., 1::2] = self.c * pull - q * (1 + p * p)
        return out

    def factor(self, y: np.ndarray) -> None:
        """Factor I - h x J for both eigenvalues."""
        q, p, J, main = y[0::2], y[1::2], self.bands, LOWER + UPPER
        J[main, 0::2], J[main - 1, 1::2] = 2 * p * q, 1 + q * q
        J[main + 1, 0::2], J[main, 1::2] = -2 * self.c - (1 + p * p), -2 * q * p
        J[main + 3, 0:-2:2], J[main - 1, 2::2] = self.c, self.c
        matrix = -self.h * self.real * J
        matrix[main] += 1
        self.lu = LAPACK.dgbtrf(matrix, LOWER, UPPER, overwrite_ab=True)[:2]
        matrix = -self.h * self.pair * J
        matrix[main] += 1
        self.lu_pair = LAPACK.zgbtrf(matrix, LOWER, UPPER, overwrite_ab=True)[:2]
        self.kept = True

    def run(self, y: np.ndarray, steps: int) -> np.ndarray:
        """Take steps from y, compensated."""
        K, e = np.tile(self.f(y), (3, 1)), np.zeros_like(y)
        for _ in range(steps):
            last, rounds = np.inf, 0
            while True:
                Y = y + self.h * (self.A @ K)
                if rounds == 0 and not self.kept:
                    self.factor(Y[0])
                residual = self.f(Y) - K
                r = self.into[0] @ residual
                z = self.into[1] @ residual
                r = LAPACK.dgbtrs(self.lu[0], LOWER, UPPER, r, self.lu[1], overwrite_b=True)[0]
                z = LAPACK.zgbtrs(
                    self.lu_pair[0], LOWER, UPPER, z, self.lu_pair[1], overwrite_b=True
                )[0]
                change = np.outer(self.back[0], r) + 2 * np.real(np.outer(self.back[1], z))
                K = K + change
                rounds += 1
                size = self.h * np.abs(change).sum()
                if size == 0 or (size >= last and size < 1e-12 * np.abs(Y).sum()):
                    break
                last = size
            self.kept = rounds <= _KEPT
            u = e + self.h * (self.b @ K)
            new = y + u
            e, y = u - (new - y), new
        return y


def measured(
    sites: int = 640, h: float = 0.02, steps: int = 100, repeats: int = 9
) -> dict[str, float]:
    """Return microseconds of a step, medians, and how far the two results are apart."""
    chain = problem("nonseparable-chain", sites=sites)
    y0 = np.array(chain.y0, dtype=float)
    kernel = prepare(load("gauss-3"), chain, h=h, solver="newton")
    other = Reference(sites, 10.0, h)
    order = np.arange(2 * sites).reshape(2, sites).T.ravel()
    slope, out, ends = np.asarray(chain.f(0.0, y0)), np.zeros((1, 1, 2 * sites)), {}

    def ours() -> None:
        state = kernel.state(y0[None], slope, h)
        kernel.advance(state, steps, t0=0.0, h=h, every=0, out=out)
        ends["kernel"] = kernel.values(state)[0]

    def theirs() -> None:
        other.kept = False
        ends["reference"] = other.run(y0[order], steps)

    spent = interleaved({"kernel": ours, "reference": theirs}, repeats)
    found = {name: 1e6 * statistics.median(times) / steps for name, times in spent.items()}
    return found | {"apart": float(np.abs(ends["kernel"][order] - ends["reference"]).max())}


if __name__ == "__main__":
    for count in (40, 160, 640):
        row = measured(count)
        sys.stdout.write(f"{count:5d} sites: {row}\n")
