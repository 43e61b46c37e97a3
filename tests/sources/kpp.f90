
  SUBROUTINE Ros2
! L-STABLE METHOD, 2 STAGES, ORDER 2
    DOUBLE PRECISION g
    g = 1.0_dp + 1.0_dp/SQRT(2.0_dp)
    ros_S = 2
    ros_A(1) = (1.0_dp)/g
    ros_C(1) = (-2.0_dp)/g
    ros_M(1)= (3.0_dp)/(2.0_dp*g)
    ros_M(2)= (1.0_dp)/(2.0_dp*g)
    ros_E(1) = 1.0_dp/(2.0_dp*g)
    ros_E(2) = ros_M(2)
    ros_Alpha(2) = 1.0_dp
    ros_Gamma(1) = g
    ros_Gamma(2) =-g
  END SUBROUTINE Ros2
