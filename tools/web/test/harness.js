// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of the page share: the built site on a port, Chromium, sounds in other formats.
import {execFileSync} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import puppeteer from 'puppeteer-core';
import {serve} from './server.js';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../../..');
export const site = process.env.BOUNCELAB_SITE ?? join(root, 'build/web/site');
const chromium = process.env.CHROMIUM ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
export const missing = !chromium ? 'no chromium; tools/setup --all installs it' : !existsSync(join(site, 'bouncelab.wasm')) && !existsSync(join(site, 'bouncelab.js')) ? `no ${site}; tools/web/build makes it` : null;

export const work = mkdtempSync(join(tmpdir(), 'bouncelab-web-'));
export const clean = join(root, 'samples/clean.flac');
export const truth = readFileSync(join(root, 'samples/clean.truth.csv'), 'utf8').trim().split('\n').slice(1).map(line => {
  const cells = line.split(',');
  return {t_s: Number(cells[3]) + Number(cells[9])};  // when the sound reaches the sensor
});

/// A sound in another format by ffmpeg; null where there is no ffmpeg or it lacks the codec.
export function made(name, ...options) {
  const file = join(work, name);
  try {
    execFileSync('ffmpeg', ['-v', 'error', '-y', ...options, file], {stdio: ['ignore', 'ignore', 'pipe']});
    return file;
  } catch {
    return null;
  }
}
export const fromClean = (name, ...options) => made(name, '-i', clean, ...options);

export async function launch(...args) {
  return puppeteer.launch({executablePath: chromium, args: ['--no-sandbox', '--autoplay-policy=no-user-gesture-required', '--mute-audio', ...args]});
}

/// A page that notes what must not happen: requests to others, errors, long tasks.
/// @param phone  with a finger, three pixels for one, four times as slow
export async function openPage(browser, url, {width = 1280, height = 900, phone = false, before} = {}) {
  const page = await browser.newPage();
  await page.setViewport({width, height, ...(phone ? {deviceScaleFactor: 3, isMobile: true, hasTouch: true} : {})});
  if (phone) await page.emulateCPUThrottling(4);
  page.foreign = [];
  page.errors = [];
  page.on('request', request => {
    if (!request.url().startsWith(url) && !/^(data|blob):/.test(request.url())) page.foreign.push(request.url());
  });
  page.on('pageerror', error => page.errors.push(error.message));
  page.on('console', message => { if (message.type() === 'error') page.errors.push(message.text()); });
  await page.evaluateOnNewDocument(() => {
    window.longTasks = [];
    window.seen = {live: [], results: [], refits: 0};
    new PerformanceObserver(list => { for (const entry of list.getEntries()) window.longTasks.push(Math.round(entry.duration)); }).observe({type: 'longtask', buffered: true});
    document.addEventListener('bouncelab-live', event => window.seen.live.push({at: performance.now(), ...event.detail}));
    document.addEventListener('bouncelab-result', event => window.seen.results.push(event.detail));
    document.addEventListener('bouncelab-refit', () => ++window.seen.refits);
  });
  if (before) await page.evaluateOnNewDocument(before);
  await page.goto(url);
  return page;
}
export const ready = page => page.waitForFunction(() => document.getElementById('version').textContent !== 'bouncelab', {timeout: 60000});
export const statusOf = page => page.$eval('#status', node => node.textContent);

/// Does something, waits until the page answers with a result or a sentence of trouble, gives that sentence.
export async function answered(page, action) {
  const before = await page.evaluate(() => { document.getElementById('status').className = ''; return window.seen.results.length; });
  await action();
  await page.waitForFunction(n => window.seen.results.length > n || document.getElementById('status').className === 'trouble', {timeout: 120000}, before);
  return statusOf(page);
}
export const choose = (page, ...files) => answered(page, async () => (await page.$('#file')).uploadFile(...files));
/// The same, of a sound in which there is something to find.
export async function analyzed(page, ...files) {
  const says = await choose(page, ...files);
  if (await page.$eval('#status', node => node.className === 'trouble')) throw new Error(says);
  return says;
}

/// Changes marks, waits for the fit that follows.
export async function refitted(page, action) {
  const before = await page.evaluate(() => window.seen.refits);
  await action();
  await page.waitForFunction(n => window.seen.refits > n, {timeout: 60000}, before);
}
/// "3 of 95" below the sound.
export const countOf = page => page.$eval('#mark-says', node => Number(/of (\d+)$/.exec(node.textContent)?.[1] ?? 0));

export {serve};
