"""Engines that step: the reference, read like a paper, and kernels generated per tableau.

:func:`.solve.solve` is the door; :mod:`.reference` is the yardstick; :mod:`.codegen` and
:mod:`.kernel_cache` build kernels; :mod:`.ensemble` runs many initial values at once. Nothing is
imported here, so that asking for one engine does not load the other.
"""
