"""Spaces of forms: all of them, and the witness when none is left."""

from glmref.exact import exact
from glmref.exact.linalg import conjugate_transpose, matmul, sub
from glmref.method import as_matrix
from glmref.theory.forms import Form, FormSpace, choose_form, solved, unit_matrices


def invariant(V, *, hermitian):
    """Return the forms G with V* G V = G."""
    V = as_matrix(V, "V")
    real = all(x.is_real() for row in V for x in row)
    units = [Form(G, ()) for G in unit_matrices(2, 2, hermitian=hermitian, is_real=real)]

    def kept(form):
        return [("V* G V - G", sub(matmul(conjugate_transpose(V), form.G, V), form.G))]

    return [form.G for form in solved(units, kept, None).forms]


def test_invariant_forms_of_a_rotation_are_multiples_of_the_identity():
    V = [["3/5", "-4/5"], ["4/5", "3/5"]]
    (G,) = invariant(V, hermitian=True)
    assert G[0][1] == 0 and G[0][0] == G[1][1]
    assert len(invariant(V, hermitian=False)) == 2  # and the skew one


def test_complex_hermitian_forms_are_counted_over_the_reals():
    found = invariant([["i", "0"], ["0", "i"]], hermitian=True)
    assert len(found) == 4
    assert all(G[0][1] == G[1][0].conjugate() for G in found)


def test_the_forms_that_are_left_satisfy_every_entry():
    unit = [Form(((exact(int(i == k)),),), ((exact(i),),)) for i, k in ((0, 0), (1, 0), (2, 0))]

    def identities(form):
        return [("D", ((form.D[0][0],),))]

    space = solved(unit, identities, lambda form: form.G[0][0])
    assert len(space.forms) == 2 and space.principal
    assert choose_form(space).G == ((1,),)
    none = solved(unit[1:], identities, lambda form: form.D[0][0])
    assert not none.principal and "entry (1, 1) of D" in none.witness


def form(G, *D):
    return Form(as_matrix(G, "G"), tuple(tuple(map(exact, d)) for d in D))


def test_the_first_form_that_is_nondegenerate_is_shown():
    first, other = form([[1, 0], [0, 0]], [1, 0]), form([[0, 0], [0, 1]], [0, 1])
    assert choose_form(FormSpace((), False)) is None
    assert choose_form(FormSpace((other, first), False)) is other
    found = choose_form(FormSpace((first, other), True))
    assert found.G == ((1, 0), (0, 1)) and found.D == ((1, 1),)
    assert choose_form(FormSpace((first, first), True)) is first
    lifted = form([[1, 0], [0, 1]], [1, 1])
    unit = [form([[0, 0], [0, 0]], [0, 0])] * 4
    assert choose_form(FormSpace((lifted, *unit), True)).D == ((1, 1),)


def test_what_leaves_no_principal_form_is_named():
    forms = [form([[1]], [2])]
    space = solved(forms, lambda x: [("D", (x.D[0],))], lambda x: x.G[0][0])
    assert space.forms == () and not space.principal and space.residual == 2
    assert "entry (1, 1) of D is 2 in size for the only form G left" in space.witness
    two = [form([[1]], [2]), form([[0]], [2])]
    space = solved(two, lambda x: [("D", (x.D[0],))], lambda x: x.G[0][0])
    assert len(space.forms) == 1 and space.principal and space.forms[0].D == ((0,),)
    space = solved(forms, lambda x: [("D", ((exact(0),),))], lambda x: exact(0))
    assert space.witness == "no form sees the solution" and not space.principal
    assert solved(forms, lambda x: [("D", (x.D[0],))], None).witness == ""
