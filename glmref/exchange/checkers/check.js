// Order of a Runge-Kutta tableau over rooted trees, through order 8. One file, no dependencies.
//
//   node check.js rk4.txt gauss-2.txt      one line of JSON a file
//   const report = glmrefCheck(text);      in a browser or after require("./check.js").check
//
// A text has the rows of A, then `b: ...`, and where there are any `c: ...` and `b_hat NAME: ...`.
// Entries are apart by blanks or commas, and are made of + - * / ( ) sqrt(x) root(x,n). A number with
// a point is exact, unless `digits: N` stands above: then it is known to one unit of the N-th digit.
// Rational tableaux are decided exactly, in integers: every entry times the common denominator L,
// and gamma(t) L^n Phi(t) against L^n. Others are enclosed in intervals of 320 bits: what fails is
// proved to fail, and what does not is right to the digits stated. CC0 1.0.
"use strict";

const glmrefCheck = (() => {
  const BITS = 320n, ONE = 1n << BITS, MOST = 8, MOST_STAGES = 60, NEAR = 1e-9;

  // --- numbers: {n, d} is a fraction, {lo, hi} an interval in units of 2^-BITS
  const abs = (x) => (x < 0n ? -x : x);
  const min = (...x) => x.reduce((a, b) => (b < a ? b : a));
  const max = (...x) => x.reduce((a, b) => (b > a ? b : a));
  const gcd = (a, b) => { while (b) [a, b] = [b, a % b]; return abs(a); };
  const floor = (a, b) => {
    if (b < 0n) [a, b] = [-a, -b];
    return a / b - (a % b < 0n ? 1n : 0n);
  };
  const ceil = (a, b) => -floor(-a, b);
  const fraction = (n, d = 1n) => {
    const g = gcd(n, d) * (d < 0n ? -1n : 1n);
    return { n: n / g, d: d / g };
  };
  const exact = (x) => x.d !== undefined;
  const interval = (x) => (exact(x) ? { lo: floor(x.n << BITS, x.d), hi: ceil(x.n << BITS, x.d) } : x);
  const both = (a, b, ofFractions, ofIntervals) =>
    exact(a) && exact(b) ? ofFractions() : ofIntervals(interval(a), interval(b));
  const add = (a, b) => both(a, b, () => fraction(a.n * b.d + b.n * a.d, a.d * b.d),
    (x, y) => ({ lo: x.lo + y.lo, hi: x.hi + y.hi }));
  const minus = (a) => (exact(a) ? { n: -a.n, d: a.d } : { lo: -a.hi, hi: -a.lo });
  const scaled = (x, { n, d }) => { // an interval times a fraction, which may be huge or tiny
    const ends = [x.lo * n, x.hi * n];
    return { lo: floor(min(...ends), d), hi: ceil(max(...ends), d) };
  };
  const mul = (a, b) => (exact(a) !== exact(b) ? (exact(a) ? scaled(b, a) : scaled(a, b)) : both(a, b, () => fraction(a.n * b.n, a.d * b.d), (x, y) => {
    const p = [x.lo * y.lo, x.lo * y.hi, x.hi * y.lo, x.hi * y.hi];
    return { lo: min(...p) >> BITS, hi: -(-max(...p) >> BITS) };
  }));
  const inverse = (b) => {
    if (exact(b) ? b.n === 0n : b.lo <= 0n && b.hi >= 0n) throw new Error("a division by zero");
    return exact(b) ? fraction(b.d, b.n) : { lo: floor(ONE * ONE, b.hi), hi: ceil(ONE * ONE, b.lo) };
  };
  const wholeRoot = (x, k) => { // the largest r with r^k <= x
    if (x < 2n) return x;
    let r = 1n << (BigInt(x.toString(2).length) / k + 1n);
    for (;;) {
      const next = ((k - 1n) * r + x / r ** (k - 1n)) / k;
      if (next >= r) return r;
      r = next;
    }
  };
  const root = (x, k) => {
    if (k < 1n || k > 60n) throw new Error("a root of a degree that is not 1 to 60");
    if (exact(x) ? x.n < 0n : x.lo < 0n) throw new Error("a root of a negative number");
    if (exact(x)) {
      const n = wholeRoot(x.n, k), d = wholeRoot(x.d, k);
      if (n ** k === x.n && d ** k === x.d) return { n, d };
    }
    const { lo, hi } = interval(x), shift = BITS * (k - 1n);
    return { lo: wholeRoot(lo << shift, k), hi: wholeRoot(hi << shift, k) + 1n };
  };

  // --- entries
  const decimal = (text, digits) => {
    const [whole, places = ""] = text.split(".");
    const value = fraction(BigInt((whole + places) || "0"), 10n ** BigInt(places.length));
    if (digits === null || !text.includes(".")) return value;
    if (places.length < digits) throw new Error(`'${text}' has fewer than ${digits} digits`);
    if (value.n === 0n) return value;
    const unit = interval(fraction(1n, 10n ** BigInt(digits))), at = interval(value);
    return { lo: at.lo - unit.hi, hi: at.hi + unit.hi };
  };
  const parse = (text, digits) => {
    const tokens = text.match(/\d+\.\d*|\.\d+|\d+|[a-z]+|\S/g) || [];
    let at = 0;
    const want = (x) => {
      if (tokens[at] !== x) throw new Error(`'${tokens[at] ?? "the end"}' in place of '${x}'`);
      at += 1;
    };
    const atom = () => {
      const token = tokens[at] ?? "the end";
      at += 1;
      if (/^[\d.]*\d[\d.]*$/.test(token)) return decimal(token, digits);
      if (token !== "(" && token !== "sqrt" && token !== "root") throw new Error(`'${token}' is not read`);
      if (token !== "(") want("(");
      const inside = sum();
      let degree = 2n;
      if (token === "root") {
        want(",");
        if (!/^\d{1,2}$/.test(tokens[at] ?? "")) throw new Error("a root without a whole degree");
        degree = BigInt(tokens[at]);
        at += 1;
      }
      want(")");
      return token === "(" ? inside : root(inside, degree);
    };
    const factor = () => {
      if (tokens[at] !== "-" && tokens[at] !== "+") return atom();
      at += 1;
      return tokens[at - 1] === "-" ? minus(factor()) : factor();
    };
    const product = () => {
      let found = factor();
      while (tokens[at] === "*" || tokens[at] === "/") {
        at += 1;
        found = tokens[at - 1] === "*" ? mul(found, factor()) : mul(found, inverse(factor()));
      }
      return found;
    };
    const sum = () => {
      let found = product();
      while (tokens[at] === "+" || tokens[at] === "-") {
        at += 1;
        found = add(found, tokens[at - 1] === "+" ? product() : minus(product()));
      }
      return found;
    };
    const found = sum();
    if (at < tokens.length) throw new Error(`'${tokens[at]}' behind the end of a number`);
    return found;
  };

  // --- tableaux
  const split = (line) => { // at blanks, commas and semicolons outside of brackets
    const found = [""];
    let depth = 0;
    for (const letter of line) {
      depth += letter === "(" ? 1 : letter === ")" ? -1 : 0;
      if (depth <= 0 && /[\s,;]/.test(letter)) found.push("");
      else found[found.length - 1] += letter;
    }
    return found.filter((x) => x);
  };
  const read = (text) => {
    const tableau = { A: [], rows: new Map(), c: null };
    let digits = null;
    for (const line of text.split("\n").map((x) => x.replace(/#.*/, "").trim()).filter((x) => x)) {
      const colon = line.indexOf(":");
      const name = colon < 0 ? "" : line.slice(0, colon).trim();
      const where = name || `row ${tableau.A.length + 1} of A`;
      if (name === "digits") {
        digits = Number(line.slice(colon + 1));
        if (!(Number.isInteger(digits) && digits >= 1 && digits <= 150)) throw new Error("`digits` must be a whole number from 1 to 150");
        continue;
      }
      const row = split(line.slice(colon + 1)).map((entry, k) => {
        if (entry.length > 500) throw new Error(`${where}: entry ${k + 1} has more than 500 characters`);
        try {
          return parse(entry, digits);
        } catch (error) {
          throw new Error(`${where}, entry ${k + 1}: ${error.message}`);
        }
      });
      if (name === "") tableau.A.push(row);
      else if (name === "c") tableau.c = row;
      else if (name === "b" || name.startsWith("b_hat")) tableau.rows.set(name.replace(/^b_hat\s*/, "") || "b_hat", row);
      else throw new Error(`'${name}' is none of b, c, b_hat NAME, digits`);
    }
    const s = tableau.A.length;
    if (s === 0 || s > MOST_STAGES) throw new Error(`A must have 1 to ${MOST_STAGES} rows, got ${s}`);
    if (!tableau.rows.has("b")) throw new Error("the row `b: ...` is missing");
    const all = [...tableau.A.map((row, k) => [`row ${k + 1} of A`, row]), ...tableau.rows];
    for (const [name, row] of tableau.c ? [...all, ["c", tableau.c]] : all) {
      if (row.length !== s) throw new Error(`${name} has ${row.length} entries and must have ${s}`);
    }
    return tableau;
  };

  // --- trees: {kids, n, gamma, text}; the leaf `t` is the time, where c is not A 1
  const trees = (timed) => {
    const pool = timed ? [{ kids: null, n: 1, gamma: 1n, text: "t" }] : [];
    const levels = [];
    for (let n = 1; n <= MOST; n += 1) {
      const level = [];
      const grow = (left, from, kids) => {
        if (left === 0) {
          const gamma = kids.reduce((x, kid) => x * kid.gamma, BigInt(n));
          level.push({ kids, n, gamma, text: kids.length ? `[${kids.map((x) => x.text).join("")}]` : "o" });
        }
        for (let k = from; k < pool.length && pool[k].n <= left; k += 1) grow(left - pool[k].n, k, [...kids, pool[k]]);
      };
      grow(n - 1, 0, []);
      levels.push(level);
      pool.push(...level);
    }
    return levels;
  };

  // --- decimals of three digits
  const scientific = (n, d) => {
    if (n === 0n) return "0";
    const sign = n < 0n ? "-" : "";
    n = abs(n);
    let e = n.toString().length - d.toString().length;
    if (e >= 0 ? n < d * 10n ** BigInt(e) : n * 10n ** BigInt(-e) < d) e -= 1;
    const shift = 2 - e;
    const [up, down] = shift >= 0 ? [n * 10n ** BigInt(shift), d] : [n, d * 10n ** BigInt(-shift)];
    const m = ((2n * up + down) / (2n * down)).toString();
    return `${sign}${m[0]}.${m.slice(1, 3)}e${m.length > 3 ? e + 1 : e}`;
  };

  const check = (text) => {
    const { A, rows, c } = read(text);
    const s = A.length;
    const numbers = [...A.flat(), ...[...rows.values()].flat(), ...(c || [])];
    const rational = numbers.every(exact);
    const sums = A.map((row) => row.reduce(add));
    const off = c && c.map((x, i) => add(x, minus(sums[i])));
    const apart = Boolean(off && off.some((x) => (exact(x) ? x.n !== 0n : x.lo > 0n || x.hi < 0n)));
    const L = rational ? numbers.reduce((x, y) => (x / gcd(x, y.d)) * y.d, 1n) : ONE;
    // numbers of the computation: integers times a power of L, or intervals
    const ring = rational
      ? { of: (x) => x.n * (L / x.d), add: (x, y) => x + y, mul: (x, y) => x * y, zero: 0n, one: 1n, nil: (x) => x === 0n }
      : { of: interval, add, mul, zero: { lo: 0n, hi: 0n }, one: { lo: ONE, hi: ONE }, nil: (x) => x.lo === 0n && x.hi === 0n };
    const of = (row) => row.map(ring.of);
    const dot = (x, y) => x.reduce((total, a, k) => (ring.nil(a) ? total : ring.add(total, ring.mul(a, y[k]))), ring.zero);
    const [matrix, times] = [A.map(of), apart ? of(c) : null];
    const found = {};
    for (const name of rows.keys()) found[name] = { order: 0, capped: true, failing: 0, tree: null, residual: null, within: "0", near: 0 };
    const weights = new Map();
    const weight = (tree) => { // A times the product of the weights of the branches, (s,)
      if (tree.kids === null) return times;
      if (!weights.has(tree)) weights.set(tree, matrix.map((row) => dot(row, tree.product)));
      return weights.get(tree);
    };
    const worst = {}, failed = {}, close = {};
    for (const level of trees(apart)) {
      for (const tree of level) {
        tree.product = Array.from({ length: s }, (_, i) => tree.kids.reduce((x, kid) => ring.mul(x, weight(kid)[i]), ring.one));
        for (const [name, row] of rows) {
          const S = dot(of(row), tree.product), { gamma, n } = tree, power = L ** BigInt(n);
          // residual Phi(t) - 1/gamma, as a fraction or as the interval [lo, hi] in units of 2^-BITS
          const [lo, hi, unit] = rational
            ? [gamma * S - power, gamma * S - power, gamma * power]
            : [S.lo - ceil(ONE, gamma), S.hi - floor(ONE, gamma), ONE];
          const size = max(abs(lo), abs(hi)), fails = lo > 0n || hi < 0n;
          if (fails && !failed[name]) {
            failed[name] = n;
            Object.assign(found[name], { tree: tree.text, residual: scientific(lo + hi, 2n * unit) });
          }
          if (fails && failed[name] === n) found[name].failing += 1;
          if (!failed[name] && (!worst[name] || size * worst[name][1] > worst[name][0] * unit)) worst[name] = [size, unit];
          if (!close[name] && Number(scientific(size, unit)) > NEAR) close[name] = n;
        }
      }
      for (const name of rows.keys()) {
        if (!failed[name]) found[name].order = level[0].n;
        if (!close[name]) found[name].near = level[0].n;
      }
    }
    for (const name of rows.keys()) {
      found[name].capped = !failed[name];
      if (worst[name] && !rational) found[name].within = scientific(...worst[name]);
    }
    return { stages: s, exact: rational, row_sums: c ? !apart : null, rows: found };
  };
  return check;
})();

if (typeof module !== "undefined") {
  module.exports = { check: glmrefCheck };
  if (require.main === module) {
    for (const path of process.argv.slice(2)) {
      let report;
      try {
        report = glmrefCheck(require("fs").readFileSync(path, "utf8"));
      } catch (error) {
        report = { error: error.message };
        process.exitCode = 2;
      }
      console.log(JSON.stringify(report));
    }
  }
}
