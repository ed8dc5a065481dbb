// SPDX-License-Identifier: GPL-3.0-or-later
// The memory of the fluctuations: probability transforms, tests, roughness.


/// Counts by twentieths of the probability transform, with what a uniform one would give and the band that holds 95 %
/// of its bins.
function drawTransforms(parent, counts) {
  const n = counts.reduce((sum, count) => sum + count, 0), share = 1 / counts.length, expected = n * share;
  const half = 1.96 * Math.sqrt(n * share * (1 - share));
  const outside = counts.map(count => Math.abs(count - expected) > half);
  const level = (y, dash) => ({type: 'line', xref: 'paper', x0: 0, x1: 1, y0: y, y1: y, line: {color: ink, width: 1, dash}});
  const low = Math.min(expected - half, ...counts.map(c => c - Math.sqrt(c))), high = Math.max(expected + half, ...counts.map(c => c + Math.sqrt(c))), margin = 0.06 * (high - low);
  draw(parent, 'low', [{x: counts.map((_, k) => (k + 0.5) * share), y: counts, type: 'scatter', mode: 'markers', name: 'impacts in a twentieth',
                        error_y: {type: 'data', array: counts.map(Math.sqrt), thickness: 1, width: 0, color: grey},
                        marker: {size: 7, color: counts.map((_, k) => outside[k] ? red : blue)},
                        hovertemplate: '%{x:.3f}<br>%{y} impacts<extra></extra>'}],
       {showlegend: false, xaxis: axis('probability transform of the fluctuation', {range: [0, 1]}),
        yaxis: axis('number of impacts', {range: [Math.max(0, low - margin), high + margin]}),
        shapes: [{type: 'rect', xref: 'paper', x0: 0, x1: 1, y0: expected - half, y1: expected + half, fillcolor: 'rgba(31,95,168,.14)', line: {width: 0}, layer: 'below'}, level(expected, 'dash')]});
  return outside.filter(Boolean).length;
}
const bandWords = n => `Line and band: the count of a uniform distribution, with the 95% range of one bin. ${n} of 20 bins ${n === 1 ? 'lies' : 'lie'} outside it (red); 1 would by chance.`;
const total = counts => counts.reduce((sum, count) => sum + count, 0);

/// Of a simulation: does each impact follow the closed form, given the drop's earlier impacts?
function theorySection(theory) {
  if (!theory || !theory.n_transforms) return;
  const parent = figure('theory', 'The closed form of the scatter, put to each simulated impact',
                        `Probability transforms of ${number(theory.n_transforms)} simulated impacts: how probable a lower ε was, given what the drop’s earlier impacts have left in spin and sideways motion. ` +
                        `No parameter is fitted: q = c s₂ = ${number(theory.contact_factor, 3)} · ${number(theory.offset_variance, 3)} = ${number(theory.q, 3)} is that of the surface simulated.`);
  const n = drawTransforms(parent, theory.transform_counts);
  parent.append(element('p', {class: 'caption'}, bandWords(n)));
}

const pText = p => known(p) ? (p < 1e-4 ? '< 0.0001' : number(p, 2)) : '–';

function memoryTests(m) {
  const tests = m.tests || {}, ad = m.anderson_darling;
  const said = (p, passes, fails, limit = 0.01) => known(p) ? (p >= limit ? passes : fails) : 'not tested';
  const rows = [];
  if (ad) rows.push(['transforms uniform (Anderson-Darling)', `A² = ${number(ad.a2, 3)}`, pText(ad.p_value),
                     said(ad.p_value, 'each fluctuation is distributed as its drop’s past says', 'the fluctuations are not distributed as the model says')]);
  rows.push(['offset and width by one roughness', `z = ${number(tests.mechanism_z, 2)}`, pText(tests.mechanism_p),
             said(tests.mechanism_p, 'the scatter is that of a rough ball', 'something other than the ball’s roughness scatters ε as well')]);
  rows.push(['as rough at every speed', `z = ${number(tests.by_speed_z, 2)}`, pText(tests.by_speed_p),
             said(tests.by_speed_p, 'fast and slow impacts scatter by one roughness', 'fast and slow impacts want different roughness: ε scatters by more than the ball’s, or the times are worse than stated')]);
  if (known(tests.between_drops_p))
    rows.push(['drops alike', `ratio ${number(tests.between_drops_ratio, 3)}`, pText(tests.between_drops_p),
               said(tests.between_drops_p, 'drops differ as much as their impacts say', 'drops differ by more: the place on the plate, its temperature or the ball changed between them')]);
  rows.push(['energy lost by the reservoir at a bounce', m.leak ? measured(m.leak.value, m.leak.se) : '–', pText(tests.leak_p),
             said(tests.leak_p, 'none seen; it is in the error of ε(v)', 'spin and sideways motion die away; taken into account')]);
  rows.push(['energy in the reservoir at the release', m.release_m2ps2 ? measured(m.release_m2ps2.value, m.release_m2ps2.se) + ' m²/s²' : '–', pText(tests.release_p),
             said(tests.release_p, 'the drops begin without spin and sideways motion, as far as they show; that they may have some is in the errors',
                  tests.release_z > 0 ? 'the ball is released with spin or sideways motion; taken into account' : 'the first impacts scatter less than those of a ball at rest would; taken into account')]);
  if (known(m.loglik) && known(m.loglik_independent))
    rows.push(['ln L above that of independent impacts', number(m.loglik - m.loglik_independent, 4), '',
               m.loglik > m.loglik_independent ? 'memory explains the scatter better' : 'independent impacts explain the scatter better']);
  table('', ['test', 'value', 'p', element('span', {class: 'words'}, 'in words')], rows.map(row => [...row.slice(0, 3), element('span', {class: 'words'}, row[3])]));
}

/// What the scatter says of the surface. All but q follows from q, so that an interval is q's, to a power.
function roughnessTable(r) {
  if (!r || !known(r.q)) return;
  const range = (value, power) => {
    if (!Array.isArray(r.q_ci95) || !r.q_ci95.every(known) || !known(value)) return '–';
    const ends = r.q_ci95.map(q => value * (q / r.q) ** power).sort((a, b) => a - b);
    return ends.map(x => significant(x)).join(' … ');
  };
  const row = (name, value, power, unit = '') => [name, significant(value) + unit, range(value, power) + unit];
  table('Roughness', ['quantity', 'value', '95% interval'], [
    row('q, variance of the contact’s offset times c', r.q, 1),
    row('s₂ if the contact does not slip', r.s2_no_slip, 1), row('s₂ without friction', r.s2_frictionless, 1),
    row('rms tilt of the contact, no slip', r.rms_tilt_no_slip_deg, 0.5, '°'),
    row('as many asperities of one radius (N)', r.n_constant_radii, -1),
    row('or exponential radii of this mean over R (λ)', r.lambda_exponential, 1),
    row('or 10⁶ asperities of uniform radii, width over R (w)', r.width_uniform_1e6, 2),
  ].filter(cells => cells[1] !== '–'), 'What the scatter knows of the surface is q alone. The number of asperities, their radii and whether the contact slips cannot be known from it: each of the last three lines is a surface, in contact without slip, that would scatter the same. ' +
     `Moment of inertia ${number(known(r.inertia_factor) ? r.inertia_factor : 0.4, 3)} m R² (${r.ball || 'a solid sphere: no ball was named'}). Interval of q with its error from the fit; the others follow.`);
}

/// Everything above, where the fit has a memory.
function memorySection(m, roughness) {
  const objections = whyOf(/^memory_(?!without_ball)/);
  const words = m.status !== 'ok' ? `The memory could not be fitted: ${objections || m.status}.` :
      m.holds ? `It holds: the energy that a bounce takes out of the vertical motion sits in spin and sideways motion and sets how much the next may scatter. ${number(m.n)} impacts of ${number(m.n_drops)} ${m.n_drops === 1 ? 'drop' : 'drops'}.` :
      `It does not hold for these impacts${objections ? ': ' + objections : ''}. ε(v) of the first screen does not use it; the numbers here only show where the model fails.`;
  if (m.status !== 'ok' || !total(m.transform_counts || [])) {
    add('h2', {id: 'memory'}, 'Memory: do the fluctuations depend on those before?');
    add('p', {class: 'caption'}, words);
    return;
  }
  const parent = figure('memory', 'Memory: do the fluctuations depend on those before?', words);
  const n = drawTransforms(parent, m.transform_counts);
  parent.append(element('p', {class: 'caption'}, `Probability transforms of the impacts given the earlier ones of their drop. ${bandWords(n)}`));
  memoryTests(m);
  if (m.holds) roughnessTable(roughness);
  else add('p', {class: 'caption'}, 'Roughness is not stated: it would follow from the model.');
}
