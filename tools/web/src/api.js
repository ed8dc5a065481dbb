// SPDX-License-Identifier: GPL-3.0-or-later
// Put behind Emscripten's code: the module's functions, which throw an Error with the message of the C++ exception and, of a table
// that may be read in several ways, the `question`.
for (const name of ['version', 'balls', 'readSound', 'detect', 'analyze', 'analyzeOnsets', 'holdsTimes', 'analyzeTimes', 'file', 'simulate', 'scatter', 'wav']) {
  Module[name] = (...values) => {
    const answer = Module['bound_' + name](...values);
    if (answer.error !== undefined) throw Object.assign(new Error(answer.error), {question: answer.question});
    return answer.result;
  };
}
/// The report with its plotting library, the site's plotly.js: one file that needs nothing else. Names in it are
/// escaped, so that the mark stands once.
Module.withPlotly = (reportHtml, plotly) => reportHtml.replace('<script>@PLOTLY@</script>', () => `<script>${plotly}</script>`);
