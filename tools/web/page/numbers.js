// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers from paper. They go the way of a table: its reader takes them apart. (element: report's text.js)
import {Trouble, sayTrouble} from './trouble.js';

const $ = id => document.getElementById(id);

const kKinds = {
  heights: {units: ['m', 'cm', 'mm', 'in', 'ft'], example: '1, .81, .66, .53', says: 'Of the ball’s lowest point over the floor: the release, then each bounce.'},
  intervals: {units: ['s', 'ms'], example: '0.62, 0.56, 0.50, 0.45', says: 'From each impact to the next.'},
  times: {units: ['s', 'ms'], example: '0.00, 0.62, 1.18, 1.68', says: 'Of the impacts, at least three, by one clock.'},
};
const options = values => values.map(value => element('option', {value}, value || 'not given'));

/// @param take  is given a list of one file, and the options that tell how it is read
export function acceptNumbers(take) {
  const show = () => {
    const {units, example, says} = kKinds[$('numbers-as').value];
    $('numbers-unit').replaceChildren(...options(["", ...units]));  // what none is given for is asked, unless the numbers prove it
    $('numbers').placeholder = example;
    $('numbers-say').textContent = `${says} Separate numbers by commas, semicolons, blanks or lines; of several drops write one number a line and leave a line empty between drops.`;
  };
  $('numbers-as').append(...options(Object.keys(kKinds)));
  $('numbers-as').addEventListener('change', show);
  show();
  $('numbers-run').addEventListener('click', () => {
    const text = $('numbers').value;
    if (text.trim()) return take([new File([text], 'numbers')], {as: $('numbers-as').value, unit: $('numbers-unit').value || null});
    sayTrouble(new Trouble('No number is typed yet.'));
    $('numbers').focus();
  });
}
