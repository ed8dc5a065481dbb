// SPDX-License-Identifier: GPL-3.0-or-later
// What the page says when something does not work: one sentence, and it stays usable.

/// A sentence for people.
export class Trouble extends Error {}

const $ = id => document.getElementById(id);

/// What the page's fields are called, by the option of the command line that each sets.
const kFields = {as: 'What they are', unit: 'Unit', ball: 'Ball', plate: 'Floor', 'drop-height': 'Drop height', gravity: 'Gravity', drops: 'Drops', impacts: 'Bounces', seed: 'Number of the ball', 'radius-law': 'Surface', 'snr-db': 'Noise'};

/// What the libraries say, in words of the page. What is for the command line alone stands in parentheses that begin with
/// an option or with the program's name, or behind "; say": an option for each reading, which is a button here. An option
/// elsewhere is the field that sets it.
export const plain = text => text.replace(/; say --.*$/s, '').replace(/\s*\((--|bouncelab )([^()]|\([^()]*\))*\)/g, '')
    .replace(/--([a-z][a-z-]*)/g, (_, option) => kFields[option] ?? option.replaceAll('-', ' '))
    .replace(/\+-/g, '±').replace(/\^2/g, '²').replace(/\^3/g, '³').replace(/\beps\b/g, 'ε');

export function say(text) {
  $('status').className = '';
  $('status').textContent = text;
}
export function sayTrouble(error) {
  working(false);
  $('status').className = 'trouble';
  $('status').textContent = error instanceof Trouble ? plain(error.message) : `Something went wrong in the page itself: ${error?.message ?? error}`;
  if (!(error instanceof Trouble)) console.error(error);
  $('status').scrollIntoView({block: 'nearest'});
}
export function working(is) { $('busy').hidden = !is; }

/// Modules of WebAssembly that are valid only with 128-bit SIMD and with exceptions.
const kSimd = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];
const kExceptions = [0, 97, 115, 109, 1, 0, 0, 0, 1, 4, 1, 96, 0, 0, 3, 2, 1, 0, 10, 8, 1, 6, 0, 6, 64, 25, 11, 11];

/// Throws a sentence where the browser cannot run the computation.
export function checkBrowser() {
  const runs = bytes => typeof WebAssembly === 'object' && WebAssembly.validate(new Uint8Array(bytes));
  if (!runs(kSimd) || !runs(kExceptions))
    throw new Trouble('This browser is too old to compute here (WebAssembly without SIMD or exceptions); Firefox 114, Chrome 95, Safari 16.4 or newer can.');
}
