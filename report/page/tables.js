// SPDX-License-Identifier: GPL-3.0-or-later
// Tables below the figures.


/// How far a value is from the truth, in standard errors.
const pull = (x, se, truth) => known(x) && known(se) && se > 0 && known(truth) ? ((x - truth) / se).toFixed(1) : '–';

/// Truth beside what came back; only after a closed loop. (The constants have theirs in their own table.)
function truthTable() {
  const nodes = (summary && summary.eps_nodes) || [];
  if (!nodes.some(n => n.from_true_times)) return;
  const rows = nodes.map(n => {
    const a = n.from_true_times || {}, b = n.from_sound || {};
    return [`ε(${speed(n.v_mps)})`, number(n.truth, 6), measured(a.eps, a.se), measured(b.eps, b.se), pull(b.eps, b.se, n.truth)];
  });
  table('What went in, what came out', ['quantity', 'truth', 'from true times', 'from sound', 'pull'], rows,
        'ε is that of the law at the contact, which the most frequent ε follows. Pull: (from sound − truth) / standard error; honest errors give values of about ±1.');
  const cell = x => x ? measured(x.value, x.se) : '–';
  table('', ['slopes of p(ε)', 'rising, true times', 'rising, sound', 'falling, true times', 'falling, sound'], (summary.slopes || []).map(s => {
    const t = s.from_true_times || {}, f = s.from_sound || {};
    return [speed(s.v_mps), cell(t.rising), cell(f.rising), cell(t.falling), cell(f.falling)];
  }));
}

/// ε(v) at a few speeds; mean and peak where they differ from the root mean square by more than its error.
function curveTable() {
  const curve = fit && fit.curve;
  if (!curve) return;
  const others = ['mean', 'peak'].filter(name => curve.nodes.some(n => known(n[name]) && Math.abs(n[name] - n.eps) > n.se));
  const scatter = [`Standard deviation of ε from bounce to bounce at the median speed: ${number(curve.scatter, 2)}`,
                   ...(known(curve.scatter_of_drops) ? [`of what the bounces of one drop share: ${number(curve.scatter_of_drops, 2)}`] : [])];
  const within = (e, scale, unit) => `${number(scale * e.ci95[0], 2)} to ${number(scale * e.ci95[1], 2)}${unit}`;  // log-normal
  const air = [...(curve.kappa_per_m ? [`drag over speed squared ${within(curve.kappa_per_m, 1, ' per m')}`] : []),
               ...(curve.contact_s ? [`contact time ${within(curve.contact_s, 1e3, ' ms')}`] : [])];
  table('ε at some speeds', ['speed', 'ε ± standard error', '95% interval', 'energy lost', ...others.map(name => `${name} of ε`)],
        curve.nodes.map(n => [speed(n.v_mps), measured(n.eps, n.se), interval(n.ci95), `${(100 * (1 - n.eps ** 2)).toFixed(1)} %`, ...others.map(name => measured(n[name], n[`${name}_se`]))]),
        `ε is the root mean square over bounces, √⟨ε²⟩: energy lost is 1 − ε². ${scatter.join('; ')}.` + (air.length ? ` Taken out, at 1 m/s (95 %): ${air.join(', ')}.` : '') +
        (curve.n_drops === 1 && samples?.measured !== 'speeds' ? ' All of this drop: others may differ.' : ''));
}

const isDetermined = name => (constants.parameters || []).includes(name) && constants[name].identified !== false;

/// The law's constants, or why none are stated.
function constantsTable() {
  if (!fit) return;
  const named = [...(constants.parameters || []).filter(isDetermined).map(name => [name, constants[name]]),
                 ...(constants.gamma && !(constants.parameters || []).includes('gamma') ? [['γ, of a viscoelastic sphere', constants.gamma]] : [])];
  const reason = whyOf(/^(law_contradicted|too_few_samples|not_a_sphere|not_converged|not_identifiable)$/);
  const why = reason ? reason[0].toUpperCase() + reason.slice(1) + '.' : '';
  if (!named.length) {
    if (!why) return;
    add('h2', {}, 'Constants of the law');
    add('p', {class: 'caption'}, why);
    return;
  }
  const byDrop = named.some(([, e]) => known(e.se_independent));
  const ofLoop = Object.fromEntries(((summary && summary.constants) || []).map(c => [c.name, c])), afterLoop = named.some(([name]) => ofLoop[name]);
  const beside = (name, e) => {
    const {truth, from_true_times: a} = ofLoop[name] || {};
    return [number(truth, 6), a ? measured(a.value, a.se) : '–', pull(e.value, e.se, truth)];
  };
  const rows = named.map(([name, e]) => [name, measured(e.value, e.se), interval(e.ci95), ...(afterLoop ? beside(name, e) : []),
                                         ...(byDrop ? [known(e.se_independent) ? e.se_independent.toPrecision(2) : '–'] : [])]);
  table('Constants of the law', ['quantity', 'value ± standard error', '95% interval', ...(afterLoop ? ['truth', 'from true times', 'pull'] : []), ...(byDrop ? ['error if impacts were independent'] : [])], rows,
        `ε(v) = 1 + Σ Cᵢ Aᵢ v^(i/10), v in m/s; C₂ = −1.153449, C₄ = 0.798267, C₅ = 4/15. Maximum likelihood${withMemory ? ' of each impact given the earlier ones of its drop (with memory)' : ', the scatter as two exponentials, one to either side, with a normal part; the law is its peak'}. ${why}`.trim());
  const quality = [], good = fit.goodness || {}, covariance = constants.covariance || [];
  covariance.forEach((row, i) => row.forEach((c, j) => i < j && quality.push(`correlation ${constants.parameters[i]} ${constants.parameters[j]} ${number(c / Math.sqrt(covariance[i][i] * covariance[j][j]), 4)}`)));
  if (known(good.chi2)) quality.push(`χ²/ndf (misfit over degrees of freedom, 1 expected) = ${number(good.chi2, 5)}/${number(good.ndf)}, p (chance of a worse one) = ${number(good.p_value, 3)}`);
  if (good.anderson_darling)
    quality.push(`Anderson–Darling A² = ${number(good.anderson_darling.a2, 4)}, p = ${number(good.anderson_darling.p_value, 3)} among ${number(good.anderson_darling.n_replicates)} simulated fits`);
  if (fit.misfit) quality.push(`ln B = ${number(fit.misfit.ln_bayes_factor, 2)} for the law with a smooth deviation against the law alone; above 3 the law does not describe the bounces`);
  if (quality.length) add('p', {class: 'caption'}, quality.join('; ') + '.');
}

/// Do several recordings agree, and the law of each.
function recordingsTable() {
  const all = (fit && fit.recordings) || [], test = fit && fit.recordings_test;
  const far = r => r.offset && r.offset.se > 0 ? Math.abs(r.offset.value) / r.offset.se : 0;
  const most = 50, shown = all.length > most ? [...all].sort((a, b) => far(b) - far(a)).slice(0, most) : all;
  const nodes = (fit && fit.curve && fit.curve.nodes) || [];
  const at = (r, v) => { const n = (r.nodes || []).find(node => node.v_mps === v); return n ? measured(n.eps, n.se) : '–'; };
  table(nounOfRows === 'plate' ? 'Plates' : 'Recordings', [nounOfRows, 'samples', 'drops', ...nodes.map(n => `ε(${speed(n.v_mps)})`), 'offset from one curve'],
        shown.map(r => [shownName(r.recording) || '(no name)', number(r.n), number(r.n_drops), ...nodes.map(n => at(r, n.v_mps)), estimated(r.offset)]),
        (test ? `Each alone. One curve for all: p = ${number(test.p_value, 3)} (likelihood ratio ${number(test.likelihood_ratio, 4)} for ${number(test.ndf)} offsets, against the differences between ${test.within}).` : 'Each alone; too few samples to compare them.') +
        (all.length > most ? ` The ${most} furthest off of ${all.length}; all are in fit.json.` : ''));
}

function histogramTables() {
  const used = ((fit && fit.histograms) || []).filter(h => h.slope_rising && h.slope_ratio), p = of => of.pearson ? number(of.pearson.p_value, 3) : '–';
  foldedTable('p(ε) at fixed speed', ['window', 'n', 'below / above', 'peak ε', 'rising slope', 'falling slope', 'falling / rising (95%)', 'p'],
        used.map(h => [speed(h.v_mps), number(h.n), `${h.bins.underflow} / ${h.bins.overflow}`, estimated(h.peak_eps), estimated(h.slope_rising), estimated(h.slope_falling),
                       `${number(h.slope_ratio.value, 3)} (${interval(h.slope_ratio.ci95)})`, p(h)]),
        'Two exponentials, unbinned, timing noise taken out, the law’s drift inside the window taken out; intervals by profile likelihood. Below / above: samples outside the bins of the picture.');
  foldedTable('Two exponentials or a normal?', ['window', 'ΔAIC', 'p two exponentials', 'p normal'],
        used.filter(h => h.normal).map(h => [speed(h.v_mps), number(Math.round(10 * h.normal.delta_aic) / 10, 6), p(h), p(h.normal)]),
        'AIC of the normal less that of the two exponentials of the same samples, both with the timing errors: positive speaks for the two exponentials. p: of χ².');
}

function slopesOfRecordings() {
  foldedTable(`p(ε) of each ${nounOfRows}`, [nounOfRows, 'window', 'n', 'peak ε', 'rising slope', 'falling slope', 'falling / rising (95%)'],
        ((fit && fit.recordings) || []).flatMap(r => (r.slopes || []).map(h => [shownName(r.recording) || '(no name)', speed(h.v_mps), number(h.n), ...[h.peak_eps, h.slope_rising, h.slope_falling].map(estimated),
                                                                           `${number(h.slope_ratio.value, 3)} (${interval(h.slope_ratio.ci95)})`])),
        `Two exponentials, as of one ball, of the samples of each ${nounOfRows} about its own law.`);
}

function timingTable() {
  const t = fit && fit.budget && fit.budget.timing;
  if (!t) return;
  const us = x => known(x) ? `${number(1e6 * x, 3)} µs` : '–';
  foldedTable('Timing noise that the samples themselves show', ['quantity', 'value'],
        [['correlation of neighbours (0: ball alone, −2/3: timing alone)', measured(t.lag1_correlation, t.lag1_correlation_se)],
         ['timing noise from it', t.sigma_s === null ? `none seen; below ${us(t.upper95_s)} (95%)` : `${us(t.sigma_s)}; below ${us(t.upper95_s)} (95%)`],
         ['timing noise stated by the detector (median)', us(t.stated_s)], ['pairs of neighbours', number(t.n_pairs)]]);
}

function budgetTable() {
  const b = fit && fit.budget;
  if (!b || !(b.rows || []).length) return;
  const percent = x => known(x) ? `${(100 * x).toFixed(100 * x < 1 && x > 0 ? 3 : 1)}%` : '–', tiny = x => known(x) ? (x === 0 ? '0' : x.toExponential(1)) : '–';
  const there = ([key]) => b.rows.some(r => known(r[key]) && r[key] !== 0);
  const parts = causes.filter(there), moved = [...shifts, ['mean_minus_peak', 'mean − peak']].filter(there);
  foldedTable('Error budget', ['v (m/s)', 'n', 'sd of ε', ...parts.map(([, name]) => name), ...moved.map(([, name]) => name)],
        b.rows.map(r => [number(r.v_mps, 3), number(r.n), tiny(r.spread), ...parts.map(([key]) => percent(r[key])), ...moved.map(([key]) => tiny(r[key]))]),
        'Shares of the variance of ε, then shifts of ε(v), those of drag and contact time taken out. Mean − peak: what a fit of the mean is off by; the law follows the peak.');
}

/// The fitted law for codes of discrete particles.
function handOff() {
  const h = fit && fit.hand_off;
  if (!h) return;
  const fold = folded('In a DEM code', {id: 'dem'});
  fold.append(element('p', {class: 'caption'}, `Root mean square √⟨ε²⟩ = ${measured(h.eps, h.se)} at ${speed(h.v_mps)}, which keeps the energy. Mind: ${[h.warning, h.missing].filter(Boolean).join('; ')}. Each input is one impact of ${h.ball}, complete; \`bouncelab dem fit.json --code lammps\` prints it.`));
  const rows = ['v_mps,eps,lo95,hi95', ...answerCurve(fit).map(p => [p.v_mps, p.eps, p.lo95, p.hi95].map(x => x === null ? '' : x).join(','))];
  fold.append(element('p', {}, element('a', {href: 'data:text/csv;charset=utf-8,' + encodeURIComponent(rows.join('\n') + '\n'), download: 'restitution_law.csv'}, 'ε(v) with its 95% band as a table (CSV)'),
      '; constants with their covariance: fit.json.'),
              ...(data.dem || []).flatMap(s => [element('h3', {}, `${s.program}, ${s.model}`), element('p', {class: 'caption'}, `fills ${s.parameter}`),
                                                element('pre', {tabindex: '0', role: 'region', 'aria-label': `Input for ${s.program}, ${s.model}`}, s.text)]));
}

function doubtfulDrops() {
  const rows = ((summary && summary.recordings) || []).flatMap(r => (r.drops || []).filter(d => d.doubtful).map(
      d => [shownName(r.recording), number(d.begin_s, 4), number(d.n_impacts), `${number(d.odds, 2)} to 1`]));
  const most = 30;
  foldedTable('Doubtful drops', ['recording', 'begins at, s', 'impacts', 'odds for a ball'], rows.slice(0, most),
        'They are in the fit. Listen to them; what is no ball can be taken out of onsets.csv.' + (rows.length > most ? ` The first ${most} of ${rows.length}; all are in summary.json.` : ''));
}

