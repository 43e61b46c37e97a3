"""Adapters that come with the package; each imports its library only when it is asked for."""
