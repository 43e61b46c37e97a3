
struct Leapfrog : SymplecticPartitionedRungeKutta {
  static constexpr int order = 2;  // a comment
  static constexpr FixedVector<double, stages> a{{{1.0, 0.0}}};
  static constexpr FixedVector<double, stages> b{{{+0.5,
                                                   +0.5}}};
};
struct Heun : EmbeddedExplicitRungeKutta {
  static constexpr int higher_order = 2;
  static constexpr int lower_order = 1;
  static constexpr FixedVector<double, stages> c{{{0.0, 1.0}}};
  static constexpr FixedStrictlyLowerTriangularMatrix<double, stages> a{{{1'000.0 / 1'000.0}}};
  static constexpr FixedVector<double, stages> b̂{{{0.5, 0.5}}};
  static constexpr auto b = b̂ - FixedVector<double, stages>{{{-0.5, 0.5}}};
};
struct Adams : ExplicitLinearMultistep {
  static constexpr int order = 2;
};
struct Stormer : EmbeddedExplicitRungeKuttaNyström {
  static constexpr int higher_order = 2;
  static constexpr int lower_order = 1;
  static constexpr FixedVector<double, stages> c{{{0.0, 1.0}}};
  static constexpr FixedStrictlyLowerTriangularMatrix<double, stages> a{{{0.5}}};
  static constexpr FixedVector<double, stages> b̂{{{0.5, 0.0}}};
  static constexpr FixedVector<double, stages> b̂ʹ{{{0.5, 0.5}}};
  static constexpr FixedVector<double, stages> b{{{0.5, 0.0}}};
  static constexpr FixedVector<double, stages> bʹ{{{1.0, 1.0}}};
};
