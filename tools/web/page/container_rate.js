// SPDX-License-Identifier: GPL-3.0-or-later
// What a file says of its sound: container, sampling rate, coding, whether it has sound at all. Browsers decode to a rate
// that the page has to name beforehand, so that it reads the file's own here, and do not say what they decoded. Only the
// header is read.

const ascii = (view, at, text) => at + text.length <= view.byteLength && [...text].every((c, k) => view.getUint8(at + k) === c.charCodeAt(0));
const unknown = {container: '', rate_hz: null, hasSound: null, lossy: ''};

/// Codings that lose nothing, or steps of the amplitude only, which moves no impact (G.711, ADPCM), as MPEG-4, QuickTime
/// and Matroska write them; and names of others (mp4a may be MP3 too, which hardly anyone writes).
const kLossless = /^(alac|fLaC|lpcm|ipcm|fpcm|sowt|twos|raw |NONE|in24|in32|fl32|fl64|ulaw|alaw|ima4|PCM\/.*|FLAC|ALAC|TTA1|WAVPACK4|MLP|TRUEHD)$/;
const kNames = [[/^mp4a$|^AAC/, 'AAC'], [/^\.mp3$|^MPEG\/L3$/, 'MP3'], [/^opus$/i, 'Opus'], [/^VORBIS$/, 'Vorbis'], [/^samr$/, 'AMR-NB'], [/^sawb$/, 'AMR-WB']];
const lossyOf = coding => kLossless.test(coding) ? '' : kNames.find(([pattern]) => pattern.test(coding))?.[1] ?? coding.trim().toUpperCase();

/// @param bytes  the whole file
/// @returns {container, rate_hz: null where the header does not say, hasSound: null where it does not say,
///           lossy: name of the coding where that keeps what is heard, not the samples, else empty}
export function containerRate(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  try {
    if (['ftyp', 'moov', 'wide', 'mdat'].some(box => ascii(view, 4, box))) return mp4(view);
    if (view.byteLength >= 4 && view.getUint32(0) === 0x1a45dfa3) return webm(view);
    if (ascii(view, 0, 'OggS')) return ogg(view);
    return mpeg(view);
  } catch (error) {
    if (error instanceof RangeError) return unknown;  // cut off in its header: the browser will say
    throw error;
  }
}

/// WAV, RF64, W64 and FLAC: our own reader takes them, byte for byte.
export function isOurs(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return ['RIFF', 'RF64', 'RIFX', 'riff', 'fLaC'].some(magic => ascii(view, 0, magic));
}

/// MPEG-4 and QuickTime (ISO/IEC 14496-12): each track has a handler (hdlr) and, of sound, a sample description with its
/// rate as 16.16 and a time scale (mdhd), which is the rate where the description has none (over 65 kHz).
function mp4(view) {
  let rate = null, sound = false, lossy = null;
  const letters = at => String.fromCharCode(...[0, 1, 2, 3].map(k => view.getUint8(at + k)));
  const boxes = (begin, end, visit) => {
    for (let at = begin; at + 8 <= end;) {
      let size = view.getUint32(at), head = 8;
      if (size === 1) { size = Number(view.getBigUint64(at + 8)); head = 16; }
      if (size === 0) size = end - at;
      if (size < head) return;
      visit(letters(at + 4), at + head, Math.min(end, at + size));
      at += size;
    }
  };
  const track = (begin, end) => {
    let isSound = false, scale = null, described = null, coding = '';
    const inside = (name, from, to) => {
      if (['mdia', 'minf', 'stbl'].includes(name)) boxes(from, to, inside);
      if (name === 'hdlr') isSound ||= ascii(view, from + 8, 'soun');  // QuickTime has another one, of the data
      if (name === 'mdhd') scale = view.getUint32(from + (view.getUint8(from) === 1 ? 20 : 12));
      if (name === 'stsd' && to - from >= 44) {
        described = view.getUint32(from + 8 + 32) / 65536;
        coding = letters(from + 12);
      }
    };
    boxes(begin, end, inside);
    if (!isSound) return;
    sound = true;
    rate ??= described >= 3000 ? described : scale;
    lossy ??= lossyOf(coding);
  };
  let hasTracks = false;
  boxes(0, view.byteLength, (name, from, to) => {
    if (name === 'moov') boxes(from, to, (inner, a, b) => { if (inner === 'trak') { hasTracks = true; track(a, b); } });
  });
  return {container: 'MP4', rate_hz: rate, hasSound: hasTracks ? sound : null, lossy: lossy ?? ''};
}

/// Matroska and WebM (RFC 9559): Segment, Tracks, TrackEntry with its type (2: audio) and SamplingFrequency. Opus is
/// always decoded at 48 kHz (RFC 7845).
function webm(view) {
  let rate = null, sound = false, hasTracks = false, coding = null;
  const number = (at, keepsMarker) => {
    const first = view.getUint8(at), length = Math.clz32(first) - 23;
    let value = keepsMarker ? first : first & ((1 << (8 - length)) - 1), all = value === (1 << (8 - length)) - 1;
    for (let k = 1; k < length; ++k) { value = value * 256 + view.getUint8(at + k); all &&= view.getUint8(at + k) === 255; }
    return {value, length, open: all && !keepsMarker};
  };
  const visit = (begin, end) => {
    for (let at = begin; at + 2 <= end;) {
      const id = number(at, true), size = number(at + id.length, false), from = at + id.length + size.length;
      const to = size.open ? end : Math.min(end, from + size.value);
      if (id.value === 0x18538067 || id.value === 0x1654ae6b || id.value === 0xae || id.value === 0xe1) {  // Segment, Tracks, TrackEntry, Audio
        hasTracks ||= id.value === 0x1654ae6b;
        visit(from, to);
      }
      if (id.value === 0x83 && view.getUint8(from) === 2) sound = true;
      if (id.value === 0x86 && ascii(view, from, 'A_')) coding ??= String.fromCharCode(...new Uint8Array(view.buffer, view.byteOffset + from + 2, to - from - 2)).replace(/\0+$/, '');
      if (id.value === 0xb5) rate ??= to - from === 4 ? view.getFloat32(from) : view.getFloat64(from);
      if (id.value === 0x1f43b675) return;  // Cluster: the sound itself begins
      at = to;
    }
  };
  visit(0, view.byteLength);
  return {container: 'WebM', rate_hz: coding === 'OPUS' ? 48000 : rate, hasSound: hasTracks ? sound : null, lossy: lossyOf(coding ?? '')};
}

/// Ogg: the first packet of each stream names its codec (Vorbis I 4.2.2; RFC 7845 for Opus).
function ogg(view) {
  for (let at = 0; ascii(view, at, 'OggS');) {
    const segments = view.getUint8(at + 26), from = at + 27 + segments;
    if (ascii(view, from, '\x01vorbis')) return {container: 'Ogg Vorbis', rate_hz: view.getUint32(from + 12, true), hasSound: true, lossy: 'Vorbis'};
    if (ascii(view, from, 'OpusHead')) return {container: 'Ogg Opus', rate_hz: 48000, hasSound: true, lossy: 'Opus'};
    let size = 0;
    for (let k = 0; k < segments; ++k) size += view.getUint8(at + 27 + k);
    at = from + size;
  }
  return {container: 'Ogg', rate_hz: null, hasSound: null, lossy: ''};
}

/// MP3 and AAC in ADTS: the rate is in the header of each frame (ISO/IEC 11172-3, 2.4.1.3; 13818-7, 6.2), after an ID3 tag.
function mpeg(view) {
  let at = 0;
  if (ascii(view, 0, 'ID3')) at = 10 + [6, 7, 8, 9].reduce((size, k) => size * 128 + view.getUint8(k), 0);
  if (at + 4 > view.byteLength || view.getUint8(at) !== 0xff) return unknown;
  const second = view.getUint8(at + 1), third = view.getUint8(at + 2);
  if ((second & 0xf6) === 0xf0) {
    const rates = [96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350];
    return {container: 'AAC', rate_hz: rates[(third >> 2) & 15] ?? null, hasSound: true, lossy: 'AAC'};
  }
  if ((second & 0xe0) !== 0xe0) return unknown;
  const rate = [44100, 48000, 32000][(third >> 2) & 3], halved = {3: 1, 2: 2, 0: 4}[(second >> 3) & 3], layer = 4 - ((second >> 1) & 3);
  return rate && halved && layer < 4 ? {container: `MP${layer}`, rate_hz: rate / halved, hasSound: true, lossy: `MP${layer}`} : unknown;
}
