// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers from paper. They go the way of a table: its reader takes them apart. (element: report's text.js)
import {Trouble, sayTrouble} from './trouble.js';

const $ = id => document.getElementById(id);

const kKinds = {
  heights: {label: 'heights, the release first', units: ['m', 'cm', 'mm', 'in', 'ft'], example: '1, .81, .66, .53', says: 'Heights of the ball’s lowest point over the floor.'},
  intervals: {label: 'intervals from bounce to bounce', units: ['s', 'ms'], example: '0.62, 0.56, 0.50, 0.45', says: 'From one impact to the next, as a stopwatch has them.'},
  times: {label: 'times of the bounces', units: ['s', 'ms'], example: '0.00, 0.62, 1.18, 1.68', says: 'By a clock that goes on, three or more.'},
};
const option = (value, label = value) => element('option', {value}, label);

/// @param take  is given a list of one file, and the options that tell how it is read
export function acceptNumbers(take) {
  const show = () => {
    const {units, example, says} = kKinds[$('numbers-as').value];
    $('numbers-unit').replaceChildren(...units.map(unit => option(unit)));
    $('numbers').placeholder = example;
    $('numbers-say').textContent = `${says} Between numbers a comma, a semicolon, a blank or a new line; before another drop, one number a line and a blank line between.`;
  };
  $('numbers-as').append(...Object.entries(kKinds).map(([as, {label}]) => option(as, label)));
  $('numbers-as').addEventListener('change', show);
  show();
  $('numbers-run').addEventListener('click', () => {
    const text = $('numbers').value;
    if (text.trim()) return take([new File([text], 'numbers')], {as: $('numbers-as').value, unit: $('numbers-unit').value});
    sayTrouble(new Trouble('No number is typed yet.'));
    $('numbers').focus();
  });
}
