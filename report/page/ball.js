// SPDX-License-Identifier: GPL-3.0-or-later
// The ball of a simulation: its surface where it is cut open, and a contact; figures 2 and 3 of the paper with the
// numbers of this run. What is drawn larger than it is says so.

const svgNode = (tag, attributes, ...children) => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
const drawing = (width, height, label, ...children) => svgNode('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': label, class: 'drawing', style: `max-width: ${width}px`}, ...children);
const svgText = (x, y, text, extra = {}) => svgNode('text', {x, y, ...extra}, text);
const svgLine = (x1, y1, x2, y2, extra = {}) => svgNode('line', {x1, y1, x2, y2, class: 'stroke', ...extra});
/// A length with a unit that a reader knows.
const small = m => m < 1e-3 ? `${number(1e6 * m, 3)} µm` : `${number(1e3 * m, 3)} mm`;

/// The whole ball, its asperities enlarged, with the piece that the close-up shows.
function drawBall(parent, ball) {
  const r = 130, cx = 160, cy = 160, section = ball.section, n = 72;
  const bump = 5, enlarged = bump / r / (ball.mean_asperity_radius_m / ball.radius_m);
  const radii = section.radius_m.length ? section.radius_m : [ball.mean_asperity_radius_m];
  const bumps = [...Array(n).keys()].map(k => {
    const angle = 2 * Math.PI * (k + 0.35 * Math.sin(12.9898 * k)) / n, size = bump * radii[k % radii.length] / ball.mean_asperity_radius_m;
    return svgNode('circle', {cx: cx + r * Math.cos(angle), cy: cy + r * Math.sin(angle), r: Math.max(1, size), class: 'asperity'});
  });
  parent.append(drawing(320, 340, `The ball, radius ${small(ball.radius_m)}, with asperities drawn ${number(enlarged, 2)} times as large as they are`,
    ...bumps, svgNode('circle', {cx, cy, r, class: 'ball'}), svgLine(cx, cy, cx + r * 0.72, cy - r * 0.69, {'marker-end': 'url(#tip)'}),
    svgText(cx + 30, cy - 52, 'R', {class: 'symbol'}), svgText(cx, cy + 24, `R = ${small(ball.radius_m)}`, {'text-anchor': 'middle'}),
    svgText(cx, cy + 46, `${number(ball.n_asperities)} asperities`, {'text-anchor': 'middle'}),
    svgNode('circle', {cx, cy: cy + r, r: 15, class: 'lens'}), svgText(cx, 332, `asperities drawn ${number(enlarged, 2)} × too large, and few of them`, {'text-anchor': 'middle', class: 'note'})));
}

/// The surface where the ball is cut through its centre: true shape, one scale.
function drawCloseUp(parent, ball) {
  const {half_angle_rad: half, angle_rad: angles, radius_m: radii} = ball.section;
  const width = 620, height = 250, left = 12, x = angle => left + (angle + half) / (2 * half) * (width - 2 * left);
  const scale = (width - 2 * left) / (2 * half * ball.radius_m), base = 110;  // pixels a metre
  const y = angle => base - ball.radius_m * scale * (1 - Math.cos(angle));
  const arc = [...Array(61).keys()].map(k => -half + 2 * half * k / 60);
  const circles = angles.map((angle, k) => svgNode('circle', {cx: x(angle), cy: y(angle), r: Math.max(0.8, radii[k] * scale), class: 'asperity'}));
  const nice = [1, 2, 5].flatMap(m => [-9, -8, -7, -6, -5, -4, -3].map(e => m * 10 ** e)).sort((a, b) => a - b).filter(m => m * scale < 160).at(-1);
  parent.append(drawing(width, height, `Close-up of the ball's surface, ${angles.length} asperities cut by a plane through the centre, in true proportion`,
    ...circles, svgNode('path', {d: `M${arc.map(a => `${x(a).toFixed(1)},${y(a).toFixed(1)}`).join('L')}L${x(half)},0L${x(-half)},0Z`, class: 'ball'}),
    svgText(width / 2, 34, 'ball', {'text-anchor': 'middle'}),
    svgLine(left, 205, left + nice * scale, 205), svgLine(left, 200, left, 210), svgLine(left + nice * scale, 200, left + nice * scale, 210), svgText(left, 228, small(nice)),
    svgText(width - left, 228, `mean radius of an asperity ${small(ball.mean_asperity_radius_m)}`, {'text-anchor': 'end'})));
}

/// A contact: the asperity that touches lies beside the lowest point, so that the impulse has a lever.
function drawContact(parent, ball, offsetVariance) {
  const r = 150, cx = 230, plate = 330, asperity = 26, tilt = 0.42;
  const ax = cx + r * Math.sin(tilt), ay = plate - asperity, cy = ay - r * Math.cos(tilt);
  const degrees = known(offsetVariance) ? Math.sqrt(2 * offsetVariance) * 180 / Math.PI : null;
  const enlarged = asperity / r / (ball.mean_asperity_radius_m / ball.radius_m);
  const words = `The contact: only the asperity that touches is drawn, ${number(enlarged, 2)} times as large as it is` + (degrees ? `; the angle is ${number(degrees, 2)}° (root mean square)` : '');
  const angleArc = svgNode('path', {d: `M${cx},${cy + 58}A58,58 0 0 0 ${cx + 58 * Math.sin(tilt)},${cy + 58 * Math.cos(tilt)}`, class: 'stroke', fill: 'none'});
  parent.append(drawing(460, 400, words,
    svgNode('circle', {cx: ax, cy: ay, r: asperity, class: 'asperity'}), svgNode('circle', {cx, cy, r, class: 'ball'}),
    svgLine(20, plate, 440, plate, {class: 'plate'}), svgText(24, plate + 20, 'plate'),
    svgLine(cx, cy, cx, plate, {'stroke-dasharray': '4 4'}), svgLine(cx, cy, ax, ay), svgLine(ax, ay, ax, plate), angleArc,
    svgNode('circle', {cx, cy, r: 3.5, class: 'dot'}), svgText(cx - 18, cy - 8, 'G', {class: 'symbol'}),
    svgNode('circle', {cx: ax, cy: plate, r: 3.5, class: 'dot'}), svgText(ax + 9, plate - 7, 'C', {class: 'symbol'}),
    svgText(cx + 14, cy + 80, 'θ', {class: 'symbol'}), svgText((cx + ax) / 2 + 12, (cy + ay) / 2 - 6, 'R', {class: 'symbol'}),
    svgText(ax + asperity + 8, ay - 4, 'R', {class: 'symbol'}), svgText(ax + asperity + 19, ay + 1, 'j', {class: 'index'}),
    svgLine(cx - 70, cy - 60, cx - 70, cy + 10, {'marker-end': 'url(#tip)'}), svgText(cx - 92, cy - 20, 'v', {class: 'symbol'}),
    svgText(24, 374, `asperity drawn ${number(enlarged, 2)} × too large,`, {class: 'note'}),
    svgText(24, 392, degrees ? `θ as ${number(tilt * 180 / Math.PI, 2)}°; it is ${number(degrees, 2)}° (root mean square)` : 'θ too large', {class: 'note'})));
}

/// Of a loop: both figures. Recordings have none.
function ballSection(ball) {
  if (!ball) return;
  document.body.append(svgNode('svg', {width: 0, height: 0, 'aria-hidden': 'true', class: 'defs'}, svgNode('defs', {},
    svgNode('marker', {id: 'tip', viewBox: '0 0 10 10', refX: 9, refY: 5, markerWidth: 7, markerHeight: 7, orient: 'auto'}, svgNode('path', {d: 'M0,0L10,5L0,10Z', class: 'dot'})))));
  const draws = (name, title, caption) => {
    const section = add('section', {class: 'sketch', id: name, 'aria-label': title}, element('h2', {}, title), element('p', {class: 'caption'}, caption)), place = element('div', {class: 'pair'});
    section.append(place);
    return place;
  };
  const surface = draws('ball', 'The ball that was simulated, and its surface',
    'Left: a sphere with small spheres, the asperities, centred on its surface. Right: the surface of this run where a plane through the centre cuts it, all at one scale. (Figure 2 of the paper, with the asperities drawn for this run.)');
  drawBall(surface, ball);
  if (ball.section.angle_rad.length) drawCloseUp(surface, ball);
  drawContact(draws('contact', 'A contact', 'The ball touches with one asperity, beside its lowest point: the force has a lever about the centre G and turns the ball. Energy goes from bouncing into spin and back, and ε scatters from impact to impact. (Figure 3 of the paper.)'), ball, summary.theory && summary.theory.offset_variance);
}
