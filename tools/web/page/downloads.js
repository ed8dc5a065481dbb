// SPDX-License-Identifier: GPL-3.0-or-later
// The files that the command line leaves, saved by the browser; the worker keeps them until they are asked for. And the
// answer as text and picture, to be shared.
import {share} from './share.js';

const kFiles = [
  {name: 'report.html', label: 'Report', type: 'text/html'},
  {name: 'onsets.csv', label: 'Times of the bounces (CSV)', type: 'text/csv', ofTimes: true},
  {name: 'samples.csv', label: 'Speeds and ε (CSV)', type: 'text/csv'},
  {name: 'fit.json', label: 'Fit (JSON)', type: 'application/json'},
  {name: 'labels.txt', label: 'Audacity labels', type: 'text/plain', ofTimes: true},
];

export function save(name, parts, type) {
  const url = URL.createObjectURL(new Blob(parts, {type}));
  const link = element('a', {href: url, download: name});
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 60e3);  // the browser may still be writing
}

/// @param stem  what the files' names begin with
/// @param found  whether there is a result
/// @param hasTimes  whether times were measured
/// @param wav    function that gives {bytes} of the sound as a WAV file where it is not a file already, else null
export function showDownloads(host, engine, stem, found, hasTimes, wav, trouble) {
  const button = (name, label, action) => {
    const b = element('button', {type: 'button', 'data-file': name}, label);
    b.addEventListener('click', () => action().catch(trouble));
    return b;
  };
  const buttons = (found ? kFiles : []).filter(f => hasTimes || !f.ofTimes).map(f => button(f.name, f.label, async () => save(`${stem}-${f.name}`, [(await engine.run({task: 'save', name: f.name})).text], f.type)));
  if (found && document.querySelector('#law-plot svg')) buttons.unshift(button('picture', 'Share', () => share(stem, save)));
  if (wav) buttons.push(button('sound.wav', 'Sound (WAV)', async () => save(`${stem}.wav`, [(await wav()).bytes], 'audio/wav')));
  host.replaceChildren(...buttons);
  host.parentElement.hidden = !buttons.length;
}
