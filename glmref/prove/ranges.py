"""What is known of a claim: a truth value, proposed or judged, or bounds of an order."""

from __future__ import annotations

from dataclasses import dataclass

#: Largest order to which trees are compared: of one method, a separable pair, another pair, three
#: right-hand sides, and more.
MAX_ORDER = (12, 9, 8, 6, 5)


@dataclass(frozen=True)
class Known:
    """A proposal or an answer: ``True``, ``False``, or ``None`` for open; ``exact`` says how."""

    truth: bool | None
    exact: bool = True
    reason: str = ""
    residual: float = 0.0


@dataclass(frozen=True)
class Range:
    """Proved bounds of an order.

    Attributes
    ----------
    lower : int
        The order is at least this.
    upper : int or None
        And at most this, ``None`` where nothing is known.
    tree : str
        Text of the first tree of order upper + 1 that fails.
    residual : float
        Its size.
    sizes : tuple[float, ...]
        For each order the largest residual through it that is not an exact zero.
    exact : bool
        Whether only exact numbers took part.
    reason : str
        One sentence.
    value : int
        The order to show where the bounds differ: no tree through it is known to fail.
    failing : str or None
        Of stages, starts and finishes: the tree that refutes order upper + 1, ``""`` for u.
    """

    lower: int
    upper: int | None
    tree: str = ""
    residual: float = 0.0
    sizes: tuple[float, ...] = ()
    exact: bool = True
    reason: str = ""
    value: int = 0
    failing: str | None = None

    @property
    def sentence(self) -> str:
        """What decides the upper bound, or why there is none."""
        if self.upper is None or not self.tree:
            open_ = self.upper is None and self.value
            bound = f"no tree of order {self.value} or less fails" if open_ else ""
            return "; ".join(x for x in (bound, self.reason) if x)
        order = self.upper + 1
        fails = f"tree {self.tree} of order {order} has residual {self.residual:.6g}"
        if 0 < self.lower < self.upper:
            fails = f"no tree of order {self.lower} or less fails, and {fails}"
        return f"{fails}; {self.reason}" if self.reason else fails
