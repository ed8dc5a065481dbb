// SPDX-License-Identifier: GPL-3.0-or-later
// The page as a site: size, accessibility, phone, offline, and what the bars ask for, as printed figures.
import assert from 'node:assert/strict';
import {after, before, describe, test} from 'node:test';
import {cpSync, readFileSync, readdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {gzipSync} from 'node:zlib';
import {analyzed, answered, clean, countOf, fromClean, launch, missing, openPage, ready, refitted, root, serve, site, truth, work} from './harness.js';

const axe = join(root, 'tools/web/node_modules/axe-core/axe.min.js');

describe('the site', {skip: missing ?? false}, () => {
  let browser, server;
  before(async () => {
    server = await serve(site);
    browser = await launch();
  });
  after(async () => {
    await browser?.close();
    await server?.close();
  });

  // tools/web/README.md says what takes how much
  test('everything together has at most 2 MB compressed', t => {
    const sizes = readdirSync(site).filter(name => !name.endsWith('.map')).map(name => [name, gzipSync(readFileSync(join(site, name)), {level: 9}).length]);
    const total = sizes.reduce((sum, [, n]) => sum + n, 0);
    t.diagnostic(`compressed: ${(total / 1e6).toFixed(3)} MB (bar 2); ${sizes.sort((a, b) => b[1] - a[1]).slice(0, 4).map(([name, n]) => `${name} ${(n / 1e3).toFixed(0)} kB`).join(', ')}`);
    assert.ok(total <= 2e6, `${total}`);
  });

  for (const [width, scheme] of [[360, 'dark'], [1280, 'light']]) {
    test(`axe-core finds nothing and nothing is wider than the window at ${width} px, ${scheme}`, async () => {
      const page = await openPage(browser, server.url, {width, height: 740});
      await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
      await ready(page);
      const check = async state => {
        if (process.env.BOUNCELAB_SCREENSHOTS) await page.screenshot({path: join(process.env.BOUNCELAB_SCREENSHOTS, `${state.replaceAll(' ', '-')}-${width}-${scheme}.png`), fullPage: true});
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${state}: wider than the window`);
        // axe is read as a file of the test: the page's policy lets no other script in
        await page.evaluate(readFileSync(axe, 'utf8'));
        const found = await page.evaluate(async () => (await window.axe.run(document)).violations.map(v => `${v.id}: ${v.nodes.length} times, first ${v.nodes[0].html.slice(0, 200)}`));
        assert.deepEqual(found, [], state);
      };
      await check('begin');
      await page.click('#typed summary');
      await check('numbers');
      await page.type('#numbers', '1, .81, .66, .53');
      await page.select('#numbers-unit', 'm');
      await answered(page, () => page.click('#numbers-run'));
      await check('heights');
      await page.click('#typed summary');
      const fold = await page.$('#settings summary');
      await fold.click();
      await page.click('#way-microphone');
      await check('microphone');
      await page.click('#way-simulate');
      await check('simulate');
      await page.click('#way-simulate');
      await page.click('#settings summary');
      await analyzed(page, clean);
      await check('result');
      const tables = {question: 'Nr;Fall;Zeit (ms);Stoppuhr (s)\n1;1;412,3;1,41\n2;1;1003,8;2,01\n3;1;1522,5;2,52\n',
                      'question of units': '0.6123\n0.5531\n0.4987\n0.4502\n0.4066\n'};
      for (const [state, text] of Object.entries(tables)) {
        const file = join(work, 'table.csv');
        writeFileSync(file, text);
        await page.$eval('#question', node => node.replaceChildren());  // which is waited for
        await (await page.$('#file')).uploadFile(file);
        await page.waitForSelector('#question button');
        await check(state);
      }
      await page.click('#way-simulate');
      await page.click('#simulate-run');
      await page.waitForSelector('#scatter-plots .truth', {timeout: 60000});
      await check('simulated');
      await page.close();
    });
  }

  test('the whole page is used by keyboard', async () => {
    const page = await openPage(browser, server.url);
    await ready(page);
    await analyzed(page, clean);
    const reached = new Set();
    for (let k = 0; k < 60; ++k) {
      await page.keyboard.press('Tab');
      reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.dataset.file || document.activeElement.tagName));
    }
    for (const id of ['way-file', 'way-microphone', 'way-simulate', 'detail', 'play-all', 'mark-add', 'report.html', 'labels.txt']) assert.ok(reached.has(id), `${id} of ${[...reached]}`);
    await page.close();
  });

  test('after the first visit it works without a connection', async () => {
    const own = await serve(site), page = await openPage(browser, own.url);
    await ready(page);
    await page.evaluate(async () => { await navigator.serviceWorker.ready; });
    await analyzed(page, clean);
    const answer = () => page.$eval('#answer', node => node.textContent), before = await answer();
    await own.close();  // from here on nobody answers
    await page.reload();
    await ready(page);
    await analyzed(page, clean);
    assert.equal(await countOf(page), truth.length);
    assert.equal(await answer(), before);
    await page.close();
  });

  test('a new version comes whole, when no page of the old one is open any more', async () => {
    const folder = join(work, 'site'), own = (cpSync(site, folder, {recursive: true}), await serve(folder));
    const visited = async () => {
      const page = await openPage(browser, own.url);
      await page.evaluate(async () => { await navigator.serviceWorker.ready; });
      await ready(page);
      return page;
    };
    const change = (name, from, to) => writeFileSync(join(folder, name), readFileSync(join(folder, name), 'utf8').replace(from, to));
    /// Which versions a page consists of: of its text, of a script of the worker, of what is kept.
    const versions = page => page.evaluate(async () => [document.title, /changed/.test(await (await fetch('sound.js')).text()), await caches.keys()]);
    const old = await visited(), [title, , [cache]] = await versions(old);
    change('index.html', /<title>.*<\/title>/, '<title>changed</title>');
    change('sound.js', /$/, '/* changed */');
    change('service_worker.js', cache.replace('bouncelab-', ''), 'changed');
    await old.evaluate(async () => {
      const registration = await navigator.serviceWorker.ready, isWaiting = () => registration.waiting;
      await registration.update();
      while (!isWaiting()) await new Promise(done => setTimeout(done, 50));
    });
    await old.reload();
    assert.deepEqual((await versions(old)).slice(0, 2), [title, false]);
    await old.close();
    let now = await visited();
    for (let k = 0; k < 20 && await now.title() !== 'changed'; ++k) {  // the browser hands over a moment after the old page is gone
      await now.close();
      now = await visited();
    }
    assert.deepEqual(await versions(now), ['changed', true, ['bouncelab-changed']]);
    await now.close();
    await own.close();
  });

  test('the policy lets in no script but the page\'s own', async () => {
    const page = await openPage(browser, server.url);
    const ran = await page.evaluate(() => {
      const inline = document.createElement('script');
      inline.textContent = 'window.ran = "inline"';
      document.head.append(inline);
      return window.ran ?? null;
    });
    assert.equal(ran, null);
    assert.ok(page.errors.some(text => /Content Security Policy/.test(text)), `${page.errors}`);
    await page.close();
  });

  test('the page can be installed, with all of its files kept', async () => {
    const page = await openPage(browser, server.url), session = await page.createCDPSession();
    await ready(page);
    const {errors, data} = await session.send('Page.getAppManifest'), {installabilityErrors} = await session.send('Page.getInstallabilityErrors');
    assert.deepEqual([errors, installabilityErrors.map(e => e.errorId).filter(id => id !== 'in-incognito')], [[], []]);
    assert.equal(JSON.parse(data).display, 'standalone');
    await page.close();
    const worker = readFileSync(join(site, 'service_worker.js'), 'utf8'), kept = /kFiles ?= ?\[(.*?)\]/.exec(worker)[1].split(',').map(f => f.trim().slice(1, -1));
    assert.deepEqual(kept.filter(f => f !== './').sort(), readdirSync(site).filter(f => f !== 'service_worker.js' && !f.endsWith('.map')).sort());
    assert.ok(!worker.includes('@VERSION@'));
  });

  test('the figures of the bars, and the page is not blocked by the computation', async t => {
    const page = await openPage(browser, server.url);
    await ready(page);
    const paint = await page.evaluate(() => performance.getEntriesByType('paint').find(e => e.name === 'first-contentful-paint')?.startTime);
    t.diagnostic(`first paint ${Math.round(paint)} ms (bar 1000)`);
    const timed = async (name, file, bar) => {
      const begin = performance.now();
      await analyzed(page, file);
      const all = (performance.now() - begin) / 1e3, computed = await page.evaluate(() => window.seen.results.at(-1).seconds);
      t.diagnostic(`${name}: answer after ${all.toFixed(2)} s, of which ${computed.toFixed(2)} s analysis (bar ${bar} s)`);
      return computed;
    };
    const cd = fromClean('cd.wav', '-ar', '44100'), minute = fromClean('minute.flac', '-af', 'apad', '-t', '60');
    await new Promise(done => setTimeout(done, 3000));  // the page is open before somebody chooses a file
    let longest = await timed('12 s at 48 kHz, the first', clean, 1);
    if (cd) longest = Math.max(longest, await timed('12 s at 44.1 kHz', cd, 1));
    if (minute) longest = Math.max(longest, await timed('a minute at 48 kHz', minute, 3));
    const begin = performance.now();
    await refitted(page, () => page.click('#mark-delete'));
    t.diagnostic(`a mark deleted and fitted again: ${((performance.now() - begin) / 1e3).toFixed(2)} s`);
    const tasks = await page.evaluate(() => window.longTasks), worst = Math.max(0, ...tasks);
    t.diagnostic(`tasks of the page over 50 ms: ${tasks.join(', ') || 'none'} ms (bar 100)`);
    // as a ratio, which a busy machine leaves alone: were any part of the analysis on the page, it would be near 1
    assert.ok(worst / 1e3 < longest / 3, `${worst} ms of ${longest} s`);
    await page.close();
  });
});
