"""From an ansatz to a method file with its proof.

ansatz      what to look for                     -> a document with named unknowns and equations
system      the equations of a document, over any scalar (equations, classes: the theory)
search      Levenberg-Marquardt from many starts, in double precision
newton      polishing to 120 digits and more
enclosure   the interval test: exactly one true method near the digits, and what follows
recognise   closed forms
write       the file
recipes     all of it, for named methods
"""
