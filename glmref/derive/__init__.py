"""From an ansatz to a method file with its proof.

ansatz        what to look for: a document with named unknowns and equations
search        Levenberg-Marquardt from many starts, in double precision
recognise     closed forms
multistep     symmetric multistep methods, with one and with two kicks a step
partitioned   explicit partitioned methods
linear_start  starting methods whose conditions are linear
parity_start  starting methods with a parity, by Newton's method
recipes       all of it, for named methods

The equations, the polishing to 120 digits and the interval test are in ``prove`` (``system``,
``newton``, ``enclosure``), the writing of files in ``catalogue.writer``.
"""
