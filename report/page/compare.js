// SPDX-License-Identifier: GPL-3.0-or-later
// Many recordings: eps of all, by recording, plate, day and speed, drift, outliers.


const dayMs = 86400000;
const isoTime = day => new Date(day * dayMs).toISOString().slice(0, 19);
const pIs = p => p < 1e-4 ? pText(p) : '= ' + pText(p);
const isoDay = day => isoTime(day).slice(0, 10);

/// Places of the recordings along the campaign: dates, or numbers in their order.
function campaignAxis(drift) {
  const byDate = drift && drift.per === 'day';
  return {byDate, at: t => !known(t) ? null : byDate ? isoTime(t) : t, axis: byDate ? axis('date', {type: 'date'}) : axis('recording, in their order')};
}

/// A band between two straight lines. @param rise  of both, from x0 to x1
function straightBand(x0, x1, lo, hi, rise, color, name) {
  return {x: [x0, x1, x1, x0], y: [lo, lo + rise, hi + rise, hi], fill: 'toself', fillcolor: color, line: {width: 0}, hoverinfo: 'skip', name, type: 'scatter', mode: 'lines'};
}

/// Each of the groups that have their own eps.
const ownGroups = c => c.differences && c.differences.differ ? c.differences.groups : [];

/// An entry of the legend that is nothing in the picture.
const inLegend = shown => ({x: [null], y: [null], type: 'scatter', mode: 'lines', hoverinfo: 'skip', ...shown});

function drawCampaign(parent, c, points) {
  const {byDate, at, axis: time} = campaignAxis(c.drift), tau = c.tau.value, groups = ownGroups(c).length > 6 ? [] : ownGroups(c);  // more would hide each other
  const places = points.time.filter(known), begin = Math.min(...places), end = Math.max(...places);
  const line = t => c.drift ? c.drift.slope.value * (t - c.drift.middle) : 0;  // of eps at the middle of the campaign
  const along = (lo, hi, color, name) => straightBand(at(begin), at(end), lo + line(begin), hi + line(begin), line(end) - line(begin), color, name);
  const indices = points.eps.map((_, k) => k), inside = indices.filter(k => !points.outlier[k]), outside = indices.filter(k => points.outlier[k]);
  const many = inside.length > 400;
  const trace = (of, name, marker, errors) => ({
    x: of.map(k => at(points.time[k])), y: of.map(k => points.eps[k]), type: 'scatter', mode: 'markers', name, marker,
    error_y: {type: 'data', array: of.map(k => points.se[k]), thickness: 1, width: 0, color: grey, visible: errors},
    text: of.map(k => `${points.recording[k]}${points.plate[k] ? ', plate ' + points.plate[k] : ''}<br>${number(points.n_samples[k])} samples, ${points.standardised[k].toFixed(1)} standard deviations off`),
    hovertemplate: '%{text}<br>ε = %{y:.5f}<extra></extra>'});
  const traces = [];
  const levels = groups.length ? groups.map((g, k) => ({name: g.name, color: groupColour(k), eps: g.eps.value, next: g.prediction95})) :
                                 [{name: 'recordings', color: blue, eps: c.eps && c.eps.value, next: c.prediction95}];
  levels.forEach(({name, color, eps, next}, k) => {
    const fill = share => color.replace(/^#(..)(..)(..)$/, (_, ...parts) => `rgba(${parts.slice(0, 3).map(p => parseInt(p, 16)).join(',')},${share})`);
    const isOfIt = k => points.plate[k] ? points.plate[k] === name : points.recording[k] === name || points.recording[k].endsWith('/' + name);
    const of = groups.length ? inside.filter(isOfIt) : inside;
    if (places.length && next) traces.push({...along(next[0], next[1], fill(.08), groups.length ? `${name}: 95 % of its recordings` : '95 % of recordings'), showlegend: !groups.length});
    if (places.length && tau > 0 && c.eps) traces.push(along(eps - tau, eps + tau, fill(.18), 'pooled ε ± τ'));
    traces.push(trace(of, name, {size: many ? 3.5 : 6.5, color, opacity: many ? 0.6 : 1}, !many));
    if (c.drift && eps !== null) traces.push({x: [begin, end].map(at), y: [eps + line(begin), eps + line(end)], type: 'scatter', mode: 'lines', name: groups.length ? `${name}: the drift` : 'straight line', line: {color: groups.length ? color : red, width: 2}, hoverinfo: 'skip', showlegend: !groups.length});
  });
  // bands and lines are alike but for the colour of their group
  if (groups.length && levels.some(g => g.next)) traces.push(inLegend({name: 'band of each: 95 % of its recordings', fill: 'toself', fillcolor: 'rgba(120,132,145,.25)', line: {width: 0}}));
  if (groups.length && c.drift) traces.push(inLegend({name: 'line of each: the drift', line: {color: grey, width: 2}}));
  if (outside.length) traces.push(trace(outside, 'outliers', {size: 10, color: orange, symbol: 'diamond', line: {color: ink, width: 1}}, true));
  draw(parent, '', traces, {showlegend: true, xaxis: time, yaxis: axis(`coefficient of restitution<br>ε at ${speed(c.v_mps)}`)});
}

const groupColour = k => [blue, red, orange, green, grey, ink][k % 6];

/// ε of each group that has its own, and where one more recording of it is expected.
function drawOfGroups(parent, groups) {
  const bars = (name, color, width, interval) => ({
    x: groups.map(g => g.name), y: groups.map(g => g.eps.value), type: 'scatter', mode: 'markers', name, bars: '95 %', marker: {size: 8, color},
    error_y: {type: 'data', symmetric: false, array: groups.map(g => interval(g) ? interval(g)[1] - g.eps.value : null), arrayminus: groups.map(g => interval(g) ? g.eps.value - interval(g)[0] : null), thickness: width, width: 4, color},
    hovertemplate: '%{x}<br>ε = %{y:.5f}<extra></extra>'});
  draw(parent, 'low', [...(groups.some(g => g.prediction95) ? [bars('one more recording', grey, 1.2, g => g.prediction95)] : []), bars('ε', blue, 2.4, g => g.eps.ci95)],
       {showlegend: true, xaxis: axis('plate or recording', {type: 'category'}), yaxis: axis(`coefficient of restitution<br>ε at ${speed(groups[0].v_mps)}`)});
}

function groupsSection(c) {
  const groups = ownGroups(c);
  if (!groups.length) return;
  const one = c.differences.unit === 'drops' ? 'drop' : 'recording';
  drawOfGroups(figure('groups', 'ε of each', `These differ, or are not known to agree: each has its own ε, by its ${one}s alone. Wide bars: where one more ${one} of it is expected to be measured, 95 %.`), groups);
  table('', ['plate or recording', one + 's', 'ε ± standard error', '95 %', `one more ${one}, 95 %`], groups.map(g => [g.name, number(g.n), measured(g.eps.value, g.eps.se), interval(g.eps.ci95), interval(g.prediction95)]),
        `ε at ${speed(groups[0].v_mps)}.`);
}

/// Mean offsets of plates or days from eps of all, of days where plates have their own from that.
function drawGroups(parent, grouping, isDay, reference) {
  const rows = grouping.rows, x = rows.map(r => r.name);
  const sd = grouping.deviation && grouping.deviation.value;
  const traces = [];
  if (sd > 0 && isDay) traces.push(straightBand(x[0], x.at(-1), -sd, sd, 0, 'rgba(31,95,168,.14)', '± standard deviation between days'));
  traces.push({x, y: rows.map(r => r.offset), type: 'scatter', mode: 'markers', name: isDay ? 'days' : 'plates', marker: {size: rows.length > 150 ? 4 : 8, color: blue},
               error_y: {type: 'data', array: rows.map(r => r.se), thickness: 1.2, width: rows.length > 40 ? 0 : 3, color: blue}, text: rows.map(r => number(r.n)),
               hovertemplate: '%{x}<br>%{y:.2e} off ' + reference + '<br>%{text} recordings<extra></extra>'});
  draw(parent, 'low', traces, {showlegend: false, xaxis: axis(isDay ? 'day' : 'plate', {type: isDay ? 'date' : 'category'}), yaxis: axis('offset from<br>' + reference, {exponentformat: 'power'}),
                               shapes: [{type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 0, y1: 0, line: {color: red, width: 1.4}}]});
}

/// eps against speed: of all with one more recording's band, or of each group.
function drawNodes(parent, c) {
  const line = (nodes, eps, name, color) => ({x: nodes.map(n => n.v_mps), y: nodes.map(n => eps(n).value), type: 'scatter', mode: 'lines+markers', name, line: {color, width: 2}, marker: {size: 6},
    error_y: {type: 'data', symmetric: false, array: nodes.map(n => eps(n).ci95[1] - eps(n).value), arrayminus: nodes.map(n => eps(n).value - eps(n).ci95[0]), thickness: 1.2, width: 3, color},
    hovertemplate: 'v = %{x:.3f} m/s<br>ε = %{y:.5f}<extra></extra>'});
  const groups = ownGroups(c), traces = groups.map((g, k) => line(g.nodes, n => ({value: n.eps, ci95: n.ci95}), g.name, groupColour(k)));
  if (!groups.length) {
    const wide = c.nodes.map(n => ({v_mps: n.v_mps, lo95: n.prediction95[0], hi95: n.prediction95[1]}));
    traces.push(band(wide, 'rgba(31,95,168,.14)', 'one more recording, 95 %'), line(c.nodes, n => n.eps, 'ε with its 95 % interval', red));
  }
  draw(parent, '', traces, {showlegend: true, xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('coefficient of restitution ε')});
}

/// Differences of eps at the nodes of every pair, as intervals about 0.
function drawDifferences(parent, d) {
  const colors = [blue, red, orange, grey, ink, blue];
  draw(parent, 'low', d.rows.map((row, k) => ({
    x: row.nodes.map(n => n.v_mps * (1 + 0.012 * k)), y: row.nodes.map(n => n.eps), type: 'scatter', mode: 'markers', name: `${row.group} less ${row.reference}`, bars: '95 %', marker: {size: 8, color: colors[k]},
    error_y: {type: 'data', symmetric: false, array: row.nodes.map(n => n.ci95[1] - n.eps), arrayminus: row.nodes.map(n => n.eps - n.ci95[0]), thickness: 1.4, width: 4, color: colors[k]},
    hovertemplate: 'at %{x:.2f} m/s<br>%{y:.2e}<extra></extra>'})),
       {showlegend: d.rows.length > 1, xaxis: axis('normal impact speed v (m/s)'), yaxis: axis('difference of ε', {exponentformat: 'power'}),
        shapes: [{type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 0, y1: 0, line: {color: red, width: 1.4}}]});
}

/// Two to four plates or recordings: by what they differ.
function differencesSection(d) {
  if (!d || !d.rows.length) return;
  const by = d.rows[0].ndf > 0 ? `Intervals include how ${d.unit} within a group differ (Student’s t).`
                               : 'How drops of one group differ is not known: there is one in each.';
  drawDifferences(figure('differences', `By what they differ: ${d.rows.map(r => `${r.group} less ${r.reference}`).join(', ')}`, 'Points: difference of ε at speeds that both reach, with 95 % intervals; on the line there is none. ' + by), d);
  const node = (name, v) => d.groups.find(g => g.name === name).nodes.find(n => n.v_mps === v);
  for (const row of d.rows)
    table(`${row.group} less ${row.reference}`, ['speed', row.reference, row.group, 'difference', '95 %'],
          row.nodes.map(n => [speed(n.v_mps), ...[row.reference, row.group].map(name => measured(node(name, n.v_mps).eps, node(name, n.v_mps).se)), measured(n.eps, n.se), interval(n.ci95)]),
          (known(row.p_value) ? `By chance alone so large a difference has p ${pIs(row.p_value)}. ` : '') + `A difference of ${significant(row.detectable)} at ${speed(row.v_mps)} shows in four of five such experiments.`);
}

function comparisonTables(c, points) {
  const sd = (name, s) => s ? [[name, significant(s.value), s.ci95.map(significant).join(' … ')]] : [];
  const test = (name, t) => t ? [[name, `χ²/ndf = ${number(t.chi2, 4)}/${number(t.ndf)}`, `p ${pIs(t.p_value)}`]] : [];
  table('ε of all at each speed', ['speed', 'recordings', 'ε ± standard error', '95 %', 'one more recording, 95 %'],
        (c.nodes || []).map(n => [speed(n.v_mps), number(n.n), measured(n.eps.value, n.eps.se), interval(n.eps.ci95), interval(n.prediction95)]),
        'Errors include what differs from recording to recording.');
  table('How much the recordings differ', ['', 'standard deviation of ε, or test', '95 %, or p'],
        [...sd('between recordings, τ', c.tau), ...sd('between plates', c.plates.deviation), ...sd('between days', c.days.deviation),
         ...test('do they differ at all?', c.heterogeneity),
         ...(c.drift ? [[`drift of ε a ${c.drift.per}`, `${significant(c.drift.slope.value)} ± ${significant(c.drift.slope.se)}`, `p ${pIs(c.drift.p_value)}`]] : [])]);
  const most = 50, order = points.eps.map((_, k) => k).sort((a, b) => Math.abs(points.standardised[b]) - Math.abs(points.standardised[a])).slice(0, most);
  const when = k => !known(points.time[k]) ? '–' : c.drift && c.drift.per === 'day' ? isoDay(points.time[k]) : number(points.time[k] + 1);
  table('Recordings, those furthest off first', ['recording', '', 'when', ...(points.plate.some(Boolean) ? ['plate'] : []), 'samples', 'ε', 'offset', 'sd off'],
        order.map(k => [points.recording[k] || '(no name)', points.outlier[k] ? 'outlier' : '', when(k), ...(points.plate.some(Boolean) ? [points.plate[k] || '–'] : []), number(points.n_samples[k]), measured(points.eps[k], points.se[k]),
                        significant(points.offset[k]), points.standardised[k].toFixed(2)]),
        `ε at ${speed(c.v_mps)} with the error of the recording alone; offset from ${ownGroups(c).length ? 'the mean ε' : 'ε of all'}; sd off: how many standard deviations it is off what the other recordings predict of it.` +
        (points.n > order.length ? ` The ${order.length} furthest off of ${number(points.n)}; all are in comparison.csv.` : ''));
  table('Recordings that could not be used', ['recording', 'samples', 'why'], c.not_used.slice(0, most).map(r => [r.recording || '(no name)', number(r.n), element('span', {class: 'words'}, r.message)]),
        c.not_used.length > most ? `The first ${most} of ${number(c.not_used.length)}; all are in comparison.csv.` : '');
}

function comparisonPage(c, points) {
  const section = add('section', {class: 'first', id: 'answer', 'aria-label': 'The answer'}), words = element('div', {class: 'says'});
  section.append(words);
  const [lead, ...rest] = c.answer;
  words.append(element('p', {class: 'lead'}, lead), ...rest.map(s => element('p', {}, s)));
  if (c.status === 'ok') {
    words.append(element('p', {class: 'caption'}, 'ε (epsilon), the coefficient of restitution: speed just after a bounce over speed just before it. ± is the standard error; it includes what differs from recording to recording. p: how often chance alone would make so large a difference.'));
    const thinned = points.n > points.eps.length ? ` ${number(points.eps.length)} of ${number(points.n)} recordings are drawn, all outliers among them.` : '';
    drawCampaign(figure('campaign', 'ε over the campaign', (ownGroups(c).length > 6 ? 'Points: recordings, with the standard error of each alone.' : ownGroups(c).length ? 'Points: recordings, with the standard error of each alone; bands: where 95 % of the recordings of each are expected. Lines: the drift, one for all, which the bands follow.' : 'Points: recordings, with the standard error of each alone. Dark band: pooled ε and the standard deviation between recordings, τ; light band: where 95 % of recordings are expected. Line: the drift, which both bands follow; plates are not taken out.') + thinned, section), c, points);
  }
  if (c.notes.length) {
    add('h2', {id: 'notes'}, 'What to know before using it');
    add('div', {class: 'warnings'}, element('ul', {}, c.notes.map(note => element('li', {}, note.text))));
  }
  groupsSection(c);
  differencesSection(c.differences);
  if (c.status !== 'ok') return comparisonTables({...c, heterogeneity: null, tau: null}, points);
  const ofAll = ownGroups(c).length ? 'ε of its plate' : 'ε of all';
  if (c.plates.rows.length > 1 && !ownGroups(c).length)
    drawGroups(figure('plates', 'By plate', 'Mean offset of each plate’s recordings from ε of all, with its standard error; drift taken out.'), c.plates, false, 'ε of all');
  if (c.days.rows.length > 1)
    drawGroups(figure('days', 'By day', `Mean offset of each day’s recordings from ${ofAll}, with its standard error; plates taken out, drift not.`), c.days, true, ofAll);
  if (ownGroups(c).some(g => g.nodes.length > 1) || (c.nodes || []).length > 1)
    drawNodes(figure('speeds', 'ε against impact speed', (ownGroups(c).length ? 'Points: ε of each' : 'Points: ε of all; band: where one more recording is expected, 95 %. Bars') + (ownGroups(c).length ? ' with its 95 % interval.' : ': 95 % intervals.')), c);
  comparisonTables(c, points);
}
