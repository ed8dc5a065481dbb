// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures with two axes as SVG: points, error bars, lines, bands. A few hundred elements, drawn in milliseconds, so that
// they can be drawn again at every new bounce. Colours are in page.css. (svgNode, number: report's ball.js, text.js)

const kMostCircles = 300;
const kMargin = {left: 66, right: 10, top: 8, bottom: 42};

/// Round numbers between lo and hi, some n of them: steps of 1, 2 or 5 times a power of ten.
export function roundTicks(lo, hi, n) {
  const raw = (hi - lo) / Math.max(1, n), power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(m => m * power).find(s => s >= raw * 0.999);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const first = Math.ceil(lo / step - 1e-9), last = Math.floor(hi / step + 1e-9);
  const ticks = [...Array(Math.max(0, last - first + 1)).keys()].map(k => ({at: (first + k) * step, text: ((first + k) * step).toFixed(decimals).replace('-', '−')}));
  return ticks.length < 2 ? roundTicks(lo, hi, 2 * n) : ticks;  // one number is no scale
}
const superscript = n => [...String(n)].map(c => c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[+c]).join('');
const decadeTicks = (lo, hi) => [...Array(40).keys()].map(k => k - 20).filter(e => e >= Math.log10(lo) - 1e-9 && e <= Math.log10(hi) + 1e-9)
    .map(e => ({at: 10 ** e, text: e >= 0 && e < 4 ? String(10 ** e) : '10' + superscript(e)}));

/// Smallest and largest, widened by a share of their distance.
export function paddedRange(values, share = 0.06) {
  const known = values.filter(Number.isFinite);
  if (!known.length) return [0, 1];
  let lo = known.reduce((a, b) => Math.min(a, b)), hi = known.reduce((a, b) => Math.max(a, b));
  if (hi - lo < 1e-12 * Math.max(1, Math.abs(hi))) { lo -= 0.01; hi += 0.01; }
  const pad = share * (hi - lo);
  return [lo - pad, hi + pad];
}

/// @param host    element to draw into; the picture takes its width, and is drawn again when that changes
/// @param spec    {height, label, title, x: {title, range}, y: {title, range, log}, layers}
///                layers: {kind: points|provisional|errors|curve|band|truth|newest, x, y, [lo, hi]}
export function drawPicture(host, spec) {
  host.spec = spec;
  if (!host.watched) {
    host.watched = true;
    let width = host.clientWidth;
    new ResizeObserver(() => {
      if (host.clientWidth === width || !host.clientWidth) return;
      width = host.clientWidth;
      requestAnimationFrame(() => render(host));
    }).observe(host);
  }
  render(host);
}

function render(host) {
  const spec = host.spec, width = Math.max(200, host.clientWidth || 600), height = spec.height;
  const top = kMargin.top + (spec.title ? 18 : 0);
  const inner = {left: kMargin.left, right: width - kMargin.right, top, bottom: height - kMargin.bottom};
  const scale = (axis, from, to) => {
    const f = axis.log ? Math.log : (v => v), lo = f(axis.range[0]), hi = f(axis.range[1]);
    return v => from + (f(v) - lo) / (hi - lo) * (to - from);
  };
  const x = scale(spec.x, inner.left, inner.right), y = scale(spec.y, inner.bottom, inner.top);
  const svg = svgNode('svg', {viewBox: `0 0 ${width} ${height}`, width, height, class: 'picture', role: 'img', 'aria-label': spec.label});
  const text = (at, words, attributes) => svg.append(svgNode('text', {x: at[0], y: at[1], ...attributes}, words));
  const clip = `clip-${host.id}`;
  svg.append(svgNode('clipPath', {id: clip}, svgNode('rect', {x: inner.left, y: inner.top, width: inner.right - inner.left, height: inner.bottom - inner.top})));
  for (const tick of roundTicks(...spec.x.range, Math.max(2, Math.floor((inner.right - inner.left) / 80)))) {
    svg.append(svgNode('line', {x1: x(tick.at), x2: x(tick.at), y1: inner.top, y2: inner.bottom, class: 'rule'}));
    text([x(tick.at), inner.bottom + 16], tick.text, {'text-anchor': 'middle'});
  }
  for (const tick of spec.y.log ? decadeTicks(...spec.y.range) : roundTicks(...spec.y.range, Math.max(2, Math.floor((inner.bottom - inner.top) / 45)))) {
    svg.append(svgNode('line', {x1: inner.left, x2: inner.right, y1: y(tick.at), y2: y(tick.at), class: 'rule'}));
    text([inner.left - 6, y(tick.at) + 4], tick.text, {'text-anchor': 'end'});
  }
  text([(inner.left + inner.right) / 2, height - 6], spec.x.title, {'text-anchor': 'middle'});
  const middle = (inner.top + inner.bottom) / 2;
  text([12, middle], spec.y.title, {'text-anchor': 'middle', transform: `rotate(-90 12 ${middle})`});
  if (spec.title) text([(inner.left + inner.right) / 2, 14], spec.title, {'text-anchor': 'middle', class: 'title'});
  const layers = svgNode('g', {'clip-path': `url(#${clip})`});
  for (const layer of spec.layers) layers.append(...shapes(layer, x, y, spec));
  svg.append(layers, svgNode('rect', {x: inner.left, y: inner.top, width: inner.right - inner.left, height: inner.bottom - inner.top, class: 'frame'}));
  host.replaceChildren(svg);
}

/// Coordinates are kept within a few pictures' sizes, which browsers draw without loss.
const px = value => Math.max(-1e4, Math.min(1e4, value)).toFixed(1);

function shapes(layer, x, y, spec) {
  const at = k => `${px(x(layer.x[k]))},${px(y(layer.y[k]))}`;
  const drawable = k => Number.isFinite(layer.x[k]) && Number.isFinite(layer.y[k]) && (!spec.y.log || layer.y[k] > 0);
  const indices = layer.x.map((_, k) => k);
  switch (layer.kind) {
    case 'band': {
      const edge = (side, list) => list.map(k => `${px(x(layer.x[k]))},${px(y(layer[side][k]))}`);
      return [svgNode('path', {class: 'band', d: `M${[...edge('hi', indices), ...edge('lo', [...indices].reverse())].join('L')}Z`})];
    }
    case 'curve': case 'truth':
      return [svgNode('path', {class: layer.kind, d: 'M' + indices.filter(drawable).map(at).join('L')})];
    case 'errors': {
      const low = k => spec.y.log ? Math.max(layer.lo[k], spec.y.range[0]) : layer.lo[k];
      return [svgNode('path', {class: 'errors', d: indices.map(k => `M${px(x(layer.x[k]))},${px(y(low(k)))}V${px(y(layer.hi[k]))}`).join('')})];
    }
    default: {
      if (indices.length > kMostCircles)  // too many to be pointed at: one path of dots, which is drawn ten times as fast
        return [svgNode('path', {class: 'dots', d: indices.filter(drawable).map(k => `M${at(k)}h0`).join('')})];
      const radius = layer.kind === 'newest' ? 7 : 3.2;
      return indices.filter(drawable).map(k => svgNode('circle', {class: layer.kind, cx: px(x(layer.x[k])), cy: px(y(layer.y[k])), r: radius},
                                                       svgNode('title', {}, `v = ${number(layer.x[k], 4)} m/s, ε = ${number(layer.y[k], 5)}`)));
    }
  }
}
