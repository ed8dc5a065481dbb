// SPDX-License-Identifier: GPL-3.0-or-later
// The page: warnings, answers, figures, tables.


function card(value, text) { return element('div', {class: 'card'}, element('b', {}, value), element('span', {}, text)); }

/// Of a loop: what was found of what went in. (Of recordings the answer says it.)
function counts() {
  const cards = [];
  const score = summary && summary.score;
  if (score) {
    cards.push(card(`${number(score.n_found)} of ${number(score.n_true)}`, 'impacts found in the sound'),
               card(`${number(score.n_true - score.n_found)} / ${number(score.n_marked - score.n_found)}`, 'missed / invented'));
    if (known(summary.n_drops)) cards.push(card(number(summary.n_drops), summary.n_drops === 1 ? 'drop' : 'drops'));
    if (known(score.within_drops_s)) cards.push(card(`${number(1e6 * score.within_drops_s, 3)} µs`, 'root mean square (rms) error of the times within a drop'));
    if (known(summary.n_samples)) cards.push(card(number(summary.n_samples), 'samples: bounces with an ε'));
  }
  if (cards.length) add('div', {class: 'cards'}, cards);
}

/// Every heading as a link; beside the text where there is room, else above it and folded.
function contents() {
  const links = [...page.querySelectorAll('h2')].map((h, k) => {
    const place = h.parentElement.classList.contains('figure') ? h.parentElement : h;
    if (!place.id) place.id = 'part-' + k;
    return element('li', {}, element('a', {href: '#' + place.id}, h.textContent));
  });
  if (links.length < 3) return;
  const fold = element('details', {}, element('summary', {}, 'Contents'), element('ol', {}, links));
  const wide = window.matchMedia('(min-width: 1100px)');
  const follow = () => { fold.open = wide.matches; };
  follow();
  wide.addEventListener('change', follow);
  document.getElementById('contents').append(fold);
  document.body.classList.add('with-contents');
}

function figures() {
  if (data.sweep) sweepSection(data.sweep);
  if (data.paper && data.simulation) paperSection(data.paper, data.simulation);
  onScreen(figuresOfFit);
}

/// What is not printed with the page.
function onScreen(show) {
  const before = page.children.length;
  show();
  for (const node of [...page.children].slice(before)) node.classList.add('on-screen');
}

/// Of recordings, plates or drops that differ, figures of all together would be of no ball.
const isOneBall = !fit || fit.is_one_ball !== false;

function figuresOfFit() {
  if (!fit) return;
  if (isOneBall) figuresOfOneBall();
  else if ((fit.residuals || []).length) add('p', {class: 'caption'}, `What is drawn of one ball (residuals, distributions and slopes of p(ε), scatter, error budget, constants) is left out: these ${fit.recordings?.length > 1 ? nounOfRows + 's' : 'drops'} differ, and of all together it would belong to none. Fit each alone, or all as one with --pool.`);
  if (wave && (wave.excerpts || []).length) excerptsSection();
  if (data.diagnostics) diagnosticsSection(data.diagnostics);
}

function figuresOfOneBall() {
  if ((fit.residuals || []).length > 1)
    drawResiduals(figure('residuals', 'Does the law hold at every speed?', 'Of the law with its few constants, not of the curve. Above: mean residual (ε less the law) in bins of speed over its standard error, the pull; pulls scatter about 0 by about 1 where the law holds. Below: mean distance from the law over the one that the fit expects, with its standard error.' + (withMemory ? ' Of the fit that takes impacts as independent.' : '')), fit.residuals);
  const histograms = (fit && fit.histograms) || [], theory = summary && summary.theory;
  const shown = histograms.filter(h => h.bins && h.curve && (h.curve.eps || []).length);
  if (shown.length) {
    const parent = figure('histograms', 'Distribution of ε at fixed speed',
                          'Points: normalised frequency with Poisson errors, logarithmic axis. Red: two exponentials, one rising, one falling, of different slope, as the timing noise blurs them. Grey dots: the normal that fits best.' +
                          (theory && (theory.densities || []).length ? ' Green dashes: the closed form, nothing fitted, from the surface simulated and the drops’ own past. Open circles: the simulated ε, without sound.' : ''));
    parent.classList.add('grid');
    for (const h of shown) drawHistogram(parent, h);
    if (shown.length > 1)
      drawSlopes(figure('slopes', 'Slopes of p(ε) against speed', 'Slopes of the two exponentials, timing noise taken out, with 95% intervals.' +
                        (theory ? ` Lines: the closed form, without a fitted parameter, from the surface simulated. Open circles: ${data.simulation ? 'the simulation, without sound' : 'from the true times'}.` : '') +
                        ' Below: their ratio; 1 would be a symmetric p(ε).'), shown, theory);
  }
  theorySection(theory);
  reservoirSection(summary && summary.reservoir);
  if (fit.memory) memorySection(fit.memory, fit.roughness);
  const budget = fit && fit.budget;
  if (budget && (budget.rows || []).length > 1) {
    drawEnergy(figure('energy', 'Scatter against speed', 'Standard deviation of ε − ε(v), all of it and by cause. An energy given at random to rotation makes it go as 1/v.'), budget);
    // two exponentials have a kurtosis of 6: the variance of n samples is known to sqrt(5/n)
    const randomShare = Math.max(...budget.rows.filter(r => r.n > 1).map(r => Math.sqrt(5 / r.n)));
    drawBudget(figure('budget', 'What limits the result', `Where the variance of ε comes from; ${number(100 * randomShare, 1)}% not explained may be random error.${shiftsOf(budget).length ? ' Below: what drag and contact time would shift the curve by; they are taken out.' : ''}`), budget);
  }
  cornerOfConstants();
}

function tables() {
  truthTable();
  if (isOneBall) curveTable(), constantsTable();
  recordingsTable();
  if (isOneBall) histogramTables();
  slopesOfRecordings();
  timingTable();
  if (isOneBall) budgetTable();
  handOff();
  doubtfulDrops();
}

add('h1', {}, data.title);
add('p', {class: 'sub'}, data.program);
if (data.comparison) comparisonPage(data.comparison, data.points);
if (data.validation) validationPage(data.validation);
firstScreen();
counts();
questions();
notes();
details();
onScreen(() => ballSection(summary && summary.ball));
figures();
tables();
contents();
add('footer', {}, `${data.program}. Model: Montaine, Heckel, Kruelle, Schwager, Pöschel, Phys. Rev. E 84, 041306 (2011).`);
finishPlots();
