#!/usr/bin/env node
// SPDX-License-Identifier: GPL-3.0-or-later
// The report's plotting library: of plotly.js what figures here are drawn with, minified. Its cartesian bundle has 14 kinds of
// traces, and sliders, menus and images, of which reports draw none: a third of its size, which each report would carry.
//   node bundle_plotly.js OUTPUT
// From the published bundle that is not minified: its sources come with 190 packages, 150 MB. The same bytes each time,
// package-lock.json pins what they are made of.
import {readFileSync, writeFileSync} from 'node:fs';
import {minify} from 'terser';

const traces = ['bar', 'heatmap'];  // beside scatter, which its core has
const unused = ['annotations3d', 'images', 'updatemenus', 'sliders', 'rangeslider', 'rangeselector'];

/// The text with the one place that `pattern` matches replaced; another version of plotly.js may have none.
function replaced(text, pattern, by) {
  const n = [...text.matchAll(new RegExp(pattern, pattern.flags + 'g'))].length;
  if (n !== 1) throw new Error(`bundle_plotly.js: ${n} places instead of one for ${pattern}: is it plotly.js 3.1.0?`);
  return text.replace(pattern, by);
}

/// Registers fewer: a module that nothing requires any more is left out by the minifier.
function reduced(text) {
  const listed = list => list.match(/require_\w+\(\)/g).filter(call => traces.some(name => call.match(`^require_${name}\\d*\\(`)));
  text = replaced(text, /("lib\/index-cartesian\.js"[^[]*register\(\[)([^\]]*)(?=\])/, (_, head, list) => head + listed(list).join(', '));
  for (const name of unused) text = replaced(text, new RegExp(`^ *require_${name}\\(\\),$`, 'm'), '');
  return text;
}

const source = readFileSync(new URL('node_modules/plotly.js-cartesian-dist/plotly-cartesian.js', import.meta.url), 'utf8');
const licenses = [/^\/\*[^]*?\*\//, /\/\*! Bundled license information:[^]*\*\//].map(pattern => source.match(pattern)[0]);
const {code} = await minify(reduced(source), {ecma: 2020, compress: {pure_funcs: ['__commonJS'], passes: 2}, format: {comments: false}});
writeFileSync(process.argv[2], `${licenses[0].replace('(cartesian)', `(scatter, ${traces.join(', ')})`)}\n${code}\n${licenses[1]}\n`);
