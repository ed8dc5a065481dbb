// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of docs/formats.md as the page needs them. Texts in the first column may be quoted (RFC 4180).

function cells(line) {
  if (!line.includes('"')) return line.split(',');
  const out = [];
  for (const match of line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)) out.push(match[1] !== undefined ? match[1].replaceAll('""', '"') : match[2]);
  return out;
}

function rows(csv) {
  const lines = csv.split('\n').map(line => line.replace(/\r$/, '')).filter(Boolean);
  return {head: cells(lines[0] ?? ''), rows: lines.slice(1).map(cells)};
}
const toNumber = text => text === undefined || text === '' ? NaN : Number(text);

/// Columns by name, numbers and texts; those that the table does not have are left out.
export function columns(csv, numbers, texts) {
  const table = rows(csv), out = {n: table.rows.length};
  for (const name of [...numbers, ...texts]) {
    const at = table.head.indexOf(name);
    if (at >= 0) out[name] = table.rows.map(row => numbers.includes(name) ? toNumber(row[at]) : row[at] ?? '');
  }
  return out;
}

const kColumns = ['drop', 'impact', 't_s', 'sigma_t_s', 'amplitude', 'snr_db', 'flags', 'probability'];

/// onsets.csv as a list of marks; numbers keep their digits as text, so that what nobody touched is written as it was.
export function marksFrom(csv) {
  const table = rows(csv), at = Object.fromEntries(kColumns.map(name => [name, table.head.indexOf(name)]));
  return table.rows.map(row => ({
    drop: Number(row[at.drop]), impact: Number(row[at.impact]), t_s: Number(row[at.t_s]), t_text: row[at.t_s], sigma_t_s: row[at.sigma_t_s] ?? '', amplitude: row[at.amplitude] ?? '',
    snr_db: row[at.snr_db] ?? '', flags: row[at.flags] ?? '', probability: at.probability < 0 ? '' : row[at.probability] ?? ''}));
}

/// Marks as onsets.csv.
export function onsetsCsv(recording, marks) {
  const name = /[",\n]/.test(recording) ? `"${recording.replaceAll('"', '""')}"` : recording;
  return ['recording,' + kColumns.join(','),
          ...marks.map(m => [name, m.drop, m.impact, m.t_text ?? m.t_s, m.sigma_t_s, m.amplitude, m.snr_db, m.flags, m.probability].join(','))].join('\n') + '\n';
}
