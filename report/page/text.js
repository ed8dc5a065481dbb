// SPDX-License-Identifier: GPL-3.0-or-later
// Data, numbers and elements of the page. Numbers are shown, none are computed.
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('report');
const {summary, fit, wave, samples} = data;
/// Constants of the law as they are stated: by the fit with memory where that holds, else with impacts taken as
/// independent.
const constants = (fit && fit.constants) || {}, withMemory = constants.with_memory === true;
/// What a user should know, the most severe first: of the summary, which has those of the fit too, or of the fit.
const notesOf = severity => ((summary && summary.notes) || (fit && fit.notes) || []).filter(note => (note.severity === 'detail') === (severity === 'detail')).map(note => note.text);
/// Why a fit is as it is, by the kinds of its notes.
const whyOf = kinds => ((fit && fit.notes) || []).filter(note => kinds.test(note.kind)).map(note => note.text).join('; ');
const nounOfRows = fit && fit.recordings_are === 'plates' ? 'plate' : 'recording';  // of fit.recordings
const few = Boolean(samples);  // few enough to be shown one by one: more are not in the data

function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) node.setAttribute(key, value);
  for (const child of children.flat(Infinity)) node.append(child);
  return node;
}
function add(tag, attributes, ...children) {
  const node = element(tag, attributes, ...children);
  page.append(node);
  return node;
}
const known = x => typeof x === 'number' && Number.isFinite(x);

/// A number with as many digits as its standard error warrants: 0.98169 ± 0.00004.
function measured(value, se) {
  if (!known(value)) return '–';
  if (!known(se) || se <= 0) return number(value);
  const decimals = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(se))));
  return value.toFixed(decimals) + ' ± ' + se.toFixed(decimals);
}
const estimated = e => e ? measured(e.value, e.se) + (e.identified === false ? ' (not identifiable)' : '') : '–';
function number(value, digits = 5) {
  if (!known(value)) return '–';
  if (Number.isInteger(value)) return value.toLocaleString('en-US').replace(/,/g, '\u202f');
  const size = Math.abs(value);
  return size >= 1e5 || (size < 1e-4 && size > 0) ? value.toExponential(Math.max(0, digits - 2)) : String(+value.toPrecision(digits));
}
/// Three digits, of large and small numbers as powers of ten.
function significant(value) {
  if (!known(value)) return '–';
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-2 && size < 1e5)) return String(+value.toPrecision(3));
  const [mantissa, exponent] = value.toExponential(2).split('e');
  return `${mantissa}·10${[...String(+exponent)].map(c => c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[+c]).join('')}`;
}
function interval(range) {
  if (!Array.isArray(range) || !known(range[0]) || !known(range[1])) return '–';
  const decimals = Math.min(12, Math.max(0, 2 - Math.floor(Math.log10(Math.max(range[1] - range[0], 1e-12)))));
  return `${range[0].toFixed(decimals)} … ${range[1].toFixed(decimals)}`;
}
/// Rows of cells as CSV; what is not known is empty, and a name that begins as a formula has an apostrophe, so that a
/// spreadsheet does not compute it.
function csvText(rows) {
  const plain = value => value === null || value === undefined ? '' : typeof value === 'string' && /^[=+@-]/.test(value) ? `'${value}` : String(value);
  const cell = value => /[",\n\r]/.test(plain(value)) ? `"${plain(value).replaceAll('"', '""')}"` : plain(value);
  return rows.map(row => row.map(cell).join(',') + '\n').join('');
}

/// Points of ε(v), the root mean square over bounces; none where recordings or drops differ.
const answerCurve = fit => !fit || fit.is_one_ball === false ? [] : fit.curve?.points ?? [];
const speed = v => `${number(v, 3)} m/s`;

/// On a screen report.css shows a table that is wider than its place row by row: each cell names its column and is as
/// wide as the column was, which is the longest value or word of the head. The roles are those that elements of a table
/// lose where they are not displayed as one.
const roles = {table: 'table', 'thead, tbody': 'rowgroup', tr: 'row', 'thead th': 'columnheader', 'tbody th': 'rowheader', td: 'cell'};
function nameCells(place) {
  const heads = [...place.querySelectorAll('thead tr > *')].map(cell => [cell.textContent, `${cell.offsetWidth}px`]);
  for (const row of place.querySelectorAll('tbody tr'))
    [...row.cells].forEach((cell, k) => {
      const [head, width] = heads[k];
      cell.dataset.head = head;
      cell.style.setProperty('--width', cell.matches('.text, .value') || cell.querySelector('.words') ? '100%' : width);
    });
  for (const [selector, role] of Object.entries(roles)) for (const node of place.querySelectorAll(selector)) node.setAttribute('role', role);
}
const widths = new WeakMap();
const placeWidths = new ResizeObserver(changes => requestAnimationFrame(() => {
  for (const {target: place, contentRect: {width}} of changes) {
    if (widths.get(place) === width) continue;
    widths.set(place, width);
    place.classList.remove('by-row');
    if (place.scrollWidth <= place.clientWidth) continue;
    nameCells(place);
    place.classList.add('by-row');
  }
}));

/// A place that scrolls sideways, by keyboard too, and says to a screen reader what it holds.
let unnamedRegions = 0;
function scrollPlace(label) {
  const place = element('div', {class: 'scroll', role: 'region', tabindex: '0', 'aria-label': label || `table ${++unnamedRegions}`});
  placeWidths.observe(place);
  return place;
}
/// A head without words is no head.
const headCell = text => text === '' ? element('td', {}) : element('th', {scope: 'col'}, text);
/// The first cell of a row is its head.
const rowOf = cells => element('tr', {}, cells.map((cell, k) => k === 0 && cell !== '' ? element('th', {scope: 'row'}, cell) : element('td', {}, cell)));

let lastTitle = '';
function table(title, head, rows, caption, parent = page) {
  if (!rows.length) return;
  const says = head.map((_, k) => k === 0 || rows.some(row => row[k] !== '–')), only = cells => cells.filter((_, k) => says[k]);
  if (title) parent.append(element('h2', {}, title));
  if (caption) parent.append(element('p', {class: 'caption'}, caption));
  if (title) lastTitle = title;
  const place = scrollPlace(title || `${lastTitle}, table ${++unnamedRegions}`);
  place.append(element('table', {}, element('thead', {}, element('tr', {}, only(head).map(headCell))), element('tbody', {}, rows.map(cells => rowOf(only(cells))))));
  parent.append(place);
}
/// What few look for: folded, and left out of what is printed.
function folded(title, attributes) {
  const fold = element('details', {class: 'folded'}, element('summary', {}, element('h2', attributes, title)));
  page.append(fold);
  lastTitle = title;
  return fold;
}
function foldedTable(title, head, rows, caption) {
  if (rows.length) table('', head, rows, caption, folded(title));
}
