// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers from paper. They go the way of a table: its reader takes them apart. (element: report's text.js)
import {Trouble} from './trouble.js';

const $ = id => document.getElementById(id);

const kSequence = 'Separate numbers by commas, semicolons, blanks or lines; of several drops write one number a line and leave a line empty between drops.';
/// Of speeds the columns are told, of the others what they are.
const kKinds = {
  heights: {units: ['m', 'cm', 'mm', 'in', 'ft'], example: '1, .81, .66, .53', says: `Of the ball’s lowest point over the floor: the release, then each bounce. ${kSequence}`},
  intervals: {units: ['s', 'ms'], example: '0.62, 0.56, 0.50, 0.45', says: `From each impact to the next. ${kSequence}`},
  times: {units: ['s', 'ms'], example: '0.00, 0.62, 1.18, 1.68', says: `Of the impacts, at least three, by one clock. ${kSequence}`},
  speeds: {columns: 'v_in=1,v_out=2', example: '4.43 3.98\n3.98 3.59\n3.59 3.23', says: 'In m/s, just before and just after a bounce: two numbers a line, with a blank or a semicolon between them.'},
};
const options = values => values.map(value => element('option', {value}, value || 'not given'));
const isPair = line => line.trim().split(/[\s;]+/).length === 2;

/// What the module is told of the numbers.
function reading(text) {
  const kind = $('numbers-as').value, {columns} = kKinds[kind];
  if (!text.trim()) throw new Trouble('No number is typed yet.');
  if (!columns) return {as: kind, unit: $('numbers-unit').value || null};
  if (!text.trim().split('\n').every(isPair)) throw new Trouble('Speeds are two numbers a line, just before and just after a bounce, with a blank or a semicolon between them.');
  return {columns};
}

/// @param take  is given a list of one file, and the options that tell how it is read; @param changed  is called when
///              other numbers are typed; @param refuse  is given why what is typed is none
export function acceptNumbers(take, changed, refuse) {
  const show = () => {
    const {units, example, says} = kKinds[$('numbers-as').value];
    $('numbers-unit').replaceChildren(...(units ? options(['', ...units]) : options(['m/s'])));  // what is not given is asked, unless the numbers prove it
    $('numbers').placeholder = example;
    $('numbers-say').textContent = says;
  };
  $('numbers-as').append(...options(Object.keys(kKinds)));
  $('numbers-as').addEventListener('change', show);
  show();
  $('typed').addEventListener('input', changed);
  $('numbers-run').addEventListener('click', () => {
    const text = $('numbers').value;
    try {
      take([new File([text], 'numbers')], reading(text));
    } catch (error) {
      refuse(error);
      $('numbers').focus();
    }
  });
}
