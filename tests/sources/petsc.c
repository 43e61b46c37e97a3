
PetscErrorCode TSRegisterAll(void)
{
#define RC PetscRealConstant
#define g  (1.0 - 0.5 * PetscSqrtReal((PetscReal)2.0)) /* a comment */
  {
    const PetscReal A[2][2] = {
      {0, 0},
      {RC(2.0) / RC(3.0), 0}
    };
    const PetscReal b[2] = {0.25, 0.75}, bembed[2] = {1.0, 0};
    PetscCall(TSRKRegister(TSRK2R, 2, 2, &A[0][0], b, NULL, NULL, 0, NULL));
  }
  {
    const PetscReal A[3][3] = {{0, 0, 0}, {g, 0, 0}, {-(PetscReal)1.0, 3.0, 0}};
    const PetscReal At[3][3] = {{0, 0, 0}, {0, g, 0}, {0, 1 - g, g}};
    const PetscReal b[3] = {0, 1 - g, g};
    PetscCall(TSARKIMEXRegister(TSARKIMEXX, 2, 3, &At[0][0], b, NULL, &A[0][0], b, NULL, NULL, NULL, 0, NULL, NULL));
  }
  PetscCall(TSRosWRegisterRos4(TSROSWY, 0.25, PETSC_CURRENT, PETSC_CURRENT, 0, 1.0));
  {
    const PetscReal A[2][2] = {{0, 0}, {1., 0}};
    const PetscReal Gamma[2][2] = {{0.25, 0}, {-0.5, 0.25}};
    const PetscReal b[2] = {0.5, 0.5}, b1[2] = {1.0, 0.0};
    PetscCall(TSRosWRegister(TSROSW2Z, 2, 2, &A[0][0], &Gamma[0][0], b, NULL, 1, NULL));
  }
}
