
static const char citation[] = "url = {http://example.org/1}\n";
PetscErrorCode TSGLEERegisterAll(void)
{
  {
#define GAMMA 0.0
    const PetscInt  p = 2, s = 4, r = 2;
    const PetscReal A[4][4] = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}},
                    B[2][4] = {{0.5, 0.5, 0, 0}, {-0.5, -0.5, 0.5, 0.5}},
                    U[4][2] = {{1, 0}, {1, 0}, {1, 1}, {1, 1}}, V[2][2] = {{1, 0}, {0, 1}},
                    S[2] = {1, 0}, F[2] = {1, 0}, Fembed[2] = {1, 1 - GAMMA};
    PetscCall(TSGLEERegister(TSGLEEMADE, p, s, r, GAMMA, &A[0][0], &B[0][0], &U[0][0], &V[0][0], S, F, NULL, Fembed, F, S, 0, NULL));
  }
}
