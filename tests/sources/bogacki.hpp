#pragma once
// Coefficients of the Runge-Kutta pair BS23.
template <typename Real>
struct BogackiShampine {
  static constexpr int order = 3;
  static constexpr int low_order = 2;
  static constexpr Real a21 = Real(1) / 2;
  static constexpr Real a31 = 0, a32 = Real(3) / 4;
  static constexpr Real a41 = Real(2) / 9, a42 = Real(1) / 3, a43 = Real(4) / 9;
  static constexpr Real b1 = a41, b2 = a42, b3 = a43, b4 = 0;
  static constexpr Real c1 = 0, c2 = Real(1) / 2, c3 = Real(3) / 4, c4 = 1;
  static constexpr Real bhat1 = Real(7) / 24, bhat2 = Real(1) / 4, bhat3 = Real(1) / 3,
                        bhat4 = Real(1) / 8;
};
