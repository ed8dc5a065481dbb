// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of the recording.


/// The whole recording as an envelope, with what was found.
function drawWave(parent) {
  const e = wave.envelope;
  const traces = [
    {x: e.t_s, y: e.lo, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, hoverinfo: 'skip', showlegend: false},
    {x: e.t_s, y: e.hi, mode: 'lines', type: 'scatter', line: {width: 0.6, color: grey}, fill: 'tonexty', fillcolor: 'rgba(120,132,145,.45)',
     name: 'sound', hoverinfo: 'skip'},
  ];
  const level = 1.08 * Math.max(...e.hi.map(Math.abs), ...e.lo.map(Math.abs), 1e-12);
  const plain = wave.marks.filter(m => !m.flags), said = wave.marks.filter(m => m.flags);
  const marks = (list, color, name) => ({
    x: list.map(m => m.t_s), y: list.map(() => level), mode: 'markers', type: 'scatter', name,
    marker: {symbol: 'line-ns', size: 9, line: {width: 1.2, color}}, text: list.map(m => `drop ${m.drop}, impact ${m.impact}${m.flags ? ', ' + m.flags : ''}`),
    hovertemplate: '%{x:.6f} s<br>%{text}<extra></extra>'});
  traces.push(marks(plain, red, 'impacts found'));
  if (said.length) traces.push(marks(said, orange, 'with a flag'));
  draw(parent, 'low', traces, {xaxis: axis('time (s)'), yaxis: axis('amplitude (full scale = 1)', {range: [-level * 1.02, level * 1.12]})});
}

/// The sound around one impact; time counts from where it was found.
function drawExcerpt(parent, excerpt) {
  const origin = excerpt.marks.length ? excerpt.marks[0].t_s : excerpt.t0_s;
  const ms = excerpt.samples.map((_, k) => 1e3 * (excerpt.t0_s + k * excerpt.dt_s - origin));
  const top = 1.05 * Math.max(...excerpt.samples.map(Math.abs), 1e-12);
  const shapes = [];
  for (const mark of excerpt.marks) {
    const t = 1e3 * (mark.t_s - origin), s = known(mark.sigma_t_s) ? 1e3 * mark.sigma_t_s : 0;
    shapes.push({type: 'line', x0: t, x1: t, y0: -top, y1: top, line: {color: red, width: 1.3}});
    if (s > 0) shapes.push({type: 'rect', x0: t - s, x1: t + s, y0: -top, y1: top, fillcolor: red, opacity: 0.18, line: {width: 0}});
  }
  const first = excerpt.marks[0];
  const title = excerpt.title + (first ? `, t = ${first.t_s.toFixed(6)} s` + (known(first.sigma_t_s) ? ` ± ${number(1e6 * first.sigma_t_s, 2)} µs` : '') : '');
  draw(parent, 'small', [{x: ms, y: excerpt.samples, mode: 'lines', type: 'scatter', name: 'sound', line: {color: ink, width: 1}, hovertemplate: '%{x:.4f} ms<extra></extra>'}],
       {shapes, showlegend: false, margin: {l: 56, r: 8, t: 30, b: 42}, title: {text: title, font: {size: 13}, x: 0.5, y: 0.97},
        xaxis: axis('time after the impact found (ms)', {nticks: 6}), yaxis: axis('amplitude (full scale = 1)', {range: [-top, top], nticks: 5})});
}

/// The recording as it sounds, where the report carries it: all of it, and each impact alone.
function drawPlayer(parent) {
  const sound = wave.sound;
  if (!sound) return;
  const text = atob(sound.wav_base64), bytes = Uint8Array.from(text, c => c.charCodeAt(0));
  const player = element('audio', {controls: '', preload: 'none', src: URL.createObjectURL(new Blob([bytes], {type: 'audio/wav'})), 'aria-label': `Sound from ${number(sound.t0_s, 3)} s on`});
  parent.append(player);
  if (sound.t0_s > 0.05) parent.append(element('p', {class: 'caption'}, `The player begins ${sound.t0_s.toFixed(2)} s after the recording does.`));
  const within = wave.marks.filter(m => m.t_s >= sound.t0_s && m.t_s < sound.t0_s + sound.duration_s), most = 300;
  let context, decoded, playing;
  const play = async mark => {
    context ??= new AudioContext();
    decoded ??= await context.decodeAudioData(bytes.slice().buffer);
    if (playing) playing.stop();
    player.pause();
    playing = context.createBufferSource();
    playing.buffer = decoded;
    playing.connect(context.destination);
    const begin = Math.max(0, mark.t_s - sound.t0_s - 0.05);
    playing.start(0, begin, 0.2);
  };
  const button = mark => {
    const b = element('button', {type: 'button', class: 'play', title: `drop ${mark.drop}, impact ${mark.impact}, ${mark.t_s.toFixed(4)} s`, 'aria-label': `Play impact ${mark.impact} of drop ${mark.drop}, at ${mark.t_s.toFixed(3)} seconds`}, String(mark.impact));
    b.addEventListener('click', () => play(mark));
    return b;
  };
  const byDrop = new Map();
  for (const mark of within.slice(0, most)) byDrop.set(mark.drop, [...(byDrop.get(mark.drop) || []), mark]);
  const rows = [...byDrop].map(([drop, marks]) => element('div', {class: 'impacts', role: 'group', 'aria-label': `Impacts of drop ${drop}`},
      element('span', {}, byDrop.size > 1 ? `drop ${drop}: ` : ''), marks.map(button)));
  parent.append(element('details', {class: 'listen', ...(within.length <= 60 ? {open: ''} : {})},
      element('summary', {}, 'Play one impact, 0.2 s around it' + (within.length > most ? ` (the first ${most} of ${within.length})` : '')), rows));
}

function drawSound() {
  const parent = figure('sound', 'The sound and the impacts found in it', `${shownName(wave.recording || '')}, ${number(wave.rate_hz)} Hz, channel ${wave.channel}` +
                        (recordingPaths.length > 1 ? `, the first of ${recordingPaths.length} recordings` : '') + '. Grey: the sound, its extremes; marks on top: impacts.');
  drawWave(parent);
  drawPlayer(parent);
}

function excerptsSection() {
  const grid = figure('excerpts', 'Some impacts at full resolution', 'Time found (line) and its standard error (band).');
  grid.classList.add('grid');
  for (const excerpt of wave.excerpts || []) drawExcerpt(grid, excerpt);
}
