"""What came of an attack: how often each outcome, and every violation with its case."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field


@dataclass
class Tally:
    """Counts of outcomes and the violations found."""

    #: Name of an outcome -> how often it came.
    outcomes: Counter[str] = field(default_factory=Counter)
    #: One text for each, with the case that shows it.
    violations: list[str] = field(default_factory=list)

    @classmethod
    def of(
        cls, results: Iterable[tuple[str, str, Iterable[str]]], say: Callable[[str], None]
    ) -> Tally:
        """Count outcomes of cases, with what each violates; say these and how far it is."""
        tally = cls()
        for number, (end, case, wrong) in enumerate(results, 1):
            tally.outcomes[end] += 1
            for sentence in wrong:
                tally.violations.append(f"{sentence} [{case}]")
                say(f"case {number}: {sentence} [{case}]")
            if number % 500 == 0:
                say(f"{number} cases")
        return tally

    def text(self) -> str:
        """Counts and violations, one per line."""
        lines = [f"{n:6}  {name}" for name, n in self.outcomes.most_common()]
        lines += [f"VIOLATION {text}" for text in self.violations]
        # what is counted of a statement in several ways is one case
        total = self.outcomes.get("statements") or sum(self.outcomes.values())
        lines.append(f"{total} cases, {len(self.violations)} violations")
        return "\n".join(lines)

    def printed(self) -> int:
        """Print counts and violations; 1 where there is a violation."""
        print(self.text(), flush=True)
        return 1 if self.violations else 0
