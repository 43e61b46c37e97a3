"""Proofs that a true method lies within published digits: equations, interval tests, starts."""
