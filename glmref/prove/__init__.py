"""Proofs: the kernel that gives verdicts, what asks it, and what proposes witnesses to it."""
