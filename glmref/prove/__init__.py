"""Proofs: the kernel that gives verdicts, and what proposes witnesses to it."""
