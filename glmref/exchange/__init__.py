"""Methods as source files and tables of other packages, and such tables read back.

:func:`.export.export` is the door out, :func:`.import_tables.read_table` the door in. Nothing is
imported here: asking for one does not load the other.
"""
