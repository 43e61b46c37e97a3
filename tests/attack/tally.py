"""What came of an attack: how often each outcome, and every violation with its case."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class Tally:
    """Counts of outcomes and the violations found."""

    #: Name of an outcome -> how often it came.
    outcomes: Counter[str] = field(default_factory=Counter)
    #: One text for each, with the case that shows it.
    violations: list[str] = field(default_factory=list)

    def text(self) -> str:
        """Counts and violations, one per line."""
        lines = [f"{n:6}  {name}" for name, n in self.outcomes.most_common()]
        lines += [f"VIOLATION {text}" for text in self.violations]
        total = sum(self.outcomes.values())
        lines.append(f"{total} cases, {len(self.violations)} violations")
        return "\n".join(lines)

    def printed(self) -> int:
        """Print counts and violations; 1 where there is a violation."""
        print(self.text(), flush=True)
        return 1 if self.violations else 0
