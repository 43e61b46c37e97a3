module sdirk_mod
  implicit none
  integer, parameter :: dp = kind(1.d0)
  ! SDIRK of order 3 with two stages (Norsett)
  real(dp), parameter :: gam = (3.0_dp + sqrt(3.0_dp))/6.0_dp
  real(dp), parameter :: a_sdirk(2,2) = reshape([gam, 1.0_dp-2.0_dp*gam, 0.0_dp, gam],[2,2])
  real(dp), parameter :: b_sdirk(2) = [0.5_dp, 0.5_dp]
  ! Gauss 3 stages, order 6
  real(dp), parameter :: s15 = sqrt(15.0_dp)
  real(dp), parameter :: ag(3,3) = reshape([ &
     5.0_dp/36.0_dp, 5.0_dp/36.0_dp + s15/24.0_dp, 5.0_dp/36.0_dp + s15/30.0_dp, &
     2.0_dp/9.0_dp - s15/15.0_dp, 2.0_dp/9.0_dp, 2.0_dp/9.0_dp + s15/15.0_dp, &
     5.0_dp/36.0_dp - s15/30.0_dp, 5.0_dp/36.0_dp - s15/24.0_dp, 5.0_dp/36.0_dp],[3,3])
  real(dp), parameter :: bg(3) = [5.0_dp/18.0_dp, 4.0_dp/9.0_dp, 5.0_dp/18.0_dp]
end module
