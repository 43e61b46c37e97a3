"""Explicit partitioned methods: evaluations, long runs, starting methods."""
