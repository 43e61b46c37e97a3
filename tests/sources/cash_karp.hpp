#pragma once
#include <array>
// Cash-Karp, order 5 with embedded order 4
namespace ode {
template<class T> struct CashKarp54 {
  static constexpr int order = 5;
  static constexpr int stages = 6;
  static constexpr std::array<std::array<T,6>,6> a{{
    {0,0,0,0,0,0},
    {T(1)/5,0,0,0,0,0},
    {T(3)/40,T(9)/40,0,0,0,0},
    {T(3)/10,-T(9)/10,T(6)/5,0,0,0},
    {-T(11)/54,T(5)/2,-T(70)/27,T(35)/27,0,0},
    {T(1631)/55296,T(175)/512,T(575)/13824,T(44275)/110592,T(253)/4096,0}}};
  static constexpr std::array<T,6> b{T(37)/378,0,T(250)/621,T(125)/594,0,T(512)/1771};
  static constexpr std::array<T,6> bs{T(2825)/27648,0,T(18575)/48384,T(13525)/55296,T(277)/14336,T(1)/4};
  static constexpr std::array<T,6> c{0,T(1)/5,T(3)/10,T(3)/5,1,T(7)/8};
};
}
