// SPDX-License-Identifier: GPL-3.0-or-later
// Put behind Emscripten's code: the module's functions, which throw an Error with the message of the C++ exception and, of a table
// that may be read in several ways, the `question`.
for (const name of ['version', 'balls', 'readSound', 'detect', 'analyze', 'analyzeOnsets', 'holdsTimes', 'analyzeTimes', 'file', 'simulate', 'scatter']) {
  Module[name] = (...values) => {
    const answer = Module['bound_' + name](...values);
    if (answer.error !== undefined) throw Object.assign(new Error(answer.error), {question: answer.question});
    return answer.result;
  };
}
/// The report with its plotting library, the site's plotly.js: one file that needs nothing else. Names in it are
/// escaped, so that the mark stands once.
Module.withPlotly = (reportHtml, plotly) => reportHtml.replace('<script>@PLOTLY@</script>', () => `<script>${plotly}</script>`);
/// The bytes of a WAV file of 32-bit floats: the samples as they are, interleaved.
Module.wav = (samples, rateHz, nChannels) => {
  if (!(Number.isInteger(rateHz) && rateHz >= 1 && rateHz < 2 ** 31)) throw new Error(`a sampling rate of ${rateHz} Hz is none of a recording`);
  if (!(nChannels >= 1 && samples.length % nChannels === 0)) throw new Error(`samples of ${nChannels} channels`);
  const bytes = new Uint8Array(44 + 4 * samples.length), head = new DataView(bytes.buffer);
  const text = (at, word) => bytes.set([...word].map(c => c.charCodeAt(0)), at);
  text(0, 'RIFF'); head.setUint32(4, bytes.length - 8, true); text(8, 'WAVEfmt '); head.setUint32(16, 16, true);
  head.setUint16(20, 3, true); head.setUint16(22, nChannels, true); head.setUint32(24, rateHz, true);
  head.setUint32(28, 4 * nChannels * rateHz, true); head.setUint16(32, 4 * nChannels, true); head.setUint16(34, 32, true);
  text(36, 'data'); head.setUint32(40, 4 * samples.length, true);
  bytes.set(new Uint8Array(Float32Array.from(samples).buffer), 44);
  return bytes;
};
