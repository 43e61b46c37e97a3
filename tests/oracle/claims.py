"""What the oracle says of a claim: ``True``, ``False``, or ``None`` near a boundary or out of reach."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

from mpmath import mp

from .energies import energy_defect, power, symplectic_defect
from .methods import File, Method, Part, single, unequal
from .numbers import (
    Margin,
    Matrix,
    Number,
    Reader,
    Undecided,
    Vector,
    at,
    dot,
    eye,
    flat,
    plus,
    star,
    times,
    transposed,
)
from .orders import Run, Starting, exact, number, ones_of, stage_order, starting_order, trees

#: Radius of M(z) above 1 that a sample may have, and that refutes.
STABLE, UNSTABLE = mp.mpf(10) ** -70, mp.mpf(10) ** -15


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


class Oracle:
    """One document and what was found out about it."""

    def __init__(self, document: Mapping[str, Any], base: Mapping[str, Any] | None = None) -> None:
        self.file = File(document, base)
        self.document, self.margin, self.method = document, self.file.margin, self.file.method
        self.starts: dict[Any, Starting] = {}

    def judge(self, claim: str, declared: Any) -> bool | None:
        """Return whether a claim holds."""
        try:
            if claim in ("embedded-order",):
                return self._embedded_order(declared)
            rule = getattr(self, "_" + claim.replace("-", "_"))
            if isinstance(declared, bool):
                return bool(rule()) == declared
            if isinstance(declared, int):
                found = rule()
                if isinstance(found, Starting):
                    return self._compare(found, declared)
                return None if found is None else found == declared
            return rule(declared)
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

    def _order(self) -> Starting:
        return self.start(self.method.one)

    def _order_identity(self) -> Starting:
        return self.start(True)

    def _effective_order(self) -> Starting:
        return self.start(False)

    def _nystrom_order(self) -> Starting:
        return self.start(True, True)

    def _w_order(self) -> Starting:
        return Starting(
            self.file.rosenbrock_with(self.document["b"], lambda t: True), self.margin, True
        )

    def _stage_order(self) -> int:
        start = self._order()
        q = stage_order(start)
        if start.most is None and q == start.order:
            raise Undecided("the order is beyond reach")
        return q

    def _starting_order(self, nystrom: bool = False) -> int:
        start, d = self.start(self.method.pair, nystrom), self.document.get("starting")
        if d is None and not self.method.pair:
            return 0
        hats = {"o": ""} if not self.method.pair else {"f": "", "k": "_hat"}
        if d is None:
            none = [[mp.mpf(0)]]
            tables = {c: (none, none * self.method.parts[c].r) for c in hats}
            u = {c: [mp.mpf(int(k == 0)) for k in range(self.method.parts[c].r)] for c in hats}
        else:
            read = self.file.read
            tables = {
                c: (read.matrix(d["A" + h]), read.matrix(d["B" + h])) for c, h in hats.items()
            }
            u = {c: read.vector(d["u" + h]) for c, h in hats.items()}
        if start.most == 0 and len(start.u) < len(self.method.parts):
            return 0
        q = starting_order(start, Run(tables), u)
        if start.most is None and q == start.order:
            raise Undecided("the order is beyond reach")
        return q

    def _nystrom_starting_order(self) -> int:
        return self._starting_order(nystrom=True)

    def _finishing_order(self) -> int:
        d = self.document
        if "finishing" not in d or "starting" not in d:
            return 0
        start, read = self._order(), self.file.read
        run = Run({"o": (read.matrix(d["starting"]["A"]), read.matrix(d["starting"]["B"]))})
        A, b = read.matrix(d["finishing"]["A"]), read.vector(d["finishing"]["b"])
        if "o" not in start.w:
            return 0
        w = start.w["o"]
        if not self.margin.zero(dot(w, read.vector(d["starting"]["u"])) - 1):
            return 0
        finish = Run({"o": (A, [b])}, lambda t: [dot(w, run.values(t))] * len(A))
        for q in range(1, start.order + 1):
            for t in trees((("o", "o"),), q):
                if not self.margin.zero(finish.values(t)[0] + dot(w, run.values(t))):
                    return q - 1
        if start.most is None:
            raise Undecided("the order is beyond reach")
        return start.order

    def _embedded_order(self, declared: Mapping[str, int]) -> bool | None:
        if self.file.kind == "glm":
            raise Undecided("values moved")
        rows, answers = self.file.embedded(), []
        if set(rows) != set(declared):
            return False
        for name, method in rows.items():
            start = Starting(method, self.margin, True, self.file.kind == "nystrom")
            answers.append(self._compare(start, declared[name]))
        return False if False in answers else None if None in answers else True

    def _order_to_digits(self, declared: Mapping[str, Any]) -> bool | None:
        plain, answers = self.file.timed(self.method), []
        for name, method in {"b": plain, **self.file.embedded()}.items():
            p, text = declared[name]
            top, unit = mp.mpf(text), mp.mpf(10) ** (int(text.partition("e")[2]) - 1)
            start = Starting(method, self.margin, True, self.file.kind == "nystrom", limit=0)
            if start._work(p + 1) > 400_000:
                return None
            sizes = {n: max((abs(start.values(t)[0] - number(exact(t))) for t in start.pool(n)), default=0)
                     for n in range(1, p + 2)}  # fmt: skip
            largest = max(sizes[n] for n in range(1, p + 1))
            answers.append(top - unit < largest <= top and sizes[p + 1] > 1000 * top)
        return all(answers)

    # values carried

    def _preconsistent(self) -> bool:
        return all(ones_of(self.method, self.margin, c)[0] is not None for c in self.method.parts)

    def _consistent(self) -> bool:
        for m in self.method.parts.values():  # u and v together
            n = m.r
            zero = [mp.mpf(0)] * n
            shift, unit = plus(m.V, eye(n), -1), eye(n)
            rows = [[*x, *zero] for x in [*shift, *m.U]] + [
                [*(-y for y in e), *x] for e, x in zip(unit, shift, strict=True)
            ]
            right = zero + [mp.mpf(1)] * len(m.U) + [-sum(x) for x in m.B]
            if self.margin.solve(rows, right) is None:
                return False
        return True

    def _abscissae(self, declared: list[str]) -> bool:
        given, found = [Reader({})(x) for x in declared], []
        for c in self.method.parts:
            m, start = self.method.parts[c], Starting(self.method, self.margin, True, limit=1)
            if start.most == 0 and start.order == 0:
                return False
            if len(start.N[c]) > 1:
                raise Undecided("v is not determined")
            k = next(k for k, x in enumerate(start.u[c]) if not self.margin.zero(x))
            v, nu = start.eta[c, ()], start.N[c][0]
            v = [x - v[k] / nu[k] * y for x, y in zip(v, nu, strict=True)]
            found += [sum(row) + x for row, x in zip(m.A, at(m.U, v), strict=True)]
        return len(found) == len(given) and self.margin.zeros(
            [x - y for x, y in zip(found, given, strict=True)]
        )

    def _explicit(self) -> bool:
        m = self.method
        if m.separable:
            shift = len(m.parts["f"].A)
            needs = [
                {shift + j for j, x in enumerate(row) if not self._nil(x)} for row in m.parts["f"].A
            ]
            needs += [{j for j, x in enumerate(row) if not self._nil(x)} for row in m.parts["k"].A]
        else:
            n = len(next(iter(m.parts.values())).A)
            needs = [
                {j for j in range(n) if any(not self._nil(x.A[i][j]) for x in m.parts.values())}
                for i in range(n)
            ]
        left = dict(enumerate(needs))
        while ready := [i for i, x in left.items() if not x & set(left)]:
            for i in ready:
                del left[i]
        return not left

    def _nil(self, x: Number) -> bool:
        return self.margin.zero(x)

    def _error_constant(self, declared: str) -> bool:
        alpha, beta = (self.file.read.vector(self.document[x]) for x in ("alpha", "beta"))
        for q in range(30):
            C = sum(a * mp.mpf(m) ** q for m, a in enumerate(alpha))
            C -= q * sum(b * mp.mpf(m) ** (q - 1) for m, b in enumerate(beta)) if q else 0
            if not self.margin.zero(C):
                return self.margin.zero(C / mp.factorial(q) - Reader({})(declared) * sum(beta))
        raise Undecided("the order is beyond reach")

    def _row_sums(self) -> bool:
        d, read = self.document, self.file.read
        if "c" not in d:
            return True
        c, sums = read.vector(d["c"]), [sum(x) for x in read.matrix(d["A"])]
        if self.file.kind != "nystrom":
            return self.margin.zeros([x - y for x, y in zip(sums, c, strict=True)])
        inner = [sum(x) for x in read.matrix(d["A_prime"])] if "A_prime" in d else c
        return self.margin.zeros([2 * x - y * y for x, y in zip(sums, c, strict=True)]
                                 + [x - y for x, y in zip(inner, c, strict=True)])  # fmt: skip

    def _dense_end(self) -> bool:
        if "dense" not in self.document:
            return False
        ends = [sum(x) for x in self.file.read.matrix(self.document["dense"])]
        return self.margin.zeros(
            [x - y for x, y in zip(ends, self.method.parts["o"].B[0], strict=True)]
        )

    def _dense_order(self) -> int:
        """Return the order at seven values of theta, which polynomials of the degree are known by."""
        if "dense" not in self.document:
            return 0
        rows, m = self.file.read.matrix(self.document["dense"]), self.method.parts["o"]
        if not self._row_sums():
            raise Undecided("c apart")
        run = Run({"o": (m.A, m.B)})
        for n in range(1, 9):
            for t in trees((("o", "o"),), n):
                for theta in (mp.mpf(k) / 17 for k in range(1, max(len(rows[0]), n) + 1)):
                    b = [sum(x * theta ** (k + 1) for k, x in enumerate(row)) for row in rows]
                    if not self.margin.zero(dot(b, run.slopes(t)) - number(exact(t)) * theta**n):
                        return n - 1
        raise Undecided("the order is beyond reach")

    def _embedded_difference(self) -> bool:
        if self.file.kind == "glm":
            raise Undecided("values moved")
        rows, gaps = self.file.embedded(), []
        for method in rows.values():
            own = (
                self.file.timed(self.method)
                if set(method.parts) != set(self.method.parts)
                else self.method
            )
            gaps += [sum(own.parts[c].B[0]) - sum(m.B[0]) if self.file.kind != "nystrom" or c == "k"
                     else sum(own.parts[c].B[0][1:]) - sum(m.B[0][1:]) for c, m in method.parts.items()]  # fmt: skip
        return bool(rows) and self.margin.zeros(gaps)

    def _reducible(self) -> bool:
        found = []
        for c, m in self.method.parts.items():
            u, free = ones_of(self.method, self.margin, c)
            if free:
                return True
            reached, seen = transposed(m.B) + ([u] if u else []), list(m.U)
            for _ in range(m.r):
                reached, seen = (
                    reached + [at(m.V, x) for x in reached[-len(m.B[0]) - 1 :]],
                    seen + times(seen[-len(m.U) :], m.V),
                )
            found += [self.margin.rank(reached) < m.r, self.margin.rank(seen) < m.r]
        return any(found)

    # forms and symmetry

    def _symplectic(self) -> bool:
        if not self.method.one:
            return False
        parts = list(self.method.parts.values())
        first, last = parts[0], parts[-1]
        b, b_hat = first.B[0], last.B[0]
        gaps = [
            b[i] * last.A[i][j] + b_hat[j] * first.A[j][i] - b[i] * b_hat[j]
            for i in range(len(b))
            for j in range(len(b_hat))
        ]
        gaps += [x - 1 for m in parts for x in flat(m.U, m.V)]
        if self.method.pair and not self.method.separable:
            gaps += [x - y for x, y in zip(b, b_hat, strict=True)]
        return self.margin.zeros(gaps)

    def _defects(self, G: Matrix, D: Vector, E: Vector) -> Vector:
        parts = list(self.method.parts.values())
        q, p = parts[0], parts[-1]
        shared = [] if self.method.separable else [x - y for x, y in zip(D, E, strict=True)]
        own = [] if self.method.pair else unequal(G, star(G))
        return [
            *unequal(times(star(q.V), G, p.V), G),
            *unequal([[d * x for x in row] for d, row in zip(D, p.U, strict=True)], times(star(q.B), G, p.V)),
            *unequal([[d * x for x in row] for d, row in zip(E, q.U, strict=True)], times(star(p.B), star(G), q.V)),
            *unequal(plus([[d * x for x in row] for d, row in zip(D, p.A, strict=True)],
                          [[x * e for x, e in zip(row, E, strict=True)] for row in star(q.A)]), times(star(q.B), G, p.B)),
            *shared, *own, *(mp.im(x) for x in [*D, *E]),
        ]  # fmt: skip

    def _power(self, defect: Any) -> int | None:
        m = self.method.parts.get("o")
        if m is None or not self.method.one or "digits" in self.document:
            raise Undecided("a method that carries several values, or decimals")
        ones = [x - 1 for x in (*flat(m.U, m.V), sum(m.B[0]))]
        if not self.margin.zeros(ones) or any(mp.im(x) for x in flat(m.A, m.B)):
            raise Undecided("a step that is not consistent, or not real")
        return power(defect, m)

    def _hamiltonian_to_order(self) -> int:
        found = self._power(symplectic_defect)
        return -1 if found is None else found  # none is the largest

    def _energy_order(self) -> int | None:
        return self._power(energy_defect)

    def _conjugate_symplectic_order(self) -> int | None:
        if self._conjugate_symplectic():
            return -1
        raise Undecided("orders in other variables")

    def _conjugate_symplectic(self) -> bool:
        """A form decides; that there is no change of variables is not looked for."""
        m = self.method.parts["o"]
        simple = len(self.margin.null(plus(m.V, eye(m.r), -1))) == 1
        if simple and not any(mp.im(x) for x in flat(m.A, m.U, m.B, m.V)) and self._g_symplectic():
            return True
        raise Undecided("conjugate by another reason")

    def _g_symplectic(self) -> bool:
        parts, d, read = self.method.parts, self.document, self.file.read
        ends = next(iter(parts)), list(parts)[-1]
        (u, free), (v, more) = (ones_of(self.method, self.margin, c) for c in ends)
        if u is None or v is None:
            return False
        if free or more:
            raise Undecided("u is not determined")
        q, p = parts[ends[0]], parts[ends[1]]
        if "G" in d:
            G = self.file.form()
            D = at(star(q.B), at(G, v))
            E = at(star(p.B), at(star(G), u))
            given = {"D": 0, "D_P": 0, "D_Q": 1}
            own = [D, E]
            for key in () if self.file.kind == "sweep" else sorted(given.keys() & set(d)):
                own[given[key]] = read.vector(d[key])
            if not self.method.pair:
                own[1] = own[0]
            energy = dot([mp.conj(x) for x in u], at(G, v))
            return self.margin.zeros(self._defects(G, *own)) and not self.margin.zero(energy)
        rows, columns, energies = q.r, p.r, []
        units = []
        for i in range(rows):
            for j in range(columns):
                for x in (mp.mpf(1), mp.mpc(0, 1)):
                    G = [
                        [x if (i, j) == (a, b) else mp.mpf(0) for b in range(columns)]
                        for a in range(rows)
                    ]
                    units.append((G, [mp.mpf(0)] * len(q.B[0]), [mp.mpf(0)] * len(p.B[0])))
                    energies.append(mp.conj(u[i]) * x * v[j])
        G = [[mp.mpf(0)] * columns for _ in range(rows)]
        n = [len(q.B[0]), len(p.B[0])]
        for k in range(sum(n) if self.method.pair else n[0]):
            D, E = (
                [mp.mpf(int(k == a + s)) for a in range(m)]
                for m, s in zip(n, (0, n[0]), strict=True)
            )
            units.append((G, D, E if self.method.pair else D))
            energies.append(mp.mpf(0))
        images = [self._defects(*x) for x in units]
        system = transposed([[y for x in image for y in (mp.re(x), mp.im(x))] for image in images])
        system = [row for row in system if any(row)]
        forms = self.margin.null(system) if system else eye(len(units))
        return any(not self.margin.zero(dot(x, energies)) for x in forms)

    def _symmetric(self) -> bool:
        return self._is_symmetric(self.method)

    def _is_symmetric(self, method: Method) -> bool:
        """Return whether the step run backwards is the step, up to L and the order of the stages."""
        backward = {}
        for c, m in method.parts.items():
            back = self.margin.inverse(m.V)
            if back is None:
                return False
            backward[c] = Part(
                plus(times(m.U, back, m.B), m.A, -1), times(m.U, back), times(back, m.B), back
            )
        doubt = False
        for P in self._exchanges(method, backward):
            answers = [self._reversal(m, backward[c], *P[c]) for c, m in method.parts.items()]
            if all(answers):
                return True
            doubt = doubt or all(x is not False for x in answers)
        if doubt:
            raise Undecided("L is not determined")
        return False

    def _exchanges(self, method: Method, backward: Mapping[str, Part]) -> Iterator[dict[str, Any]]:
        """Yield {colour: (permutation of stages, of slopes)} that carry A into the A backwards."""
        colours = list(method.parts)
        counts = {c: len(method.parts[c].A) for c in colours}
        kinds = colours if method.separable else colours[:1]
        slots = [(c, i) for c in kinds for i in range(counts[c])]
        steps = 0

        def entries(x: Any, y: Any) -> Iterator[tuple[Number, Any]]:
            for c in colours:
                other = "k" if c == "f" else "f" if c == "k" else c
                if not method.separable or (x[0] == c and y[0] == other):
                    yield method.parts[c].A[x[1]][y[1]], c

        def fine(P: dict[Any, Any], new: list[Any]) -> bool:
            for x in new:
                for y in P:
                    for a, b in ((x, y), (y, x)):
                        for value, c in entries(a, b):
                            if not self.margin.zero(value - backward[c].A[P[a][1]][P[b][1]]):
                                return False
            return True

        def place(P: dict[Any, Any]) -> Iterator[dict[Any, Any]]:
            nonlocal steps
            steps += 1
            if steps > 3000:
                raise Undecided("too many permutations")
            rest = [x for x in slots if x not in P]
            if not rest:
                yield P
                return
            x = rest[0]
            for y in reversed(rest):  # of a palindrome the last first
                if y[0] == x[0]:
                    Q = {**P, x: y, y: x}
                    if fine(Q, [x, y]):
                        yield from place(Q)

        for P in place({}):
            lists = {c: [P[c, i][1] for i in range(counts[c])] for c in kinds}
            found = {}
            for c in colours:
                other = "k" if c == "f" else "f" if c == "k" else c
                found[c] = (lists[c], lists[other]) if method.separable else (lists[kinds[0]],) * 2
            yield found

    def _reversal(self, m: Part, back: Part, stages: list[int], slopes: list[int]) -> bool | None:
        """Return whether an involution L carries U, B, V into those backwards, None if unsure."""
        r, rows, right = m.r, [], []

        def equation(terms: Iterator[tuple[int, int, Number]], value: Number) -> None:
            row = [mp.mpf(0)] * (r * r)
            for i, j, x in terms:
                row[i * r + j] += x
            rows.append(row)
            right.append(value)

        for s in range(len(m.U)):
            for j in range(r):
                equation(((k, j, m.U[stages[s]][k]) for k in range(r)), back.U[s][j])
        for i in range(r):
            for s in range(len(m.B[0])):
                equation(((i, k, m.B[k][slopes[s]]) for k in range(r)), back.B[i][s])
            for j in range(r):
                equation(((k, j, m.V[i][k]) for k in range(r)), mp.mpf(0))
                for k in range(r):
                    rows[-1][i * r + k] -= back.V[k][j]
        x = self.margin.solve(rows, right)
        if x is None:
            return False
        L = [x[i * r : i * r + r] for i in range(r)]
        if self.margin.zeros(unequal(times(L, L), eye(r))):
            return True
        return False if self.margin.rank(rows) == r * r else None

    def _symmetric_reduced(self) -> bool:
        m = self.method.parts["o"]
        u, _ = ones_of(self.method, self.margin, "o")
        columns = transposed(m.B) + ([u] if u else [])
        for _ in range(m.r):
            columns += [at(m.V, x) for x in columns[-len(m.B[0]) - 1 :]]
        basis = transposed(self.margin.echelon(columns)[0])
        if not basis:
            raise Undecided("no value is left")
        V, B = (transposed([self.margin.solve(basis, x) or [] for x in transposed(M)])
                for M in (times(m.V, basis), m.B))  # fmt: skip
        U = times(m.U, basis)
        seen = list(U)
        for _ in V:
            seen += times(seen[-len(U) :], V)
        rows = self.margin.echelon(seen)[0]
        if not rows:
            raise Undecided("no value is left")
        U, V = (
            [self.margin.solve(transposed(rows), x) or [] for x in M] for M in (U, times(rows, V))
        )
        return self._is_symmetric(single(Part(m.A, U, times(rows, B), V)))

    # spectra

    @cached_property
    def spectra(self) -> dict[str, list[tuple[Number, int]] | None]:
        """Eigenvalues of V of modulus 1 with their numbers, ``None`` where powers grow."""
        if not self.file.exact("V"):
            raise Undecided("V in decimals")
        return {c: self._circle(m.V) for c, m in self.method.parts.items()}

    def _circle(self, V: Matrix) -> list[tuple[Number, int]] | None:
        found, outside = [], False
        for z, n in clusters(V):
            off = abs(z) - 1
            if abs(off) < mp.mpf(10) ** -70:
                null = self._null(V, z)
                if len(null) < n:
                    return None
                found.append((z, n))
            elif abs(off) < mp.mpf(10) ** -20:
                raise Undecided("an eigenvalue near the circle")
            outside = outside or off > 0.5 * mp.mpf(10) ** -20
        return None if outside else found

    @staticmethod
    def _null(V: Matrix, z: Number) -> Matrix:
        # eigenvalues on the circle are known to 70 digits
        own = Margin(mp.mpf(10) ** -60, mp.mpf(10) ** -40)
        return own.null(
            [[x - (z if i == j else 0) for j, x in enumerate(row)] for i, row in enumerate(V)]
        )

    def _zero_stable(self) -> bool:
        return all(x is not None for x in self.spectra.values())

    def _groups(self) -> list[tuple[Number, Matrix, bool]]:
        """Return (zeta, growth matrix, whether it is the one at 1)."""
        found, parts = [], self.method.parts
        for c, values in self.spectra.items():
            for z, _ in values or ():
                for other in self.method.children[c]:
                    if self.method.pair and (other == c or abs(z - 1) < 1e-20):
                        continue
                    near = [y for y, _ in self.spectra[other] or () if abs(y - z) < 1e-20]
                    if not near:
                        continue
                    N, W = self._null(parts[other].V, z), self._null(transposed(parts[c].V), z)
                    own = self._null(parts[c].V, z)
                    norm = self.margin.inverse(times(W, transposed(own)))
                    assert norm is not None
                    M = times(norm, W, parts[c].B, parts[other].U, transposed(N))
                    found.append((z, [[x / z for x in row] for row in M], abs(z - 1) < 1e-20))
        return found

    def _parasitism_free(self) -> bool:
        if not self._zero_stable():
            return False
        if self.method.pair and (not self.method.separable or any(
                n > 1 for x in self.spectra.values() for z, n in x or () if abs(z - 1) < 1e-20)):  # fmt: skip
            raise Undecided("stages that are shared")
        for _, M, one in self._groups():
            if one and len(M) > 1:
                rank, trace = self.margin.rank(M), sum(M[k][k] for k in range(len(M)))
                if rank > 1 or (rank == 1 and self.margin.zero(trace)):
                    return False
                if rank == 0 or not self.margin.zero(trace - 1):
                    raise Undecided("no growth parameter belongs to the principal component")
            elif not one and not self.loosely(flat(M)):
                return False
        return True

    @staticmethod
    def loosely(values: Vector) -> bool:
        """Return whether numbers that come from eigenvalues vanish."""
        most = max(map(abs, values), default=mp.mpf(0))
        if 1e-60 < most < 1e-15:
            raise Undecided("a growth parameter near 0")
        return bool(most <= 1e-60)

    def _growth(self, declared: list[str]) -> bool:
        if not self._zero_stable():
            return False
        given = [Reader({})(x) for x in declared]
        groups = sorted(
            self._groups(), key=lambda g: mp.arg(g[0]) % (2 * mp.pi) if abs(g[0] - 1) > 1e-20 else 0
        )
        if self.method.pair:
            if not self.method.separable:
                raise Undecided("stages that are shared")
            numbers = [x for _, M, _ in groups for x in flat(M)]
            if any(abs(x) > 1e-20 for x in [*given, *numbers]):
                raise Undecided("growth of pairs")
            return len(given) == len(numbers)
        if len(given) != sum(len(M) - int(one) for _, M, one in groups):
            return False
        for _, M, one in groups:
            mine, given = given[: len(M) - int(one)], given[len(M) - int(one) :]
            if one and len(M) == 1:
                continue
            left, right = eye(len(M)), mine + [mp.mpf(1)] * int(one)
            for k in (mp.mpf(7) / 3, mp.mpf(-5) / 7, mp.mpc(2, 3), mp.mpf(11) / 13, mp.mpf(4)):
                value = mp.det(
                    mp.matrix(
                        [
                            [k * x - y for x, y in zip(*rows, strict=True)]
                            for rows in zip(left, M, strict=True)
                        ]
                    )
                )
                if not self.loosely([value - mp.fprod(k - x for x in right)]):
                    return False
        return True

    def _second_order_growth(self, declared: list[str]) -> bool:
        m, solve = self.method.parts["o"], self.margin.solve
        (u, *_), groups = ones_of(self.method, self.margin, "o"), self._groups()
        if any(len(M) > 1 or not (one or self.loosely(flat(M))) for _, M, one in groups):
            raise Undecided("eigenvalues are multiple, or a growth parameter is not 0")
        shift = plus(eye(m.r), m.V, -1)
        v = u and solve(shift, [sum(x) - y for x, y in zip(m.B, u, strict=True)])
        if v is None:
            raise Undecided("the method is not consistent")
        c = [sum(x) + y for x, y in zip(m.A, at(m.U, v), strict=True)]
        x = solve(shift, [a - b / 2 - d for a, b, d in zip(at(m.B, c), u, v, strict=True)])
        if x is None:
            raise Undecided("the order is below 2")
        bend = [a + b - d * d / 2 for a, b, d in zip(at(m.A, c), at(m.U, x), c, strict=True)]
        found, step = [], mp.mpf(10) ** -15
        for z in sorted(
            (z for z, _, one in groups if not one), key=lambda z: mp.arg(z) % (2 * mp.pi)
        ):
            (w,), (n,) = self._null(transposed(m.V), z), self._null(m.V, z)
            moved = [a * b for a, b in zip(at(m.U, n), bend, strict=True)]
            logs = [mp.log(min(mp.eig(mp.matrix(self.at(h)), left=False, right=False),
                               key=lambda y: abs(y - z)) / z) for h in (step, -step)]  # fmt: skip
            if abs(mp.re(logs[0] + logs[1])) > step**3:
                raise Undecided("a part grows by h f' f'")
            found += [dot(w, at(m.B, moved)) / dot(w, n) / z, (logs[0] - logs[1]) / (2 * step**3)]
        given = [Reader({})(x) for x in declared]
        close = [abs(x - y) for x, y in zip(found, given, strict=False)]
        return len(found) == len(given) and max(close, default=0) < mp.mpf(10) ** -20

    def at(self, z: Number) -> Matrix:
        """Return M(z)."""
        m = self.file.linear()
        back = self.margin.inverse(plus(eye(len(m.A)), m.A, -z))
        if back is None:
            raise Undecided("a pole")
        return plus(m.V, times(m.B, back, m.U), z)

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
                near = self._size(1 / z * (1 + mp.mpf(10) ** -30))
                if near > 1e12:
                    return False
                raise Undecided("a pole that M may not have")
        worst = mp.mpf(0)
        for k in range(-24, 25):
            y = mp.mpf(10) ** (mp.mpf(k) / 6 if abs(k) < 24 else k)
            values = clusters(self.at(mp.mpc(0, y)))
            worst = max([worst, *(abs(z) for z, _ in values)])
            for z, n in values:
                if (
                    n > 1
                    and abs(abs(z) - 1) < 1e-25
                    and len(self._null(self.at(mp.mpc(0, y)), z)) < n
                ):
                    return False
        if STABLE < worst - 1 <= UNSTABLE:
            raise Undecided("an eigenvalue near the circle")
        return bool(worst <= 1 + STABLE)

    def _size(self, z: Number) -> Number:
        return max(abs(x) for x in flat(self.at(z)))

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


def clusters(M: Matrix) -> list[tuple[Number, int]]:
    """Return the eigenvalues of M with their multiplicities: mean values of what lies together."""
    if len(M) == 1:
        return [(M[0][0], 1)]
    values = list(mp.eig(mp.matrix(M), left=False, right=False))
    found: list[list[Number]] = []
    for z in values:
        near = next(
            (x for x in found if abs(x[0] - z) < mp.mpf(10) ** -(mp.dps // len(M) - 2)), None
        )
        if near is None:
            found.append([z])
        else:
            near.append(z)
    return [(sum(x) / len(x), len(x)) for x in found]
