// Order of a Runge-Kutta tableau over rooted trees, through order 8. One header, C++17, no dependencies.
//
//   glmref::Report report = glmref::check(text);
//   c++ -std=c++17 -O2 -DGLMREF_CHECK_MAIN -x c++ check.hpp -o check; ./check rk4.txt gauss-2.txt
//
// A text has the rows of A, then `b: ...`, and where there are any `c: ...` and `b_hat NAME: ...`.
// Entries are apart by blanks or commas, and are made of + - * / ( ) sqrt(x) root(x,n). A number with
// a point is exact, unless `digits: N` stands above: then it is known to one unit of the N-th digit.
// Rational tableaux are decided exactly: a residual is a whole number over gamma(t) L^n, L the common
// denominator; it is 0 if it is 0 modulo so many primes that their product exceeds it. The rest, and
// sizes, are computed in intervals of doubles, rounded outwards: what is said to fail is proved to
// fail, and what does not is right to `within`. Needs doubles of IEEE 754 and 128-bit integers. CC0 1.0.
#ifndef GLMREF_CHECK_HPP
#define GLMREF_CHECK_HPP
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace glmref {
using u64 = std::uint64_t;
constexpr int MOST = 8, MOST_STAGES = 60;
constexpr double NEAR = 1e-9, INF = std::numeric_limits<double>::infinity();

struct Row {                 // what is known of one row of weights
  std::string name, tree;    // tree: the first whose condition fails
  int order = 0, failing = 0, near = 0;  // near: the order but for residuals up to 1e-9
  bool capped = true;        // no condition through order 8 fails
  double lo = 0, hi = 0, within = 0;  // residual of that tree; the most that the others can be off
};
struct Report { int stages = 0; bool exact = true, has_c = false, row_sums = true; std::vector<Row> rows; };

// --- intervals of doubles, each operation rounded outwards
struct Interval { double lo = 0, hi = 0; };
inline double down(double x) { return std::nextafter(x, -INF); }
inline double up(double x) { return std::nextafter(x, INF); }
inline bool nil(Interval a) { return a.lo == 0 && a.hi == 0; }
inline Interval operator+(Interval a, Interval b) {
  if (nil(a)) return b;
  return nil(b) ? a : Interval{down(a.lo + b.lo), up(a.hi + b.hi)};
}
inline Interval operator-(Interval a) { return {-a.hi, -a.lo}; }
inline Interval operator*(Interval a, Interval b) {
  if (nil(a) || nil(b)) return {};
  const double p[] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
  return {down(*std::min_element(p, p + 4)), up(*std::max_element(p, p + 4))};
}
inline Interval inverse(Interval b) {
  if (b.lo <= 0 && b.hi >= 0) throw std::runtime_error("a division by zero");
  return {down(1 / b.hi), up(1 / b.lo)};
}
inline Interval power(Interval a, int n) {
  Interval found{1, 1};
  while (n-- > 0) found = found * a;
  return found;
}
inline Interval root(Interval a, int n) {
  if (n < 1 || n > 60) throw std::runtime_error("a root of a degree that is not 1 to 60");
  if (a.lo < 0) throw std::runtime_error("a root of a negative number");
  double lo = std::pow(a.lo, 1.0 / n), hi = std::pow(a.hi, 1.0 / n);
  while (lo > 0 && power({lo, lo}, n).hi > a.lo) lo = down(lo);
  while (power({hi, hi}, n).lo < a.hi) hi = up(hi);
  return {lo, hi};
}

// --- integers modulo a prime below 2^61
inline u64 mul(u64 a, u64 b, u64 p) { return static_cast<u64>(static_cast<unsigned __int128>(a) * b % p); }
inline u64 pow(u64 a, u64 e, u64 p) {
  u64 found = 1;
  for (; e; e >>= 1, a = mul(a, a, p)) if (e & 1) found = mul(found, a, p);
  return found;
}
inline bool prime(u64 n) {  // Miller and Rabin; these bases decide below 3.3e24
  int twos = 0;
  u64 odd = n - 1;
  for (; odd % 2 == 0; odd /= 2) ++twos;
  for (u64 base : {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37}) {
    u64 x = pow(base, odd, n);
    if (x == 1 || x == n - 1) continue;
    int k = 1;
    for (; k < twos && x != n - 1; ++k) x = mul(x, x, n);
    if (x != n - 1) return false;
  }
  return true;
}

// --- entries: a sum as text, evaluated as an interval, or modulo a prime
struct Parser {
  const std::string& text;
  int digits;              // of decimals, 0 where they are exact
  u64 p;                   // 0: as an interval
  bool rational = true;    // no root and no decimal of a number
  bool zero_divisor = false;  // modulo p: take another prime
  double bits = 0;         // the denominator divides a whole number of so many bits
  std::size_t at = 0;
  struct Value { Interval x; u64 r = 0; double up = 0, down = 0; };  // up, down: bits of a fraction

  explicit Parser(const std::string& entry, int known, u64 modulus) : text(entry), digits(known), p(modulus) {}
  char next() {
    while (at < text.size() && text[at] == ' ') ++at;
    return at < text.size() ? text[at] : '\0';
  }
  void want(char letter) {
    if (next() != letter) throw std::runtime_error(std::string("'") + letter + "' is missing");
    ++at;
  }
  Value number() {
    std::size_t start = at, point = std::string::npos;
    for (; at < text.size() && (std::isdigit(static_cast<unsigned char>(text[at])) || (text[at] == '.' && point == std::string::npos)); ++at)
      if (text[at] == '.') point = at;
    const std::string token = text.substr(start, at - start);
    if (token.empty() || token == ".") throw std::runtime_error("'" + text.substr(start, 1) + "' is not read");
    const int places = point == std::string::npos ? 0 : static_cast<int>(start + token.size() - point - 1);
    Value found;
    const double x = std::strtod(token.c_str(), nullptr);
    const bool small = token.size() < 16 && places == 0;
    found.x = small || x == 0 ? Interval{x, x} : Interval{down(x), up(x)};
    if (digits && point != std::string::npos) {
      if (places < digits) throw std::runtime_error("'" + token + "' has fewer than " + std::to_string(digits) + " digits");
      if (token.find_first_not_of("0.") != std::string::npos) {
        rational = false;
        const double unit = up(std::pow(10.0, -digits) * (1 + 1e-15));
        found.x = {down(found.x.lo - unit), up(found.x.hi + unit)};
      }
    }
    found.up = 3.33 * static_cast<double>(token.size());
    found.down = 3.33 * places;
    if (p) {
      for (char letter : token) if (letter != '.') found.r = (mul(found.r, 10, p) + static_cast<u64>(letter - '0')) % p;
      found.r = mul(found.r, pow(pow(10, static_cast<u64>(places), p), p - 2, p), p);
    }
    return found;
  }
  Value atom() {
    const bool is_sqrt = (next(), text.compare(at, 5, "sqrt(") == 0), is_root = text.compare(at, 5, "root(") == 0;
    if (next() != '(' && !is_sqrt && !is_root) return number();
    at += is_sqrt || is_root ? 5 : 1;
    Value found = sum();
    int degree = 2;
    if (is_root) {
      want(',');
      next();
      degree = static_cast<int>(number().x.lo);
    }
    want(')');
    if (is_sqrt || is_root) {
      rational = false;
      found.x = root(found.x, degree);
    }
    return found;
  }
  Value factor() {
    const char sign = next();
    if (sign != '-' && sign != '+') return atom();
    ++at;
    Value found = factor();
    if (sign == '-') {
      found.x = -found.x;
      if (p) found.r = (p - found.r) % p;
    }
    return found;
  }
  Value product() {
    Value found = factor();
    for (char sign = next(); sign == '*' || sign == '/'; sign = next()) {
      ++at;
      Value other = factor();
      if (sign == '/') {
        other.x = inverse(other.x);
        if (p && other.r == 0) zero_divisor = true;
        if (p) other.r = pow(other.r, p - 2, p);
        std::swap(other.up, other.down);
      }
      found.x = found.x * other.x;
      if (p) found.r = mul(found.r, other.r, p);
      found.up += other.up;
      found.down += other.down;
    }
    return found;
  }
  Value sum() {
    Value found = product();
    for (char sign = next(); sign == '+' || sign == '-'; sign = next()) {
      ++at;
      const Value other = product();
      found.x = found.x + (sign == '+' ? other.x : -other.x);
      if (p) found.r = (found.r + (sign == '+' ? other.r : p - other.r)) % p;
      found.up = 1 + std::max(found.up + other.down, other.up + found.down);
      found.down += other.down;
    }
    return found;
  }
  Value all() {
    const Value found = sum();
    if (next() != '\0') throw std::runtime_error("'" + text.substr(at, 9) + "' behind the end of a number");
    bits = found.down;
    return found;
  }
};

// --- tableaux
using Texts = std::vector<std::string>;
struct Tableau { std::vector<Texts> A; std::vector<std::pair<std::string, Texts>> rows; Texts c; int digits = 0; };

inline Texts split(const std::string& line) {  // at blanks, commas and semicolons outside of brackets
  Texts found;
  std::string entry;
  int depth = 0;
  for (char letter : line + " ") {
    depth += letter == '(' ? 1 : letter == ')' ? -1 : 0;
    const bool between = depth <= 0 && std::string(" \t\r,;").find(letter) != std::string::npos;
    if (!between) entry += letter == '\t' ? ' ' : letter;
    if ((between) && !entry.empty()) found.push_back(entry), entry.clear();
  }
  if (!entry.empty()) found.push_back(entry);
  return found;
}
inline Tableau read(const std::string& text) {
  Tableau tableau;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('#'));
    const auto colon = line.find(':');
    std::string name = colon == std::string::npos ? "" : line.substr(0, colon);
    name.erase(0, name.find_first_not_of(" \t"));
    while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back()))) name.pop_back();
    const Texts row = split(colon == std::string::npos ? line : line.substr(colon + 1));
    if (row.empty()) continue;
    if (name == "digits") {
      tableau.digits = std::atoi(row[0].c_str());
      if (tableau.digits < 1 || tableau.digits > 150) throw std::runtime_error("`digits` must be a whole number from 1 to 150");
    } else if (name.empty()) {
      tableau.A.push_back(row);
    } else if (name == "c") {
      tableau.c = row;
    } else if (name == "b" || name.rfind("b_hat", 0) == 0) {
      const auto rest = name == "b" ? 0 : name.find_first_not_of(" \t", 5);
      tableau.rows.emplace_back(rest == std::string::npos ? name : name.substr(rest), row);
    } else {
      throw std::runtime_error("'" + name + "' is none of b, c, b_hat NAME, digits");
    }
  }
  const auto s = tableau.A.size();
  if (s == 0 || s > MOST_STAGES) throw std::runtime_error("A must have 1 to " + std::to_string(MOST_STAGES) + " rows, got " + std::to_string(s));
  auto rows = tableau.rows;
  if (std::none_of(rows.begin(), rows.end(), [](auto& x) { return x.first == "b"; })) throw std::runtime_error("the row `b: ...` is missing");
  for (std::size_t k = 0; k < s; ++k) rows.emplace_back("row " + std::to_string(k + 1) + " of A", tableau.A[k]);
  if (!tableau.c.empty()) rows.emplace_back("c", tableau.c);
  for (const auto& [name, row] : rows) {
    if (row.size() != s) throw std::runtime_error(name + " has " + std::to_string(row.size()) + " entries and must have " + std::to_string(s));
    for (std::size_t k = 0; k < s; ++k) {
      if (row[k].size() > 500) throw std::runtime_error(name + ": entry " + std::to_string(k + 1) + " has more than 500 characters");
      try {
        Parser(row[k], tableau.digits, 0).all();
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(name + ", entry " + std::to_string(k + 1) + ": " + error.what());
      }
    }
  }
  return tableau;
}

// --- trees; the leaf `t` is the time, where c is not A 1
struct Tree { std::vector<int> kids; int n = 1; u64 gamma = 1; std::string text; bool time = false; };

inline std::vector<Tree> trees(bool timed) {
  std::vector<Tree> pool;
  if (timed) pool.push_back({{}, 1, 1, "t", true});
  for (int n = 1; n <= MOST; ++n) {
    std::vector<Tree> level;
    std::function<void(int, int, const std::vector<int>&)> grow = [&](int left, int from, const std::vector<int>& kids) {
      if (left == 0) {
        Tree tree{kids, n, static_cast<u64>(n), "o", false};
        if (!kids.empty()) tree.text = "[";
        for (int kid : kids) tree.gamma *= pool[kid].gamma, tree.text += pool[kid].text;
        if (!kids.empty()) tree.text += "]";
        level.push_back(tree);
      }
      for (int k = from; k < static_cast<int>(pool.size()) && pool[k].n <= left; ++k) {
        auto more = kids;
        more.push_back(k);
        grow(left - pool[k].n, k, more);
      }
    };
    grow(n - 1, 0, {});
    pool.insert(pool.end(), level.begin(), level.end());
  }
  return pool;
}

// Phi(t) - 1/gamma(t) of every tree and row, [row][tree], over intervals or modulo a prime.
template <class T, class Add, class Mul, class Less>
std::vector<std::vector<T>> residuals(const std::vector<Tree>& all, const std::vector<std::vector<T>>& A,
                                      const std::vector<std::vector<T>>& rows, const std::vector<T>& c, T one, Add add, Mul times, Less less) {
  const std::size_t s = A.size();
  std::vector<std::vector<T>> weight(all.size()), found(rows.size());
  const auto dot = [&](const std::vector<T>& x, const std::vector<T>& y) {
    T total{};
    for (std::size_t k = 0; k < s; ++k) total = add(total, times(x[k], y[k]));
    return total;
  };
  for (std::size_t m = 0; m < all.size(); ++m) {
    std::vector<T> product(s, one);
    for (int kid : all[m].kids) for (std::size_t i = 0; i < s; ++i) product[i] = times(product[i], weight[kid][i]);
    if (all[m].time) weight[m] = c;
    else if (all[m].n < MOST) for (std::size_t i = 0; i < s; ++i) weight[m].push_back(dot(A[i], product));
    for (std::size_t r = 0; r < rows.size(); ++r) found[r].push_back(less(dot(rows[r], product), all[m].gamma));
  }
  return found;
}

inline Report check(const std::string& text) {
  const Tableau tab = read(text);
  const std::size_t s = tab.A.size();
  std::vector<Texts> all = tab.A;
  for (const auto& row : tab.rows) all.push_back(row.second);
  const bool has_c = !tab.c.empty();
  if (has_c) all.push_back(tab.c);
  bool rational = true;
  double bits = 0, tens = 0;
  std::set<std::string> counted;  // denominators that are counted in L already
  for (const auto& row : all) for (const auto& entry : row) {
    Parser parser(entry, tab.digits, 0);
    parser.all();
    rational = rational && parser.rational;
    const auto slash = entry.find('/');
    if (slash == std::string::npos && entry.find_first_of("()*") == std::string::npos) tens = std::max(tens, parser.bits);
    else if (counted.insert(entry.find_first_of("()*+.", 1) == std::string::npos ? entry.substr(slash) : entry).second) bits += parser.bits;
  }
  bits += tens;
  const auto evaluated = [&](u64 p, auto pick, bool* again) {
    using T = decltype(pick(Parser::Value{}));
    std::map<std::string, T> known;
    std::vector<std::vector<T>> found;
    for (const auto& row : all) {
      found.emplace_back();
      for (const auto& entry : row) {
        if (!known.count(entry)) {
          Parser parser(entry, tab.digits, p);
          known[entry] = pick(parser.all());
          *again = *again || parser.zero_divisor;
        }
        found.back().push_back(known[entry]);
      }
    }
    return found;
  };
  u64 p = (u64{1} << 61) - 1;
  const auto modulo = [&] {  // the entries modulo the next prime that divides no denominator
    for (;; p -= 2) {
      bool again = false;
      if (!prime(p)) continue;
      auto found = evaluated(p, [](const Parser::Value& x) { return x.r; }, &again);
      if (!again) return found;
    }
  };
  bool unused = false;
  const auto boxes = evaluated(0, [](const Parser::Value& x) { return x.x; }, &unused);
  bool apart = false;
  if (has_c && !rational) {
    for (std::size_t i = 0; i < s; ++i) {
      Interval off = -boxes.back()[i];
      for (Interval x : boxes[i]) off = off + x;
      apart = apart || off.lo > 0 || off.hi < 0;
    }
  } else if (has_c) {
    for (double left = bits + 64 + 2 * std::log2(1e300); left > 0 && !apart; left -= 60, p -= 2) {
      const auto numbers = modulo();
      for (std::size_t i = 0; i < s; ++i) {
        u64 off = p - numbers.back()[i];
        for (u64 x : numbers[i]) off = (off + x) % p;
        apart = apart || off % p != 0;
      }
    }
  }
  const auto listed = trees(apart);
  const auto part = [&](const auto& numbers, std::size_t from, std::size_t to) {
    return std::decay_t<decltype(numbers)>(numbers.begin() + static_cast<long>(from), numbers.begin() + static_cast<long>(to));
  };
  const std::size_t rows = tab.rows.size();
  const auto sizes = residuals<Interval>(listed, part(boxes, 0, s), part(boxes, s, s + rows), boxes.back(), Interval{1, 1},
    [](Interval a, Interval b) { return a + b; }, [](Interval a, Interval b) { return a * b; },
    [](Interval S, u64 gamma) { const double g = static_cast<double>(gamma); return S + -Interval{down(1 / g), up(1 / g)}; });
  std::vector<std::vector<char>> zero(rows, std::vector<char>(listed.size(), 1));
  double needed = 0, done = 0;
  for (const auto& row : sizes) for (std::size_t m = 0; m < listed.size(); ++m) {
    const double size = std::max({std::fabs(row[m].lo), std::fabs(row[m].hi), 1.0});
    if (!std::isfinite(size)) throw std::runtime_error("the numbers are too large for doubles");
    needed = std::max(needed, std::log2(size) + std::log2(static_cast<double>(listed[m].gamma)) + listed[m].n * bits + 2);
  }
  for (; rational && done < needed; done += 60, p -= 2) {
    const auto numbers = modulo();
    const auto found = residuals<u64>(listed, part(numbers, 0, s), part(numbers, s, s + rows), numbers.back(), 1,
      [p](u64 a, u64 b) { return (a + b) % p; }, [p](u64 a, u64 b) { return a && b ? mul(a, b, p) : 0; },
      [p](u64 S, u64 gamma) { return (mul(S, gamma % p, p) + p - 1) % p; });
    bool any = false;
    for (std::size_t r = 0; r < rows; ++r) for (std::size_t m = 0; m < listed.size(); ++m) {
      if (found[r][m]) zero[r][m] = 0;
      any = any || zero[r][m];
    }
    if (!any) break;
  }
  Report report{static_cast<int>(s), rational, has_c, !apart, {}};
  for (std::size_t r = 0; r < rows; ++r) {
    Row row;
    row.name = tab.rows[r].first;
    int failed = 0, close = MOST + 1;
    for (std::size_t m = 0; m < listed.size(); ++m) {
      const Tree& tree = listed[m];
      if (tree.time) continue;
      const Interval x = sizes[r][m];
      const double size = rational && zero[r][m] ? 0 : std::max(std::fabs(x.lo), std::fabs(x.hi));
      const bool fails = rational ? !zero[r][m] : x.lo > 0 || x.hi < 0;
      if (fails && !failed) failed = tree.n, row.tree = tree.text, row.lo = x.lo, row.hi = x.hi;
      if (fails && failed == tree.n) ++row.failing;
      if (!failed && !rational) row.within = std::max(row.within, size);
      if (size > NEAR) close = std::min(close, tree.n);
    }
    row.capped = !failed;
    row.order = failed ? failed - 1 : MOST;
    row.near = close - 1;
    report.rows.push_back(row);
  }
  return report;
}

inline std::string quoted(const std::string& text) {
  std::string found = "\"";
  for (char letter : text) found += letter == '"' || letter == '\\' ? std::string("\\") + letter : std::string(1, letter);
  return found + '"';
}
inline std::string json(const Report& report) {
  std::ostringstream out;
  const auto number = [](double x) { char text[40]; std::snprintf(text, sizeof text, "%.2e", x); return std::string(text); };
  const auto residual = [&](const Row& row) {  // too small for doubles: a bound only
    return row.lo > 0 || row.hi < 0 ? number((row.lo + row.hi) / 2) : "<" + number(std::max(-row.lo, row.hi));
  };
  const auto yes = [](bool x) { return x ? "true" : "false"; };
  out << "{\"stages\":" << report.stages << ",\"exact\":" << yes(report.exact) << ",\"row_sums\":" << (report.has_c ? yes(report.row_sums) : "null") << ",\"rows\":{";
  for (std::size_t k = 0; k < report.rows.size(); ++k) {
    const Row& row = report.rows[k];
    out << (k ? "," : "") << quoted(row.name) << ":{\"order\":" << row.order << ",\"capped\":" << yes(row.capped) << ",\"failing\":" << row.failing << ",\"tree\":" << (row.capped ? "null" : '"' + row.tree + '"')
        << ",\"residual\":" << (row.capped ? "null" : '"' + residual(row) + '"') << ",\"within\":\"" << (row.within > 0 ? number(row.within) : "0") << "\",\"near\":" << row.near << '}';
  }
  out << "}}";
  return out.str();
}
}  // namespace glmref

#ifdef GLMREF_CHECK_MAIN
#include <fstream>
#include <iostream>
int main(int count, char** words) {
  int code = 0;
  for (int k = 1; k < count; ++k) {
    std::ifstream file(words[k]);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    try {
      std::cout << glmref::json(glmref::check(text)) << "\n";
    } catch (const std::runtime_error& error) {
      std::cout << "{\"error\":" << glmref::quoted(error.what()) << "}\n";
      code = 2;
    }
  }
  return code;
}
#endif
#endif
