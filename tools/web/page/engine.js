// SPDX-License-Identifier: GPL-3.0-or-later
// The worker as the page sees it: tasks are promises; a worker that failed or was cancelled is replaced by a new one.
import {Trouble} from './trouble.js';

export class Engine {
  constructor() {
    this.waiting = new Map();
    this.next = 0;
    this.begin();
  }

  begin() {
    this.worker = new Worker('worker.js', {type: 'module'});
    this.worker.onmessage = ({data}) => this.take(data);
    this.worker.onerror = event => {
      event.preventDefault();
      this.restart('The part that computes could not be loaded; please load the page again.');
    };
    this.alive = false;
    this.ready = this.run({task: 'start'}).then(started => { this.alive = true; return started; });
    this.ready.catch(() => {});
  }

  take({id, result, error, fatal, live, seconds}) {
    if (live) return this.onLive?.(live);
    const task = this.waiting.get(id);
    this.waiting.delete(id);
    if (error !== undefined) {
      task?.reject(new Trouble(fatal ? `The computation stopped: ${error}. Please try a shorter piece of the sound.` : error));
      if (!task) this.onTrouble?.(new Trouble(error));
      if (fatal) this.restart('');
      return;
    }
    task?.resolve({...result, seconds});
  }

  /// A task with an answer.
  run(message, transfer = []) {
    return new Promise((resolve, reject) => {
      const id = this.next++;
      this.waiting.set(id, {resolve, reject});
      this.worker.postMessage({...message, id}, transfer);
    });
  }
  /// A message without one.
  tell(message, transfer = []) { this.worker.postMessage(message, transfer); }

  /// For good.
  stop() {
    this.alive = false;
    this.restart('');
  }

  restart(why) {
    this.worker.terminate();
    for (const task of this.waiting.values()) task.reject(new Trouble(why || 'Cancelled.'));
    this.waiting.clear();
    this.onRestart?.();
    if (this.alive) this.begin();  // one that never began would fail again
  }
}
