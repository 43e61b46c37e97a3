# A contributor: a table becomes a method of the catalogue, and what depends on it is regenerated.
glmref convert docs/ways/nystrom-rk-3.json --from json --output data/methods/rk/nystrom-rk-3.json
glmref verify nystrom-rk-3
python -m glmref.catalogue.canonical data
python tests/repo/test_readme.py
python -m pytest -q tests/repo/test_data_files.py
