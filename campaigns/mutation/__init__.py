"""Mutation testing: one small change to the package at a time, which a test must notice.

``python -m campaigns.mutation --subpackages exact,readers --count 100 --output FILE.jsonl``
draws mutants, runs the quick tests that call the changed function, and lists those that nothing
notices. ``README.md`` holds the scores and says what became of the survivors.
"""
