"""Mutation testing: one small change to the package at a time, which a test must notice.

``python -m campaigns.mutation --rooms exact,readers --count 100 --seed 1 --output FILE.jsonl``
draws mutants, runs the tests that belong to the changed module in a copy of the tree, and lists
those that nothing notices. ``README.md`` holds the scores and says what became of the survivors.
"""
