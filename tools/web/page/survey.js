// SPDX-License-Identifier: GPL-3.0-or-later
// Several files: a table with a row each, worked out one after the other by a worker of its own, so that what is on the
// page stays as it is. (element, headCell, scrollPlace, measured, speed, csvText: report's text.js)
import {save} from './downloads.js';
import {Engine} from './engine.js';
import {readFile} from './files.js';
import {Trouble, plain} from './trouble.js';

const kAsks = 'asks how its numbers are to be read: press its name';

/// What there is to say of a file: {at, n_impacts, remark}.
async function rowOfFile(engine, file, options) {
  const {bytes, channels, refused, note, ...rest} = await readFile(file);
  await engine.ready;
  const opened = engine.run({task: 'open', name: file.name, bytes, channels, ...rest}, bytes ? [bytes.buffer] : channels.map(c => c.buffer));
  const {times, peak} = await (refused ? opened.catch(() => { throw new Trouble(refused); }) : opened);
  if (peak === 0) throw new Trouble('silent: all of its samples are zero');
  const result = await engine.run({task: times ? 'times' : 'analyze', options});
  if (result.question) return {remark: kAsks};
  const {answer, warnings, message} = result, at = answer?.at;
  return {at, n_impacts: answer?.seen.n_impacts, remark: at ? answer.doubt || warnings[0] || '' : message ?? answer?.sentences[0] ?? 'no bouncing ball was found'};
}

export class Survey {
  /// @param host  element; @param options  gives what is told of ball and height; @param choose  is given a file that is
  ///              to be shown
  constructor(host, options, choose) {
    Object.assign(this, {host, options, choose, files: []});
  }

  /// @param files  none: the table goes
  begin(files) {
    this.engine?.stop();
    this.engine = null;
    this.files = files;
    this.host.hidden = !files.length;
    this.host.replaceChildren();
    if (!files.length) return;
    this.chosen = files[0];
    this.body = element('tbody');
    const place = scrollPlace('Recordings'), csv = element('button', {type: 'button'}, 'This table (CSV)');
    place.append(element('table', {}, element('thead', {}, element('tr', {}, ['recording', 'ε ± standard error', 'at', 'bounces', 'to know'].map(headCell))), this.body));
    csv.addEventListener('click', () => save('recordings.csv', [this.csv()], 'text/csv'));
    this.host.append(place, element('div', {class: 'row'}, csv));
    this.again();
  }

  /// With what is told now.
  async again() {
    if (!this.files.length) return;
    this.engine?.stop();
    const engine = this.engine = new Engine();
    this.rows = this.files.map(() => null);
    this.show();
    for (const [k, file] of this.files.entries()) {
      let row;
      try {
        row = await rowOfFile(engine, file, this.options());
      } catch (error) {
        row = {remark: error?.message ?? String(error)};
      }
      if (engine !== this.engine) return;
      this.rows[k] = {...row, remark: plain(row.remark).replace(`${file.name}: `, '').replace(`${file.name} `, '')};
      this.show();
    }
    engine.stop();
  }

  show() {
    const focused = [...this.body.querySelectorAll('button')].indexOf(document.activeElement);
    this.body.replaceChildren(...this.files.map((file, k) => {
      const {at, n_impacts, remark} = this.rows[k] ?? {remark: '…'}, button = element('button', {type: 'button', 'aria-pressed': String(file === this.chosen)}, file.name);
      button.addEventListener('click', () => {
        this.chosen = file;
        this.show();
        this.choose(file);
      });
      const cells = [button, at ? measured(at.eps, at.se) : '–', at ? speed(at.v_mps) : '–', number(n_impacts), remark ? element('span', {class: 'words'}, remark) : ''];
      return element('tr', {}, cells.map((cell, column) => element(column ? 'td' : 'th', column ? {} : {scope: 'row'}, cell)));
    }));
    if (focused >= 0) this.body.querySelectorAll('button')[focused].focus();
  }

  csv() {
    return csvText([['recording', 'eps', 'standard_error', 'low95', 'high95', 'v_mps', 'n_impacts', 'to_know'],
                    ...this.files.map((file, k) => { const {at, n_impacts, remark} = this.rows[k] ?? {remark: 'not computed yet'}; return [file.name, at?.eps, at?.se, at?.ci95?.[0], at?.ci95?.[1], at?.v_mps, n_impacts, remark]; })]);
  }
}
