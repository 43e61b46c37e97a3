"""Spaces of forms: all of them, and the witness when none is left."""

from glmref.exact import exact
from glmref.method import as_matrix
from glmref.theory.forms import Form, choose_form, combine, cut_down, invariant_matrices


def test_invariant_forms_of_a_rotation_are_multiples_of_the_identity():
    V = as_matrix([["3/5", "-4/5"], ["4/5", "3/5"]], "V")
    (G,) = invariant_matrices(V, V, hermitian=True)
    assert G[0][1] == 0 and G[0][0] == G[1][1]
    assert len(invariant_matrices(V, V, hermitian=False)) == 2  # and the skew one


def test_complex_hermitian_forms_are_counted_over_the_reals():
    V = as_matrix([["i", "0"], ["0", "i"]], "V")
    found = invariant_matrices(V, V, hermitian=True)
    assert len(found) == 4
    assert all(G[0][1] == G[1][0].conjugate() for G in found)


def test_forms_are_cut_down_entry_by_entry():
    unit = [Form(((exact(int(i == k)),),), ((exact(i),),)) for i, k in ((0, 0), (1, 0), (2, 0))]

    def identities(form):
        return [("D", ((form.D[0][0],),))]

    space = cut_down(unit, identities, lambda form: form.G[0][0])
    assert len(space.forms) == 2 and space.principal
    assert choose_form(space).G == ((1,),)
    none = cut_down(unit[1:], identities, lambda form: form.D[0][0])
    assert not none.principal and "entry (1, 1) of D" in none.witness


def test_combination_of_forms_combines_both_parts():
    a = Form(((exact(1),),), ((exact(2),),))
    both = combine((2, 3), (a, a))
    assert both.G == ((5,),) and both.D == ((10,),)
