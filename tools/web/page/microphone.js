// SPDX-License-Identifier: GPL-3.0-or-later
// Recording: raw samples of the microphone, level, clipping, ε(v) as it comes, stop at rest.
import {drawPicture, paddedRange} from './picture.js';
import {Trouble, say} from './trouble.js';

const $ = id => document.getElementById(id);
const kLongest_s = 600;
/// What phones do to speech is wrong for impacts: it moves and weakens them.
const kChanges = {echoCancellation: 'echo cancellation', noiseSuppression: 'noise suppression', autoGainControl: 'automatic gain', voiceIsolation: 'voice isolation'};
const kUnchanged = Object.fromEntries(Object.keys(kChanges).map(name => [name, false]));
const kPlace = $('level-says').textContent;
const kBegin = 'Recording. Drop the ball.';

/// What a browser's refusal means.
function refusal(error) {
  const why = {
    NotAllowedError: 'The microphone was denied; allow it in the browser\'s settings of this page, or choose a recording.',
    SecurityError: 'The microphone is not allowed on this page; choose a recording.',
    NotFoundError: 'No microphone was found; choose a recording.',
    NotReadableError: 'The microphone is used by another program; close that, or choose a recording.',
  }[error.name];
  return why ? new Trouble(why) : error;
}

export class Microphone {
  /// @param engine  the worker; @param settings  gives options; @param begun, finished  are called before and after
  constructor(engine, settings, begun, finished) {
    Object.assign(this, {engine, settings, begun, finished, recording: false});
    $('record').addEventListener('click', () => (this.recording ? this.stop('') : this.start()).catch(error => this.fail(error)));
  }

  fail(error) {
    this.close();
    this.onTrouble(error);
  }

  async start() {
    if (!navigator.mediaDevices?.getUserMedia || !window.AudioWorkletNode)
      throw new Trouble('This browser gives the microphone only to pages opened by https; choose a recording.');
    this.recording = true;
    $('record').textContent = 'Stop';
    $('level').value = 0;
    $('record-time').textContent = '';
    try {
      this.stream = await navigator.mediaDevices.getUserMedia({audio: {...kUnchanged, channelCount: 1}});
    } catch (error) {
      throw refusal(error);
    }
    this.screen = await navigator.wakeLock?.request('screen').catch(() => null);  // a phone that falls asleep does not listen
    if (!this.recording) return this.close();
    this.begun();
    const {sampleRate, ...is} = this.stream.getAudioTracks()[0].getSettings(), changes = Object.keys(kChanges).filter(name => is[name]).map(name => kChanges[name]);
    this.warnings = changes.length ? [`The browser changes the sound of the microphone, though it was asked not to (${changes.join(', ')}): impacts may be lost; record by an app that leaves the sound as it is, and choose its file`] : [];
    $('level-says').textContent = changes.length ? `${this.warnings[0]}.` : kPlace;
    this.context = new AudioContext(sampleRate ? {sampleRate} : {});
    const context = this.context;
    await context.audioWorklet.addModule('level_worklet.js');
    if (context !== this.context) return;  // stopped meanwhile
    this.recorder = new AudioWorkletNode(this.context, 'recorder', {numberOfOutputs: 0, channelCount: 1, channelCountMode: 'explicit'});
    this.clipped = this.samples = 0;
    this.recorder.port.onmessage = ({data}) => this.take(data);
    this.engine.tell({task: 'live-begin', rate_hz: this.context.sampleRate, gravity_mps2: this.settings.options().gravity});
    this.engine.onLive = message => this.show(message);
    this.context.createMediaStreamSource(this.stream).connect(this.recorder);
    $('live-plot').replaceChildren();
    say(kBegin);
    this.seen = false;
  }

  take({samples, peak, clipped}) {
    if (!this.recording) return;
    this.samples += samples.length;
    this.clipped += clipped;
    const seconds = this.samples / this.context.sampleRate;
    // a meter in decibels, -60 to 0, as ears judge loudness
    $('level').value = Math.max(0, Math.min(1, 1 + 20 * Math.log10(Math.max(peak, 1e-9)) / 60));
    $('record-time').textContent = `${seconds.toFixed(1)} s`;
    $('level-says').textContent = this.clipped > 0 ? 'Too loud: the sound is cut off (clipped). Move the phone further from the ball.' :
        seconds > 3 && this.loudest() < 1e-4 ? 'The microphone gives hardly any sound; is it switched off?' : $('level-says').textContent;
    this.peak = Math.max(this.peak ?? 0, peak);
    this.engine.tell({task: 'live-more', samples}, [samples.buffer]);
    if (seconds > kLongest_s) this.stop('Ten minutes are recorded; that is the longest.');
  }
  loudest() { return this.peak ?? 0; }

  show({points, provisional, n_onsets, rest, marked, seconds, heard_s}) {
    if (!this.recording) return;
    document.dispatchEvent(new CustomEvent('bouncelab-live', {detail: {n_onsets, marked, n_provisional: provisional.n, seconds, heard_s}}));
    const known = n_onsets ? [`${n_onsets} ${n_onsets === 1 ? 'bounce' : 'bounces'} so far`] : [];
    const perhaps = provisional.n ? [`${provisional.n} sounds that may be bounces, drawn as open circles until the next ones decide`] : [];
    say(n_onsets || provisional.n ? `Recording: ${[...known, ...perhaps].join('; ')}.` : kBegin);
    const v = [...points.v, ...provisional.points.v], eps = [...points.eps, ...provisional.points.eps];
    if (v.length) {
      const newest = points.v.length ? [{kind: 'newest', x: [points.v.at(-1)], y: [points.eps.at(-1)]}] : [];
      drawPicture($('live-plot'), {
        height: 260, label: `Plot: ε against impact speed of ${points.v.length} bounces so far` + (provisional.points.v.length ? `, and of ${provisional.points.v.length} that may be some` : ''),
        x: {title: 'impact speed v (m/s)', range: [0, paddedRange(v)[1]]}, y: {title: 'ε', range: paddedRange(eps)},
        layers: [{kind: 'provisional', x: provisional.points.v, y: provisional.points.eps}, {kind: 'points', x: points.v, y: points.eps}, ...newest]});
    }
    if (!v.length) $('live-plot').replaceChildren();
    if (v.length && !this.seen) {
      this.seen = true;
      $('microphone').scrollIntoView({block: 'start'});  // on a phone the picture would be below the window
    }
    if (rest && $('stop-at-rest').checked) this.stop('The ball is at rest. ').catch(error => this.fail(error));
  }

  async stop(why) {
    if (!this.recording) return;
    const begun = Boolean(this.recorder);
    this.close();
    if (begun) await this.finished(why, this.warnings);
  }

  close() {
    this.recording = false;
    $('record').textContent = 'Start recording';
    $('level').value = 0;
    $('live-plot').replaceChildren();
    this.recorder?.disconnect();
    this.stream?.getTracks().forEach(track => track.stop());
    this.screen?.release();
    this.context?.close();
    this.recorder = this.stream = this.context = this.screen = null;
    this.peak = 0;
  }
}
