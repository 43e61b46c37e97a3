"""Adapters that come with the package; each imports its library on first use."""
