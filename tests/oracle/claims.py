"""What the oracle says of a claim: ``True``, ``False``, or ``None`` near a boundary or out of reach."""

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from mpmath import mp

from .energies import energy_defect, power, symplectic_defect
from .methods import File, Method, Part, runge_kutta, single
from .numbers import Array, Margin, Number, Reader, Undecided, array, eye, zeros
from .orders import Series, Starting, exact, number, ones_of, stage_order, starting_order, trees

#: Radius of M(z) above 1 that a sample may have, and that refutes.
STABLE, UNSTABLE = mp.mpf(10) ** -70, mp.mpf(10) ** -15
#: Eigenvalues on the circle are known to 70 digits.
SPECTRAL = Margin(mp.mpf(10) ** -60, mp.mpf(10) ** -40)


def opinion(document: Mapping[str, Any], claim: str, declared: Any,
            base: Mapping[str, Any] | None = None) -> bool | None:  # fmt: skip
    """Return whether a claim is true of a document, ``None`` where the oracle does not know."""
    dps = mp.dps
    try:
        return Oracle(document, base).judge(claim, declared)
    except Undecided:
        return None
    finally:
        mp.dps = dps


def angle(z: Number) -> Number:
    return mp.arg(z) % (2 * mp.pi) if abs(z - 1) > 1e-20 else 0


class Oracle:
    """One document and what was found out about it."""

    def __init__(self, document: Mapping[str, Any], base: Mapping[str, Any] | None = None) -> None:
        self.file = File(document, base)
        self.document, self.margin, self.method = document, self.file.margin, self.file.method
        self.parts, self.kind = self.method.parts, self.file.kind
        self.starts: dict[Any, Starting] = {}

    def judge(self, claim: str, declared: Any) -> bool | None:
        """Return whether a claim holds."""
        try:
            rule = RULES.get(claim) or getattr(Oracle, "_" + claim.replace("-", "_"))
            found = rule(self) if isinstance(declared, int) else rule(self, declared)
            if isinstance(found, Starting):
                return self._compare(found, declared)
            if isinstance(found, list):  # what is to vanish
                found = self.margin.zeros(flat(found))
            return found if found is None or not isinstance(declared, int) else found == declared
        except (Undecided, ZeroDivisionError, StopIteration, RuntimeError) as error:
            self.why = str(error)
            return None

    @staticmethod
    def _compare(found: Starting, declared: int) -> bool | None:
        if found.most is None:
            return False if declared < found.order else None
        return found.order == declared

    # orders

    def start(self, identity: bool, nystrom: bool = False) -> Starting:
        """Return the starting series of the method."""
        if (identity, nystrom) not in self.starts:
            timed = self.file.timed(self.method)
            self.starts[identity, nystrom] = Starting(timed, self.margin, identity, nystrom)
        return self.starts[identity, nystrom]

    @staticmethod
    def reached(q: int, start: Starting) -> int:
        """Return an order that cannot be more than the one of the method, which must be known."""
        if start.most is None and q == start.order:
            raise Undecided("the order is beyond reach")
        return q

    def starting_order(self, nystrom: bool = False) -> int:
        start, d = self.start(self.method.pair, nystrom), self.document.get("starting")
        hats = {"f": "", "k": "_hat"} if self.method.pair else {"o": ""}
        if d is None and not self.method.pair:
            return 0
        if d is None:  # (y, 0, ..)
            d = {x + h: y for c, h in hats.items() for r in [self.parts[c].r] for x, y in (
                ("A", [["0"]]), ("B", [["0"]] * r), ("u", ["1"] + ["0"] * (r - 1)))}  # fmt: skip
        u = {c: self.file.read(d["u" + h]) for c, h in hats.items()}
        run = Series({c: self._plain(d, h) for c, h in hats.items()})
        return self.reached(starting_order(start, run, u), start)

    def _plain(self, block: Mapping[str, Any], hat: str = "") -> Part:
        A, B = (self.file.read(block[x + hat]) for x in "AB")
        return Part(A, A[:, :0], B, B[:, :0])

    def _finishing_order(self) -> int:
        d, start, read = self.document, self.start(self.method.one), self.file.read
        if "finishing" not in d or "starting" not in d or not start.order:
            return 0
        w, run = start.w["o"], Series({"o": self._plain(d["starting"])})
        if not self.margin.zero(w @ read(d["starting"]["u"]) - 1):
            return 0
        finish = Series({"o": self.file.finish(d["finishing"])})
        for q in range(1, start.order + 1):
            for t in trees((("o", "o"),), q):
                finish.eta[t] = array([w @ run.values(t)])
                if not self.margin.zero(finish.values(t)[0]):
                    return q - 1
        return self.reached(start.order, start)

    def _embedded_order(self, declared: Mapping[str, int]) -> bool | None:
        if self.kind == "glm":
            raise Undecided("values moved")
        rows, own = self.file.embedded(), self.kind == "nystrom"
        if set(rows) != set(declared):
            return False
        answers = [self._compare(Starting(m, self.margin, True, own), declared[name])
                   for name, m in rows.items()]  # fmt: skip
        return False if False in answers else None if None in answers else True

    def _order_to_digits(self, declared: Mapping[str, Any]) -> bool | None:
        answers = []
        for name, method in {"b": self.file.timed(self.method), **self.file.embedded()}.items():
            p, text = declared[name]
            top, unit = mp.mpf(text), mp.mpf(10) ** (int(text.partition("e")[2]) - 1)
            start = Starting(method, self.margin, True, self.kind == "nystrom", limit=0)
            if start.work(p + 1) > 400_000:
                return None
            sizes = [max((abs(start.values(t)[0] - number(exact(t))) for t in start.pool(n)), default=0)
                     for n in range(1, p + 2)]  # fmt: skip
            answers.append(top - unit < max(sizes[:-1]) <= top and sizes[-1] > 1000 * top)
        return all(answers)

    # values carried

    def ones(self, c: str) -> tuple[Array | None, Array]:
        """Return u and what may be added to it."""
        return ones_of(self.method, self.margin, c)

    def _consistent(self) -> bool:
        answers = []
        for m in self.parts.values():  # u and v together
            shift, Z = m.V - eye(m.r), zeros(m.r + len(m.U), m.r)
            rows = np.block([[np.vstack([shift, m.U]), Z], [-eye(m.r), shift]])
            right = np.hstack([zeros(m.r), zeros(len(m.U)) + 1, -m.B.sum(axis=1)])
            answers.append(self.margin.solve(rows, right) is not None)
        return all(answers)

    def _abscissae(self, declared: list[str]) -> bool:
        start, found = Starting(self.method, self.margin, True, limit=1), []
        if not start.order:
            return False
        for c, m in self.parts.items():
            if len(start.N[c]) > 1:
                raise Undecided("v is not determined")
            k = next(k for k, x in enumerate(start.eta[c, None]) if not self.margin.zero(x))
            v, nu = start.eta.get((c, ()), zeros(m.r)), start.N[c][0]
            found += list(m.A.sum(axis=1) + m.U @ (v - nu * (v[k] / nu[k])))
        given = Reader({})(declared)
        return len(found) == len(given) and self.margin.zeros(found - given)

    def _explicit(self) -> bool:
        tables = [m.A for m in self.parts.values()]
        if self.method.separable:
            tables = [crossed(*tables)]
        left = {i: {j for A in tables for j, x in enumerate(A[i]) if not self.margin.zero(x)}
                for i in range(len(tables[0]))}  # fmt: skip
        while ready := [i for i, x in left.items() if not x & set(left)]:
            for i in ready:
                del left[i]
        return not left

    def _error_constant(self, declared: str) -> list[Number]:
        alpha, beta = self.file.get("alpha", "beta")
        m = np.arange(len(alpha)).astype(object)
        for q in range(30):
            C = alpha @ m**q - (beta @ m ** (q - 1) * q if q else 0)
            if not self.margin.zero(C):
                return [C / mp.factorial(q) - Reader({})[declared] * beta.sum()]
        raise Undecided("the order is beyond reach")

    def _row_sums(self) -> list[Array]:
        if "c" not in self.document:
            return []
        A, c = self.file.get("A", "c")
        if self.kind != "nystrom":
            return [A.sum(axis=1) - c]
        inner = self.file.get("A_prime").sum(axis=1) if "A_prime" in self.document else c
        return [2 * A.sum(axis=1) - c**2, inner - c]

    def _dense_end(self) -> list[Array] | bool:
        return "dense" in self.document and [
            self.file.get("dense").sum(axis=1) - self.parts["o"].B[0]
        ]

    def _dense_order(self) -> int:
        """Return the order of the steps of theta h, for as many theta as polynomials are known by."""
        if "dense" not in self.document:
            return 0
        if not self.margin.zeros(flat(self._row_sums())):
            raise Undecided("c apart")
        rows, A, starts = self.file.get("dense"), self.parts["o"].A, []
        degree = rows.shape[1]
        for theta in (mp.mpf(k) / 17 for k in range(1, max(degree, 8) + 1)):
            b = rows @ array([theta**k for k in range(degree)])
            step = single(runge_kutta(A / theta, b))
            starts.append(Starting(step, self.margin, True, limit=8))
        return self.reached(*min(((start.order, start) for start in starts), key=lambda x: x[0]))

    def _embedded_difference(self) -> list[Number]:
        if self.kind == "glm":
            raise Undecided("values moved")
        gaps: list[Number] = []
        for method in self.file.embedded().values():
            same = set(method.parts) == set(self.parts)
            own = self.method if same else self.file.timed(self.method)
            for c, m in method.parts.items():
                first = int(self.kind == "nystrom" and c == "f")
                gaps.append((own.parts[c].B[0] - m.B[0])[first:].sum())
        return gaps or [1]

    def _reducible(self) -> bool:
        found = []
        for c, m in self.parts.items():
            u, free = self.ones(c)
            if len(free):
                return True
            for M, x in ((m.V, self._first(m, u)), (m.V.T, m.U.T)):
                found.append(self.margin.rank(krylov(M, x).T) < m.r)
        return any(found)

    @staticmethod
    def _first(m: Part, u: Array | None) -> Array:
        return m.B if u is None else np.column_stack([m.B, u]).view(Array)

    # forms and symmetry

    def _symplectic(self) -> list[Array] | bool:
        if not self.method.one:
            return False
        q, p = self._ends()
        b, c = q.B[0], p.B[0]
        gaps = [b[:, None] * p.A + (c[:, None] * q.A).T - np.outer(b, c)]
        gaps += [x - 1 for m in self.parts.values() for x in (m.U, m.V)]
        return gaps if not self.method.pair or self.method.separable else [*gaps, b - c]

    def _ends(self) -> tuple[Part, Part]:
        parts = list(self.parts.values())
        return parts[0], parts[-1]

    def _defects(self, G: Array, D: Array, E: Array) -> Array:
        q, p = self._ends()
        return flat([
            q.V.star @ G @ p.V - G,
            D[:, None] * p.U - q.B.star @ G @ p.V,
            E[:, None] * q.U - p.B.star @ G.star @ q.V,
            D[:, None] * p.A + q.A.star * E - q.B.star @ G @ p.B,
            [] if self.method.separable else D - E,
            [] if self.method.pair else G - G.star,
            [mp.im(x) for x in (*D, *E)],
        ])  # fmt: skip

    def power(self, defect: Any) -> int | None:
        m = self.parts.get("o")
        if m is None or not self.method.one or "digits" in self.document:
            raise Undecided("a method that carries several values, or decimals")
        ones = [*flat([m.U, m.V]) - 1, m.B.sum() - 1]
        if not self.margin.zeros(ones) or any(map(mp.im, flat([m.A, m.B]))):
            raise Undecided("a step that is not consistent, or not real")
        return power(defect, m)

    def _conjugate_symplectic_order(self) -> int:
        self._conjugate_symplectic()  # orders in other variables
        return -1

    def _conjugate_symplectic(self) -> bool:
        """A form decides; that there is no change of variables is not looked for."""
        m = self.parts["o"]
        simple = len(self.margin.null(m.V - eye(m.r))) == 1
        if simple and not any(map(mp.im, flat([m.A, m.U, m.B, m.V]))) and self._g_symplectic():
            return True
        raise Undecided("conjugate by another reason")

    def _g_symplectic(self) -> bool:
        ends = next(iter(self.parts)), list(self.parts)[-1]
        (u, free), (v, more) = map(self.ones, ends)
        if u is None or v is None:
            return False
        if len(free) or len(more):
            raise Undecided("u is not determined")
        (q, p), pair = self._ends(), self.method.pair
        if "G" in self.document:
            G = self.file.form()
            own = [q.B.star @ G @ v, p.B.star @ G.star @ u]
            for key, k in (("D", 0), ("D_P", 0), ("D_Q", 1)) if self.kind != "sweep" else ():
                if key in self.document:
                    own[k] = self.file.get(key)
            D, E = own if pair else own[:1] * 2
            return self.margin.zeros(self._defects(G, D, E)) and not self.margin.zero(
                u.conj() @ G @ v
            )
        # what is real-linear: the parts of G, D, E
        m, s, n, k = q.r, p.r, q.B.shape[1], p.B.shape[1]
        units, energies = [], []
        for x in eye(2 * m * s + n + (k if pair else 0)):
            re, im, D, E = np.split(x, np.cumsum([m * s, m * s, n]))
            G = (re + im * mp.mpc(0, 1)).reshape(m, s)
            units.append(self._defects(G, D, E if pair else D))
            energies.append(u.conj() @ G @ v)
        images = [np.frompyfunc(part, 1, 1)(array(units).T) for part in (mp.re, mp.im)]
        system = [row for image in images for row in image if any(row)]
        forms = self.margin.null(array(system).reshape(-1, len(units)))
        return any(not self.margin.zero(x) for x in forms @ array(energies))

    def is_symmetric(self, method: Method) -> bool:
        """Return whether the step run backwards is the step, up to L and the order of the stages."""
        backward = {}
        for c, m in method.parts.items():
            back = self.margin.inverse(m.V)
            if back is None:
                return False
            backward[c] = Part(m.U @ back @ m.B - m.A, m.U @ back, back @ m.B, back)
        doubt = False
        for P in self._exchanges(method, backward):
            answers = [self._reversal(m, backward[c], *P[c]) for c, m in method.parts.items()]
            if all(answers):
                return True
            doubt = doubt or False not in answers
        if doubt:
            raise Undecided("L is not determined")
        return False

    def _exchanges(self, method: Method, backward: Mapping[str, Part]) -> Iterator[dict[str, Any]]:
        """Yield {colour: (permutation of stages, of slopes)} that carry A into the A backwards."""
        tables = [(m.A, backward[c].A) for c, m in method.parts.items()]
        head = len(tables[0][0])
        if method.separable:
            tables = [tuple(crossed(f, k) for f, k in zip(*tables, strict=True))]
        n, steps = len(tables[0][0]), 0

        def place(P: dict[int, int]) -> Iterator[dict[int, int]]:
            nonlocal steps
            steps += 1
            if steps > 3000:
                raise Undecided("too many permutations")
            rest = [x for x in range(n) if x not in P]
            if not rest:
                yield P
                return
            for y in reversed(rest):  # of a palindrome the last first
                Q = {**P, rest[0]: y, y: rest[0]}
                if method.separable and (y < head) != (rest[0] < head):
                    continue
                pairs = [(a, b) for x in (rest[0], y) for z in Q for a, b in ((x, z), (z, x))]
                if all(
                    self.margin.zero(A[a, b] - back[Q[a], Q[b]])
                    for a, b in pairs
                    for A, back in tables
                ):
                    yield from place(Q)

        for P in place({}):
            found = [P[i] for i in range(n)]
            if method.separable:
                lists = found[:head], [x - head for x in found[head:]]
                yield dict(zip(method.parts, (lists, lists[::-1]), strict=True))
            else:
                yield dict.fromkeys(method.parts, (found, found))

    def _reversal(self, m: Part, back: Part, stages: list[int], slopes: list[int]) -> bool | None:
        """Return whether an involution L carries U, B, V into those backwards, None if unsure."""
        I = eye(m.r)
        L, more = self.margin.general(
            np.vstack([np.kron(m.U[stages], I), np.kron(I, m.B[:, slopes].T),
                       np.kron(m.V, I) - np.kron(I, back.V.T)]),
            np.hstack([back.U.ravel(), back.B.ravel(), zeros(m.r**2)]),
        )  # fmt: skip
        if L is None:
            return False
        L = L.reshape(m.r, m.r)
        return True if self.margin.zeros(L @ L - I) else None if len(more) else False

    def _symmetric_reduced(self) -> bool:
        m = self.parts["o"]
        basis = self.margin.echelon(krylov(m.V, self._first(m, self.ones("o")[0])).T)[0].T
        if not basis.size:
            raise Undecided("no value is left")
        V, B = (self.margin.solve(basis, M) for M in (m.V @ basis, m.B))
        U = m.U @ basis
        rows = self.margin.echelon(krylov(V.T, U.T).T)[0]
        if not rows.size:
            raise Undecided("no value is left")
        U, V = (self.margin.solve(rows.T, M.T).T for M in (U, rows @ V))
        return self.is_symmetric(single(Part(m.A, U, rows @ B, V)))

    # spectra

    @cached_property
    def spectra(self) -> dict[str, list[tuple[Number, int]] | None]:
        """Eigenvalues of V of modulus 1 with their numbers, ``None`` where powers grow."""
        if not self.file.exact_V:
            raise Undecided("V in decimals")
        return {c: self._circle(m.V) for c, m in self.parts.items()}

    @property
    def zero_stable(self) -> bool:
        return all(x is not None for x in self.spectra.values())

    def _circle(self, V: Array) -> list[tuple[Number, int]] | None:
        found, outside = [], False
        for z, n in clusters(V):
            off = abs(z) - 1
            if abs(off) < mp.mpf(10) ** -70:
                if len(eigenvectors(V, z)) < n:
                    return None
                found.append((z, n))
            elif abs(off) < mp.mpf(10) ** -20:
                raise Undecided("an eigenvalue near the circle")
            outside = outside or off > 0.5 * mp.mpf(10) ** -20
        return None if outside else found

    def _groups(self) -> list[tuple[Number, Array, bool]]:
        """Return (zeta, growth matrix, whether it is the one at 1)."""
        found = []
        for c, values in self.spectra.items():
            for z, _ in values or ():
                for other in self.method.children[c]:
                    m, one = self.parts[c], abs(z - 1) < 1e-20
                    if self.method.pair and (other == c or one):
                        continue
                    if not any(abs(y - z) < 1e-20 for y, _ in self.spectra[other] or ()):
                        continue
                    N, W = eigenvectors(self.parts[other].V, z), eigenvectors(m.V.T, z)
                    norm = self.margin.inverse(W @ eigenvectors(m.V, z).T)
                    assert norm is not None
                    found.append((z, norm @ W @ m.B @ self.parts[other].U @ N.T / z, one))
        return sorted(found, key=lambda g: angle(g[0]))

    def _parasitism_free(self) -> bool:
        if not self.zero_stable:
            return False
        if self.method.pair and (not self.method.separable or any(
                n > 1 for x in self.spectra.values() for z, n in x or () if abs(z - 1) < 1e-20)):  # fmt: skip
            raise Undecided("stages that are shared")
        for _, M, one in self._groups():
            if one and len(M) > 1:
                rank, trace = self.margin.rank(M), np.diag(M).sum()
                if rank > 1 or (rank == 1 and self.margin.zero(trace)):
                    return False
                if rank == 0 or not self.margin.zero(trace - 1):
                    raise Undecided("no growth parameter belongs to the principal component")
            elif not one and not self.loosely(M.flat):
                return False
        return True

    @staticmethod
    def loosely(values: Any) -> bool:
        """Return whether numbers that come from eigenvalues vanish."""
        most = max(map(abs, values), default=mp.mpf(0))
        if 1e-60 < most < 1e-15:
            raise Undecided("a growth parameter near 0")
        return bool(most <= 1e-60)

    def _growth(self, declared: list[str]) -> bool:
        if not self.zero_stable:
            return False
        given, groups = list(Reader({})(declared)), self._groups()
        if self.method.pair:
            if not self.method.separable:
                raise Undecided("stages that are shared")
            numbers = [x for _, M, _ in groups for x in M.flat]
            if any(abs(x) > 1e-20 for x in [*given, *numbers]):
                raise Undecided("growth of pairs")
            return len(given) == len(numbers)
        if len(given) != sum(len(M) - int(one) for _, M, one in groups):
            return False
        for _, M, one in groups:
            mine, given = given[: len(M) - int(one)], given[len(M) - int(one) :]
            roots = mine + [mp.mpf(1)] * int(one)
            for k in (mp.mpf(7) / 3, mp.mpf(-5) / 7, mp.mpc(2, 3), mp.mpf(11) / 13, mp.mpf(4)):
                value = mp.det(mp.matrix((eye(len(M)) * k - M).tolist()))
                if len(M) > int(one) and not self.loosely([value - mp.fprod(k - x for x in roots)]):
                    return False
        return True

    def _second_order_growth(self, declared: list[str]) -> bool:
        m, solve = self.parts["o"], self.margin.solve
        (u, _), groups = self.ones("o"), self._groups()
        if any(len(M) > 1 or not (one or self.loosely(M.flat)) for _, M, one in groups):
            raise Undecided("eigenvalues are multiple, or a growth parameter is not 0")
        shift = eye(m.r) - m.V
        v = None if u is None else solve(shift, m.B.sum(axis=1) - u)
        if v is None:
            raise Undecided("the method is not consistent")
        c = m.A.sum(axis=1) + m.U @ v
        x = solve(shift, m.B @ c - u / 2 - v)
        if x is None:
            raise Undecided("the order is below 2")
        bend = m.A @ c + m.U @ x - c**2 / 2
        found, step = [], mp.mpf(10) ** -15
        for z in (z for z, _, one in groups if not one):
            (w,), (n,) = eigenvectors(m.V.T, z), eigenvectors(m.V, z)
            logs = [mp.log(min(eigenvalues(self.at(h)), key=lambda y: abs(y - z)) / z)
                    for h in (step, -step)]  # fmt: skip
            if abs(mp.re(logs[0] + logs[1])) > step**3:
                raise Undecided("a part grows by h f' f'")
            found += [w @ m.B @ (m.U @ n * bend) / (w @ n) / z, (logs[0] - logs[1]) / (2 * step**3)]
        given = Reader({})(declared)
        close = [abs(x - y) for x, y in zip(found, given, strict=False)]
        return len(found) == len(given) and max(close, default=0) < mp.mpf(10) ** -20

    def at(self, z: Number) -> Array:
        """Return M(z)."""
        m = self.file.linear()
        back = self.margin.inverse(eye(len(m.A)) - m.A * z)
        if back is None:
            raise Undecided("a pole")
        return m.V + m.B @ back @ m.U * z

    def _a_stable(self) -> bool:
        """Return whether samples of M(i y) have no eigenvalue outside, and poles lie to the right.

        A sample outside by more than :data:`UNSTABLE` refutes; what is outside by less is undecided.
        That nothing is outside between the samples is not proved.
        """
        if self.file.rounded:
            raise Undecided("decimals")
        m = self.file.linear()
        if self._circle(m.V) is None:
            return False
        for z, _ in clusters(m.A):  # a pole 1 / z that M(z) may have
            if mp.re(z) < -1e-20 or (abs(mp.re(z)) < 1e-20 and abs(z) > 1e-20):
                if max(abs(self.at(1 / z * (1 + mp.mpf(10) ** -30))).flat) > 1e12:
                    return False
                raise Undecided("a pole that M may not have")
        worst = mp.mpf(0)
        for k in range(-24, 25):
            M = self.at(mp.mpc(0, mp.mpf(10) ** (mp.mpf(k) / 6 if abs(k) < 24 else k)))
            for z, n in clusters(M):
                worst = max(worst, abs(z))
                if n > 1 and abs(abs(z) - 1) < 1e-25 and len(eigenvectors(M, z)) < n:
                    return False
        if STABLE < worst - 1 <= UNSTABLE:
            raise Undecided("an eigenvalue near the circle")
        return bool(worst <= 1 + STABLE)

    def _l_stable(self) -> bool:
        if not self._a_stable():
            return False
        sizes = [max(abs(x) for x, _ in clusters(self.at(-(mp.mpf(10) ** k)))) for k in (60, 75)]
        if sizes[1] == 0 or sizes[1] < sizes[0] / 50:
            return True
        # an explicit first stage makes z of the rounding errors of the entries
        if sizes[1] < sizes[0] / 2 or sizes[1] < mp.mpf(10) ** (75 + 10 - mp.dps):
            raise Undecided("a slow limit, or one of rounding errors")
        return False


#: What a claim is read from directly; the others are methods of their names.
RULES: dict[str, Callable[[Oracle], Any]] = {
    "order": lambda o: o.start(o.method.one),
    "order-identity": lambda o: o.start(True),
    "effective-order": lambda o: o.start(False),
    "nystrom-order": lambda o: o.start(True, True),
    "w-order": lambda o: Starting(o.file.rosenbrock(counts=lambda t: True), o.margin, True),
    "stage-order": lambda o: o.reached(stage_order(o.start(o.method.one)), o.start(o.method.one)),
    "starting-order": lambda o: o.starting_order(),
    "nystrom-starting-order": lambda o: o.starting_order(nystrom=True),
    "preconsistent": lambda o: all(o.ones(c)[0] is not None for c in o.parts),
    "zero-stable": lambda o: o.zero_stable,
    "symmetric": lambda o: o.is_symmetric(o.method),
    "energy-order": lambda o: o.power(energy_defect),
    "hamiltonian-to-order": lambda o: -1 if (n := o.power(symplectic_defect)) is None else n,
}


def flat(values: list[Any]) -> Array:
    """Return all entries."""
    return array([x for M in values for x in np.ravel(M)])


def crossed(f: Array, k: Array) -> Array:
    """Return the table of the stages of both parts, of which each calls the slopes of the other."""
    return np.block([[zeros(len(f), len(f)), f], [k, zeros(len(k), len(k))]])


def krylov(M: Array, x: Array) -> Array:
    """Return the columns x, M x, M^2 x, .."""
    found = [x]
    for _ in M:
        found.append(M @ found[-1])
    return np.hstack(found).view(Array)


def eigenvectors(M: Array, z: Number) -> Array:
    return SPECTRAL.null(M - eye(len(M)) * z)


def eigenvalues(M: Array) -> list[Number]:
    return list(mp.eig(mp.matrix(M.tolist()), left=False, right=False))


def clusters(M: Array) -> list[tuple[Number, int]]:
    """Return the eigenvalues of M with their multiplicities: mean values of what lies together."""
    if len(M) == 1:
        return [(M[0, 0], 1)]
    found: list[list[Number]] = []
    for z in eigenvalues(M):
        radius = mp.mpf(10) ** -(mp.dps // len(M) - 2)
        near = next((x for x in found if abs(x[0] - z) < radius), None)
        if near is None:
            found.append([z])
        else:
            near.append(z)
    return [(sum(x) / len(x), len(x)) for x in found]
