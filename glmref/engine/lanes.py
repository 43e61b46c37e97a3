"""Generated source for ensembles: a block of lanes, one trajectory each, stepped side by side.

For small systems every statement stands inside ``for l in range(lanes)`` over contiguous rows of
the work array, so that the compiler turns the loop into SIMD instructions. Large systems, and
bodies with loops, have the statements of a single trajectory, in which every number that depends on
the state is a vector of lanes. The lanes of a block iterate until all of them are settled; a lane
that is settled keeps its values, so that each trajectory has the bits it would have alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from .arithmetic import NOISE
from .codegen import SCALAR_LIMIT, Builder, header
from .emit import INFINITE, LaneTarget, VectorTarget, Writer
from .expressions import Unsupported
from .forms import StepForm
from .options import Options
from .shape import Shape
from .stages import ROUND_OFF, ROUNDS, STALLS

LANE_ARGUMENTS = {
    "x": "d*", "par": "d*", "t0": "d", "h": "d", "first": "i", "last": "i", "lanes": "i",
}  # fmt: skip


@dataclass(frozen=True)
class LaneSource:
    """A generated kernel for a block of lanes."""

    text: str  #: Module source; defines ``kernel``.
    work_size: int  #: Length of the work array.
    width: int  #: Lanes in a block.
    vectors: bool  #: Whether the work array is one of vectors.


def in_vectors(shape: Shape) -> bool:
    """Return whether lanes are vectors: the single trajectory has arrays, too."""
    return shape.arrays or shape.dimension > SCALAR_LIMIT


def lane_source(form: StepForm, shape: Shape, options: Options, width: int) -> LaneSource:
    """Generate the module for blocks of ``width`` lanes.

    Raises
    ------
    Unsupported
        For a right-hand side that is a Python callable, and for an implicit pair.
    """
    if shape.opaque or (len(form.components) > 1 and form.implicit_stages):
        raise Unsupported("neither Python callables nor implicit pairs have lanes")
    writer, vectors = Writer(), in_vectors(shape)
    target = VectorTarget(shape, writer) if vectors else LaneTarget(shape, writer, width)
    _LaneBuilder(form, shape, options, target).kernel()
    head = header(shape, "vector" if vectors else "scalar", newton=False)
    text = f'"""Generated kernel: {width} lanes."""\n\n{head}{writer.text}'
    return LaneSource(text, target.work_size // target.width * width, width, vectors)


class _LaneBuilder(Builder):
    """The control flow of a block of lanes around the statements of a step."""

    t: LaneTarget | VectorTarget
    inside = False

    def _declare(self) -> None:
        """Declare nothing: everything lives in the work array."""

    def _open(self) -> None:
        """Put statements from here on into the loop over lanes, where there is one."""
        if self.t.looped and not self.inside:
            self.w("for l in range(lanes):")
            self.w.depth += 1
            self.inside = True

    def _close(self) -> None:
        if self.inside:
            self.w.depth -= 1
            self.inside = False

    @contextmanager
    def _lanes(self) -> Iterator[None]:
        self._open()
        yield
        self._close()

    def kernel(self) -> None:
        """Write the function ``kernel``."""
        w = self.w
        # the head of the work array: the state, then one status per lane, rounds, steps done
        state = self._state()
        for name in state:
            self.t.offset(name)
        if not isinstance(self.t, LaneTarget):
            pass
        elif not self.form.implicit_stages:
            self.t.lasting = frozenset(state)
        elif not self.form.running:
            # increments are added up at the end, in one pass; the guess of a single block is too
            single = sum(block.implicit for block in self.form.blocks) == 1
            self.t.passing += "uK" if single else "u"
        for name in ("status", "rounds", "done"):
            self.t.lane(name)
        w("", "@compiled_with_signature")
        with w.block(f"def kernel({', '.join(LANE_ARGUMENTS)}):"):
            self._preamble()
            w("n = first")
            with w.block("while n < last:"):
                if self.shape.uses_time:
                    w("start = t0 + n*h")
                self._open()
                self._begin()
                self._blocks()
                self._commit()
                self._close()
                w("n += 1")
            w("return 0")

    def _count(self, stages: Sequence[int], rounds: str = "") -> None:
        """Write nothing: the loop counts rounds per lane, and explicit stages are known."""

    def _finite(self, total: str) -> None:
        status, done = self.t.lane("status"), self.t.lane("done")
        # both sides of a choice are loaded first, so that it becomes a select, not a branch
        self.w(
            f"before = {status}",
            f"good = (before == 0.0) & (abs({total}) < {INFINITE})",
            "after = 2.0 if (before == 0.0) & (not good) else before",
            f"{status} = after",
            f"{done} = {done} + (1.0 if good else 0.0)",
        )

    def _taking(self, pairs: Sequence[tuple[str, str]], condition: str = "good") -> list[str]:
        """See :class:`.codegen.Builder`; both sides are loaded first, for a select."""
        return [
            line
            for old, new in pairs
            for line in (
                f"kept = {old}", f"taken = {new}", f"{old} = taken if {condition} else kept",
            )
        ]  # fmt: skip

    # --- rounds of a stage solver ---------------------------------------------------------------

    def _start_rounds(self) -> None:
        """Set per lane whether it still moves, its last change, its stalls, its bounds."""
        lane = self.t.lane
        self.w(
            f"{lane('size')} = size",
            f"{lane('nothing')} = nothing",
            f"{lane('last')} = 1e300",
            f"{lane('stalls')} = 0.0",
            f"{lane('active')} = 1.0 if {lane('status')} == 0.0 else 0.0",
            f"{lane('rounds')} = {lane('rounds')} + {lane('active')}",
        )

    def _judge_lanes(self, stages: Sequence[int]) -> None:
        """Write the change of each lane, and whether it goes on; see StageWriter._compare."""
        w, lane = self.w, self.t.lane
        template = " + ".join(f"abs(@N{i} - @Y{i})" for i in stages)
        self.t.total("change", template if len(stages) == 1 else f"({template})", self.watched)
        size, stalls, status = lane("size"), lane("stalls"), lane("status")
        active = lane("active")
        w(
            f"before = {status}",
            f"moving = ({lane('nothing')} < change) & (change < {lane('last')})",
            f"settled = change <= {ROUND_OFF!r}*{size}",
            f"stalled = {stalls} + (0.0 if moving else 1.0)",
            f"given_up = (not moving) & (not settled) & "
            f"((stalled > {float(STALLS)!r}) | (not (change < 1e300)))",
            f"bad = ({active} != 0.0) & given_up & (not (change <= {NOISE!r}*{size}))",
            f"{status} = failure if bad else before",
            f"go = ({active} != 0.0) & (moving | ((not settled) & (not given_up)))",
            f"{stalls} = stalled",
            f"{lane('last')} = change",
            f"{active} = 1.0 if go else 0.0",
            f"{lane('rounds')} = {lane('rounds')} + {active}",
            "alive += 1 if go else 0" if self.t.looped else "alive += lanes_with(go)",
        )

    def _refuse_infinite(self) -> None:
        """Name the lane, which stands still: as for one trajectory, but without a branch."""
        status, active = self.t.lane("status"), self.t.lane("active")
        self.w(
            f"before = {status}",
            f"going = {active}",
            "broken = (before == 0.0) & (inverse == 0.0)",
            f"{status} = 1.0 if broken else before",
            f"{active} = 0.0 if broken else going",
        )

    def _loop_head(self) -> None:
        self.w("alive = 0", "round_number += 1", "failure = 1.0 if round_number > 1 else 2.0")

    def _loop_exit(self) -> None:
        w = self.w
        with w.block("if alive == 0:"):
            w("break")
        with w.block(f"if round_number > {ROUNDS}:"):
            status, active = self.t.lane("status"), self.t.lane("active")
            with self._lanes():
                w(f"{status} = 1.0 if {active} != 0.0 else {status}")
            w("break")

    # --- solving --------------------------------------------------------------------------------

    @property
    def inline_newton(self) -> bool:
        return self.options.solver == "newton"

    def _round_before(self, stages: Sequence[int], bases: dict, name: str) -> None:
        """Write the parts before the counted one, and its stage values in ``name``."""
        if self.rounds is not None:
            self.rounds.stage_values(stages, name, "b" if name == "Y" else "v")
            return
        for part in self.shape.parts:
            if part is self.shape.counted:
                self._stage_values(stages, bases, (part.source, part.source_stop), name)
            else:
                self._velocities(part, stages, bases)

    def _solve(self, stages: tuple[int, ...], bases: dict) -> None:
        w, lane = self.w, self.t.lane
        if self.shape.halved:
            # P is used at once; Q is compared in the next round
            self.t.local |= {f"Y{i}": range(*self.inner) for i in stages}
        newton = self.options.solver == "newton"
        if self.rounds is not None:
            self.rounds.bases(stages, bases)
        self._sizes(stages, [bases[i][0] for i in stages])
        self._start_rounds()
        self._round_before(stages, bases, "Y")
        if newton:
            self._inline_matrix(stages[0])
            w(*(f"{lane(name)} = {name}" for name in self._newton_names()))
        self._evaluate(self.shape.counted, stages)
        self._update_lanes(stages, masked=False)
        self._close()
        w("round_number = 0")
        with w.block("while True:"):
            self._loop_head()
            with self._lanes():
                # q parts of L are formed again from the settled p parts: nothing to mask
                self._round_before(stages, bases, "N")
                self._judge_lanes(stages)
            self._loop_exit()
            with self._lanes():
                w(f"go = {lane('active')} != 0.0")
                self.t.vec(self._taking([(f"@Y{i}", f"@N{i}") for i in stages], "go"), self.watched)
                if newton:
                    w(*(f"{name} = {lane(name)}" for name in self._newton_names()))
                self._evaluate(self.shape.counted, stages)
                self._update_lanes(stages, masked=True)
        self._open()
        self._settled(stages, bases)

    def _update_lanes(self, stages: Sequence[int], *, masked: bool) -> None:
        if self.options.solver == "newton":
            text = "new if go else known" if masked else "new"
            self._newton_increments(stages[0], [text] * self.unknowns)
            return
        pairs = self._slopes(stages)
        plain = [f"{old} = {new}" for old, new in pairs]
        self.t.vec(self._taking(pairs, "go") if masked else plain, self.inner)
