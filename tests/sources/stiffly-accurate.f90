! implicit Runge-Kutta methods, chosen by name
module dirk
contains
subroutine choose(self, scheme)
  select case (scheme)
  case ('alexander')
    gam = 0.43586652150845899942_dp
    b1 = -(6._dp*gam**2 - 16._dp*gam + 1._dp)/4._dp
    b2 = (6._dp*gam**2 - 20._dp*gam + 5._dp)/4._dp
    self%order = 3
    self%matrix = reshape([gam, 0._dp, 0._dp, (1._dp - gam)/2._dp, gam, 0._dp, &
      b1, b2, gam], [3, 3], order=[2, 1])
    self%nodes = [gam, (1._dp + gam)/2._dp, 1._dp]
  end select
end subroutine
end module
