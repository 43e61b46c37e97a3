"""Conformance: the data and the tests, for integrators that are not ours.

An adapter (:class:`.adapter.Adapter`) shows an integrator to the suite. Then::

    pytest --pyargs glmref.conformance --glmref-adapter package.module:Adapter
    python -m glmref.conformance package.module:Adapter --format json
    glmref conformance package.module:Adapter --identify

``cmd:program argument ...`` instead of a Python object speaks JSON lines over a pipe
(:mod:`.pipe`), so that any language takes part. The numbers the suite compares with lie in
``data/vectors``; :mod:`.vectors` reads them and :mod:`.generate` makes them. Importing this package
loads nothing heavy: the pytest plugin lives in it.
"""
