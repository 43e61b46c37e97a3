# An analyst with a new tableau: what is it, do the claims hold, how does it look, a page to show.
# Needs the method file `docs/ways/my-method.json`; run in the top folder of a clone.
glmref analyze docs/ways/my-method.json
glmref verify docs/ways/my-method.json
glmref show docs/ways/my-method.json --plot my-method.svg
glmref report docs/ways/my-method.json my-method.svg --output pages
