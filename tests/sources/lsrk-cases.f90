! low-storage Runge-Kutta schemes, chosen by name
module lsrk
contains
subroutine choose(self, scheme)
  select case (trim(scheme))
  case ('euler')
    allocate(self%A(1)); self%A = 0._dp; self%B(1) = 1._dp
  case ('williamson_3')
    self%order = 3
    allocate(self%A(3)); self%A = 0._dp
    self%A(2) = -real(5_i8, kind=dp)/real(9_i8, kind=dp); self%B(1) = 1._dp/3._dp
    self%A(3) = -153._dp/128._dp;                         self%B(2) = 15._dp/16._dp
    self%B(3) = 8._dp/15._dp; self%C(2) = 1._dp/3._dp; self%C(3) = 3._dp/4._dp
#if (NODES==2 && !defined(EXACT))
  case ('with ranges')
    self%order = 3
    rkA(2:n) = (/ 5._dp/9._dp, 153._dp/128._dp /)
    rkb(1:n) = (/ 1._dp/3._dp, 15._dp/16._dp, 8._dp/15._dp /)
    rkc(2:n) = (/ 1._dp/3._dp, 3._dp/4._dp /)
#endif
  end select
end subroutine
end module
