"""Files, locks, signals and processes: what can go wrong around a computation."""
