// Order of a Runge-Kutta tableau over rooted trees, through order 8. C++17, no dependencies.
//
//   glmref::Report report = glmref::check(text);
//   c++ -std=c++17 -O2 -DGLMREF_CHECK_MAIN -x c++ check.hpp -o check; ./check rk4.txt gauss-2.txt
//
// A text has the rows of A, then `b: ...`, and where there are any `c: ...` and `b_hat NAME: ...`.
// Entries are apart by blanks or commas, and are made of + - * / ( ) sqrt(x) root(x,n). A number
// with a point is exact, unless there is a line `digits: N`: then it is known to one unit of the
// N-th digit. Rational tableaux are decided exactly: a residual is a whole number over
// gamma(t) L^n, L the common denominator; it is 0 if it is 0 modulo so many coprime numbers that
// their product exceeds it. The rest, and sizes, are computed in intervals of doubles, rounded
// outwards: what is said to fail is proved to fail, and what does not is right to `within`.
// Needs doubles of IEEE 754 and 128-bit integers. CC0 1.0.
#ifndef GLMREF_CHECK_HPP
#define GLMREF_CHECK_HPP
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace glmref {
using u64 = std::uint64_t;
using u128 = unsigned __int128;
using Error = std::runtime_error;
using Texts = std::vector<std::string>;
constexpr int MOST = 8, MOST_STAGES = 60;
constexpr double NEAR = 1e-9;

struct Row {               // what is known of one row of weights
  std::string name, tree;  // tree: the first whose condition fails
  int order = MOST, failing = 0, near = MOST;  // near: the order but for residuals up to 1e-9
  bool capped = true;                          // no condition through order 8 fails
  double lo = 0, hi = 0, within = 0;  // residual of that tree; most that those before can be off
};
struct Report { int stages; bool exact, has_c, row_sums; std::vector<Row> rows; };

// --- numbers: where `modulus` is 0 an interval, rounded outwards, or else a rest of that division
inline thread_local u64 modulus = 0;  // at most 2^61, without small divisors
struct Number {
  double lo = 0, hi = 0;
  u64 rest = 0;  // in what `decide` returns: whether the number is not 0
  bool nil() const { return lo == 0 && hi == 0; }
  double size() const { return std::max(std::fabs(lo), std::fabs(hi)); }
};
using Numbers = std::vector<Number>;
inline Number whole(u64 n) { return {static_cast<double>(n), static_cast<double>(n), n}; }
inline Number modular(u128 n) { return {0, 0, static_cast<u64>(n % modulus)}; }
inline Number outwards(double lo, double hi) {
  return {std::nextafter(lo, -INFINITY), std::nextafter(hi, INFINITY)};
}
inline Number operator+(Number a, Number b) {
  if (modulus) return {0, 0, (a.rest + b.rest) % modulus};
  if (a.nil() || b.nil()) return a.nil() ? b : a;
  return outwards(a.lo + b.lo, a.hi + b.hi);
}
inline Number operator-(Number a) { return {-a.hi, -a.lo, a.rest ? modulus - a.rest : 0}; }
inline Number operator*(Number a, Number b) {
  if (modulus) return modular(static_cast<u128>(a.rest) * b.rest);
  if (a.nil() || b.nil()) return {};
  const auto ends = std::minmax({a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi});
  return outwards(ends.first, ends.second);
}
inline Number power(Number a, u64 n) {
  return n == 0 ? whole(1) : n % 2 ? a * power(a, n - 1) : power(a * a, n / 2);
}
inline Number inverse(Number a) {
  if (!modulus && a.lo <= 0 && a.hi >= 0) throw Error("a division by zero");
  if (!modulus) return outwards(1 / a.hi, 1 / a.lo);
  Number found = whole(1);
  for (u64 x = a.rest; x != 1; x = modulus % x) {  // x (modulus / x) + modulus % x is 0
    if (x == 0) throw Error("a divisor of the modulus");
    found = found * Number{0, 0, modulus - modulus / x};
  }
  return found;
}
inline Number root(Number a, u64 n) {
  if (n < 1 || n > 60) throw Error("a root of a degree that is not 1 to 60");
  if (a.lo < 0) throw Error("a root of a negative number");
  double lo = std::pow(a.lo, 1.0 / n), hi = std::pow(a.hi, 1.0 / n);
  while (lo > 0 && power({lo, lo}, n).hi > a.lo) lo = std::nextafter(lo, -INFINITY);
  while (power({hi, hi}, n).lo < a.hi) hi = std::nextafter(hi, INFINITY);
  return {lo, hi};
}
inline Number dot(const Numbers& x, const Numbers& y) {
  Number total;
  u128 sum = 0;  // holds MOST_STAGES products below 2^122
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (modulus) sum += static_cast<u128>(x[k].rest) * y[k].rest;
    else total = total + x[k] * y[k];
  }
  return modulus ? modular(sum) : total;
}

// --- entries
struct Parser {
  const std::string& text;
  std::size_t digits;    // of decimals, 0 where they are exact
  bool rational = true;  // no root and no decimal of a number
  std::size_t at = 0;

  char next() {
    while (at < text.size() && text[at] == ' ') ++at;
    return at < text.size() ? text[at] : '\0';
  }
  bool take(const std::string& word) {
    const bool found = next() == word[0] && text.compare(at, word.size(), word) == 0;
    if (found) at += word.size();
    return found;
  }
  void want(const std::string& word) {
    if (!take(word)) throw Error("'" + word + "' is missing");
  }
  Number number() {
    const std::string token = text.substr(at, text.find_first_not_of("0123456789.", at) - at);
    const std::size_t point = token.find('.'), size = token.size();
    const bool decimal = point != std::string::npos;
    if (size == decimal || token.rfind('.') != point)
      throw Error("'" + text.substr(at, size + !size) + "' is not read");
    const std::size_t places = decimal ? size - point - 1 : 0;
    if (decimal && places < digits)
      throw Error("'" + token + "' has fewer than " + std::to_string(digits) + " digits");
    at += size;
    if (token.find_first_not_of("0.") == std::string::npos) return {};
    if (modulus) {
      Number found;
      for (char x : token)
        if (x != '.') found = found * whole(10) + whole(static_cast<u64>(x - '0'));
      return decimal ? found * inverse(power(whole(10), places)) : found;
    }
    const double x = std::strtod(token.c_str(), nullptr);
    if (!decimal || !digits) return size < 16 && !decimal ? Number{x, x} : outwards(x, x);
    rational = false;
    const double unit = inverse(power(whole(10), digits)).hi;
    return outwards(x, x) + Number{-unit, unit};
  }
  Number atom() {
    const bool square = take("sqrt("), any = !square && take("root(");
    if (!square && !any && !take("(")) return number();
    const Number inside = sum();
    if (any) want(","), next();
    const Number degree = any ? number() : whole(2);
    want(")");
    if (!square && !any) return inside;
    rational = false;
    return root(inside, static_cast<u64>(std::min(degree.lo, 99.0)));
  }
  Number factor() {
    if (take("-")) return -factor();
    return take("+") ? factor() : atom();
  }
  Number sum() {
    Number total;
    for (Number term = factor();;) {
      if (take("*")) term = term * factor();
      else if (take("/")) term = term * inverse(factor());
      else {
        total = total + term;
        if (next() != '+' && next() != '-') return total;
        term = factor();  // with its sign
      }
    }
  }
  Number all() {
    const Number found = sum();
    if (at == text.size()) return found;
    throw Error("'" + text.substr(at, 9) + "' behind the end of a number");
  }
};

// --- tableaux
struct Line { std::string name; Texts entries; };
struct Tableau {
  std::vector<Line> rows;               // of weights, the s rows of A and, where it is given, c
  std::vector<Numbers> intervals;       // their values
  std::size_t weights = 0, s = 0, digits = 0;
  std::size_t denominator = 0;          // at most so many figures has the common denominator
  bool has_c = false, rational = true;
};

inline std::string trim(const std::string& text) {
  const auto from = text.find_first_not_of(" \t\r"), to = text.find_last_not_of(" \t\r");
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}
inline Texts split(const std::string& line) {  // at blanks, commas, semicolons outside of brackets
  Texts found(1);
  int depth = 0;
  for (char letter : line) {
    depth += letter == '(' ? 1 : letter == ')' ? -1 : 0;
    const bool between = depth <= 0 && std::string(" \t\r,;").find(letter) != std::string::npos;
    if (!between) found.back() += letter == '\t' ? ' ' : letter;
    else if (!found.back().empty()) found.emplace_back();
  }
  if (found.back().empty()) found.pop_back();
  return found;
}
inline Tableau read(const std::string& text) {
  Tableau tab;
  std::vector<Line> A, c;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('#'));
    const auto colon = line.find(':'), after = colon == std::string::npos ? 0 : colon + 1;
    const std::string name = trim(line.substr(0, after ? colon : 0));
    const Texts row = split(line.substr(after));
    if (row.empty()) continue;
    if (name == "digits") {
      const int digits = std::atoi(row[0].c_str());
      if (digits < 1 || digits > 150) throw Error("`digits` must be a whole number from 1 to 150");
      tab.digits = static_cast<std::size_t>(digits);
    } else if (name.empty()) {
      A.push_back({"row " + std::to_string(A.size() + 1) + " of A", row});
    } else if (name == "c") {
      c = {{name, row}};
    } else if (name == "b" || name.rfind("b_hat", 0) == 0) {
      const std::string rest = name == "b" ? "" : trim(name.substr(5));
      tab.rows.push_back({rest.empty() ? name : rest, row});
    } else {
      throw Error("'" + name + "' is none of b, c, b_hat NAME, digits");
    }
  }
  const std::string s = std::to_string(tab.s = A.size());
  if (A.empty() || A.size() > MOST_STAGES) throw Error("A must have 1 to 60 rows, got " + s);
  if (std::none_of(tab.rows.begin(), tab.rows.end(), [](auto& x) { return x.name == "b"; }))
    throw Error("the row `b: ...` is missing");
  tab.weights = tab.rows.size();
  tab.has_c = !c.empty();
  tab.rows.insert(tab.rows.end(), A.begin(), A.end());
  tab.rows.insert(tab.rows.end(), c.begin(), c.end());
  std::set<std::string> divisors;  // a divisor that is there twice counts once
  std::size_t places = 0;
  for (const auto& [name, entries] : tab.rows) {
    if (entries.size() != tab.s)
      throw Error(name + " has " + std::to_string(entries.size()) + " entries and must have " + s);
    Numbers& values = tab.intervals.emplace_back();
    for (const auto& entry : entries) {
      const std::string k = std::to_string(values.size() + 1);
      if (entry.size() > 500) throw Error(name + ": entry " + k + " has more than 500 characters");
      Parser parser{entry, tab.digits};
      try {
        values.push_back(parser.all());
      } catch (const Error& error) {
        throw Error(name + ", entry " + k + ": " + error.what());
      }
      tab.rational = tab.rational && parser.rational;
      // No part of the fraction that an entry is has more figures than the entry has letters: a
      // product at most adds up the figures of its factors, and for one more of a sum is its sign.
      const auto slash = entry.find('/'), point = entry.find('.');
      const std::string divisor = slash < point ? entry.substr(slash + 1) : entry;  // before: whole
      if (slash == std::string::npos) places = std::max(places, point < slash ? entry.size() : 0);
      else if (divisors.insert(divisor).second) tab.denominator += divisor.size();
    }
  }
  tab.denominator += places;
  return tab;
}

// --- trees: the branches of `rest` and before them `kid`; the leaf `t` is time, where c is not A 1
struct Tree { std::size_t kid, rest; int n; u64 gamma; std::string text; };

inline std::vector<Tree> trees(bool timed) {
  std::vector<Tree> found{{0, 0, 1, 1, "o"}};
  if (timed) found.insert(found.begin(), {0, 0, 1, 1, "t"});
  const std::size_t leaf = timed ? 1 : 0;
  for (int n = 2; n <= MOST; ++n) {
    const std::vector<Tree> smaller = found;
    for (std::size_t k = 0; k < smaller.size(); ++k)
      for (std::size_t m = leaf; m < smaller.size(); ++m) {
        const Tree &kid = smaller[k], &rest = smaller[m];
        if (kid.n + rest.n != n || (m != leaf && rest.kid < k)) continue;  // each set once
        const u64 gamma = rest.gamma / static_cast<u64>(rest.n) * kid.gamma * static_cast<u64>(n);
        const std::string others = m == leaf ? "]" : rest.text.substr(1);
        found.push_back({k, m, n, gamma, "[" + kid.text + others});
      }
  }
  return found;
}

// --- conditions
// A 1 - c in row 0 where there are no trees; else Phi(t) - 1/gamma(t) in row 1 + r for weights r.
inline std::vector<Numbers> residuals(const Tableau& tab, const std::vector<Numbers>& rows,
                                      const std::vector<Tree>& trees) {
  const std::size_t weights = tab.weights;
  const Numbers ones(tab.s, whole(1));
  std::vector<Numbers> found(1 + weights), product, times_A;
  for (std::size_t i = 0; trees.empty() && tab.has_c && i < tab.s; ++i)
    found[0].push_back(dot(rows[weights + i], ones) + -rows.back()[i]);
  for (const Tree& tree : trees) {
    product.push_back(tree.n == 1 ? ones : product[tree.rest]);
    Numbers& x = product.back();
    for (std::size_t i = 0; tree.n > 1 && i < tab.s; ++i) x[i] = x[i] * times_A[tree.kid][i];
    times_A.push_back(tree.text == "t" ? rows.back() : Numbers(tab.s));
    for (std::size_t i = 0; tree.text != "t" && tree.n < MOST && i < tab.s; ++i)
      times_A.back()[i] = dot(rows[weights + i], x);
    const Number wanted = -inverse(whole(tree.gamma));
    for (std::size_t r = 0; r < weights; ++r) found[1 + r].push_back(dot(rows[r], x) + wanted);
  }
  return found;
}
inline std::vector<Numbers> decide(const Tableau& tab, const std::vector<Tree>& trees) {
  auto found = residuals(tab, tab.intervals, trees);
  double largest = 1;
  for (Numbers& row : found) for (Number& x : row) {
    if (!std::isfinite(x.hi - x.lo)) throw Error("the numbers are too large for doubles");
    largest = std::max(largest, x.size());
    x.rest = x.lo > 0 || x.hi < 0;
  }
  if (!tab.rational) return found;
  // L^n at most, and gamma(t), which divides 8! < 2^16
  const double figures = static_cast<double>((trees.empty() ? 1 : MOST) * tab.denominator);
  double left = std::log2(largest) + std::log2(10) * figures + 18;
  // moduli, and behind the product of the primes below 50
  std::vector<u64> used{614889782588491410};
  for (u64 p = (u64{1} << 61) - 1; left > 0; p -= 2) {
    if (std::any_of(used.begin(), used.end(), [p](u64 q) { return std::gcd(p, q) > 1; })) continue;
    modulus = p;
    try {
      std::vector<Numbers> rests;
      std::map<std::string, Number> known;
      for (const Line& row : tab.rows) {
        Numbers& values = rests.emplace_back();
        for (const auto& entry : row.entries) {
          const auto [at, fresh] = known.try_emplace(entry);
          if (fresh) at->second = Parser{entry, tab.digits}.all();
          values.push_back(at->second);
        }
      }
      rests = residuals(tab, rests, trees);
      for (std::size_t r = 0; r < found.size(); ++r)
        for (std::size_t m = 0; m < found[r].size(); ++m) found[r][m].rest |= rests[r][m].rest;
      used.push_back(p);
      left -= 60;
    } catch (const Error&) {  // with a denominator it has a divisor in common
    }
  }
  modulus = 0;
  for (Numbers& row : found) for (Number& x : row) if (!x.rest) x = {};
  return found;
}

inline Report check(const std::string& text) {
  const Tableau tab = read(text);
  Report report{static_cast<int>(tab.s), tab.rational, tab.has_c, true, {}};
  const auto sums = decide(tab, {});
  for (const Number& sum : sums[0]) report.row_sums = report.row_sums && !sum.rest;
  const auto listed = trees(!report.row_sums);
  const auto found = decide(tab, listed);
  for (std::size_t r = 0; r < tab.weights; ++r) {
    Row row;
    row.name = tab.rows[r].name;
    for (std::size_t m = 0; m < listed.size(); ++m) {
      const Number& x = found[1 + r][m];
      const bool fails = x.rest != 0;
      const int n = listed[m].n;
      if (listed[m].text == "t") continue;
      if (fails && row.capped) {
        row.capped = false;
        row.order = n - 1;
        row.tree = listed[m].text;
        row.lo = x.lo, row.hi = x.hi;
      }
      if (fails && n == row.order + 1) ++row.failing;
      if (row.capped) row.within = std::max(row.within, x.size());
      if (x.size() > NEAR) row.near = std::min(row.near, n - 1);
    }
    report.rows.push_back(row);
  }
  return report;
}

// --- output
inline std::string quoted(const std::string& text) {
  std::string found;
  for (char letter : text)
    found += (letter == '"' || letter == '\\' ? "\\" : "") + std::string(1, letter);
  return '"' + found + '"';
}
inline std::string json(const Report& report) {
  const auto number = [](double x) {
    char text[40];
    std::snprintf(text, sizeof text, "%.2e", x);
    return std::string(text);
  };
  std::ostringstream out;
  out << std::boolalpha << R"({"stages":)" << report.stages << R"(,"exact":)" << report.exact;
  out << R"(,"row_sums":)" << (!report.has_c ? "null" : report.row_sums ? "true" : "false");
  for (const Row& row : report.rows) {
    const bool signed_ = row.lo > 0 || row.hi < 0;  // or else too small for doubles: a bound
    const std::string bound = "<" + number(std::max(-row.lo, row.hi));
    const std::string residual = signed_ ? number((row.lo + row.hi) / 2) : bound;
    out << (&row == &report.rows[0] ? R"(,"rows":{)" : ",") << quoted(row.name) << R"(:{"order":)"
        << row.order << R"(,"capped":)" << row.capped << R"(,"failing":)" << row.failing
        << R"(,"tree":)" << (row.capped ? "null" : quoted(row.tree))
        << R"(,"residual":)" << (row.capped ? "null" : quoted(residual))
        << R"(,"within":)" << quoted(row.within > 0 ? number(row.within) : "0")
        << R"(,"near":)" << row.near << '}';
  }
  return out.str() + "}}";
}
}  // namespace glmref

#ifdef GLMREF_CHECK_MAIN
int main(int count, char** words) {
  int code = 0;
  for (int k = 1; k < count; ++k) {
    std::ifstream file(words[k]);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    try {
      std::cout << glmref::json(glmref::check(text)) << "\n";
    } catch (const glmref::Error& error) {
      std::cout << "{\"error\":" << glmref::quoted(error.what()) << "}\n";
      code = 2;
    }
  }
  return code;
}
#endif
#endif
