"""Proofs: what finds witnesses and values, what writes certificates, and what asks the judge."""
