// SPDX-License-Identifier: GPL-3.0-or-later
// Ball, floor, height and gravity: what the computation may know.
import {Trouble} from './trouble.js';

const $ = id => document.getElementById(id);
const name = text => text.replaceAll('-', ' ');
const option = entry => element('option', {value: entry.name}, `${name(entry.name)}${entry.what ? ` (${entry.what})` : ''}`);

const kFields = ['ball', 'diameter', 'plate', 'height', 'gravity'];

export class Settings {
  /// @param changed  is called when a field has another value; @param typing  while one is being written
  constructor(changed, typing) {
    for (const id of kFields) {
      $(id).addEventListener('change', () => { this.show(); changed(); });
      $(id).addEventListener('input', typing);
    }
    this.balls = [];
  }

  /// The catalogue, and limits of what may be told, once the worker knows it.
  fill({balls, plates, limits}) {
    this.balls = balls;
    Object.assign($('gravity'), {min: limits.gravity.least, max: limits.gravity.greatest});
    $('gravity').value ||= limits.gravity.value;
    Object.assign($('height'), {min: 100 * limits.drop_height.least, max: 100 * limits.drop_height.greatest});
    if ($('ball').length > 1) return;
    $('ball').append(...balls.map(option));
    $('plate').append(...plates.map(option));
    $('simulate-ball').append(...balls.filter(ball => ball.hertzian).map(ball => element('option', {value: ball.name}, name(ball.name))));
    $('simulate-ball').value = 'steel';
  }

  /// A ball of the catalogue has its size, or is a material, whose size has to be given.
  isMaterial(ball) { return Boolean(ball) && !this.balls.find(b => b.name === ball)?.radius_m; }

  /// Heights begin with that of the release, and speeds need none.
  asksHeight(asks) {
    $('height-field').hidden = $('height-says').hidden = !asks;
    this.show();
  }
  get height() { return $('height-field').hidden ? '' : $('height').value; }

  /// What stands in the fields, a number or not.
  given() { return kFields.map(id => $(id).validity.badInput ? 'no number' : $(id).value).join(' '); }

  show() {
    $('diameter-field').hidden = !this.isMaterial($('ball').value);
    const parts = [this.ballText(), this.height ? `${this.height} cm` : ''].filter(Boolean);
    $('settings-now').textContent = parts.length ? `(${parts.join(', ')})` : '(not given)';
  }
  ballText() {
    const ball = $('ball').value;
    return this.isMaterial(ball) ? `${name(ball)}, ${$('diameter').value} mm` : name(ball);
  }

  options() {
    const gravity = this.number('gravity', 'Gravity'), options = {gravity};
    const ball = $('ball').value;
    if (ball) options.ball = this.isMaterial(ball) ? `${ball}:${this.number('diameter', 'The diameter')}mm` : ball;
    if ($('plate').value) options.plate = $('plate').value;
    if (this.height) options.drop_height_m = this.number('height', 'The drop height') / 100;
    return options;
  }
  number(id, what) {
    const input = $(id);
    if (!(input.value && input.checkValidity())) throw new Trouble(`${what} has to be a ${input.step === '1' ? 'whole ' : ''}number from ${input.min} to ${input.max}.`);
    return input.valueAsNumber;
  }
}
