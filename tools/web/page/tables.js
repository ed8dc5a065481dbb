// SPDX-License-Identifier: GPL-3.0-or-later
// Onsets as the module gives and takes them, an object of columns, and as marks, a list.

const kNumbers = ['drop', 'impact', 't_s', 'sigma_t_s', 'amplitude', 'snr_db', 'probability'];
const known = x => x === undefined || Number.isNaN(x) ? '' : x;

/// Columns as ordinary lists, and their length `n`.
export function lists(columns) {
  const all = Object.fromEntries(Object.entries(columns).map(([name, column]) => [name, Array.from(column)]));
  return {n: Object.values(all)[0].length, ...all};
}

/// Columns as a list of marks; what is not known is ''.
export function marksFrom(columns) {
  return Array.from(columns.t_s, (_, k) => ({...Object.fromEntries(kNumbers.map(name => [name, known(columns[name]?.[k])])), flags: columns.flags?.[k] ?? ''}));
}

/// Marks as columns.
export function columnsFrom(marks) {
  const numbers = kNumbers.map(name => [name, Float64Array.from(marks, m => m[name] === '' ? NaN : m[name])]);
  return {...Object.fromEntries(numbers), flags: marks.map(m => m.flags)};
}
