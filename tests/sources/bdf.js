// backward differentiation formulas, the newest value first
export const bdf = {
  2: { alpha: [1, -4 / 3, 1 / 3], beta: 2 / 3 },
  3: { alpha: [1, -18 / 11, 9 / 11, -2 / 11], beta: 6 / 11 },
};
