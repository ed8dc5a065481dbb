// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the page for use without a connection. The version is a hash of all files, written by tools/web/assemble: when
// one of them changes, all are fetched anew, and what was kept before goes once no open page uses it.
const kVersion = '@VERSION@';
const kFiles = ['./', '@FILES@'];
const kCache = `bouncelab-${kVersion}`;

self.addEventListener('install', event => event.waitUntil(
    caches.open(kCache).then(cache => cache.addAll(kFiles.map(file => new Request(file, {cache: 'reload'}))))));

self.addEventListener('activate', event => event.waitUntil((async () => {
  for (const name of await caches.keys())
    if (name.startsWith('bouncelab-') && name !== kCache) await caches.delete(name);
  await self.clients.claim();
})()));

self.addEventListener('fetch', event => {
  const request = event.request, url = new URL(request.url);
  if (request.method !== 'GET' || url.origin !== self.location.origin) return;
  event.respondWith((async () => {
    const cache = await caches.open(kCache);
    return await cache.match(request, {ignoreSearch: true}) ?? await fetch(request);
  })());
});
