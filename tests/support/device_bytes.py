# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of sound files that ffmpeg does not write: boxes of MP4, chunks of WAV, AIFF, CAF and W64, tags, blocks of FLAC.

What changes a whole file is a function of its bytes, or makes one.
"""
import re
import struct

RATE_HZ = 48000

# ---- boxes of MP4 and QuickTime


def box(kind, *contents):
    return struct.pack(">I4s", 8 + sum(map(len, contents)), kind.encode("latin1")) + b"".join(contents)


def boxes(data):
    """Kind and content of each."""
    at = 0
    while at + 8 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        yield kind.decode("latin1"), data[at + 8 : at + size]
        at += size


def within(data, path, change):
    """The content changed of every box at the path, which is made where it is missing."""
    if not path:
        return change(data)
    kind, *rest = path
    found = list(boxes(data))
    if kind not in dict(found):
        found.append((kind, b""))
    head = 4 if kind == "meta" else 0  # version and flags
    return b"".join(box(k, c[:head] + within(c[head:], rest, change) if k == kind else c) for k, c in found)


def adding(path, *added):
    """Boxes at the end of others. The moov of the file has to lie behind its samples, which must not move."""
    return lambda data: within(data, path.split("/"), lambda content: content + b"".join(added))


def sound_last(data):
    """The tracks of sound behind all others."""
    is_sound = lambda b: b[0] == "trak" and re.search(rb"hdlr.{8}soun", b[1], re.S) is not None
    return within(data, ["moov"], lambda moov: b"".join(box(*b) for b in sorted(boxes(moov), key=is_sound)))


def rotated(data):
    """The video, of 64 by 64 dots, turned by 90 degrees: a phone held upright."""
    plain = struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
    turned = struct.pack(">9i", 0, 1 << 16, 0, -1 << 16, 0, 0, 64 << 16, 0, 1 << 30)
    size = struct.pack(">II", 64 << 16, 64 << 16)
    return data.replace(plain + size, turned + size)


def apac(number):
    """The track of that number among those of AAC gets a coding that ffmpeg does not know."""

    def change(moov):
        found = list(boxes(moov))
        at = [k for k, (_, content) in enumerate(found) if b"mp4a" in content][number]
        found[at] = ("trak", found[at][1].replace(b"mp4a", b"apac").replace(b"esds", b"dapa"))
        return b"".join(box(*b) for b in found)

    return lambda data: within(data, ["moov"], change)


def measured(coding):
    """The subtitles become a track of what the device measured."""

    def change(data):
        data = re.sub(rb"(hdlr.{8})(?:text|sbtl)", rb"\1meta", data, flags=re.S)
        return re.sub(rb"(stsd.{12})(?:text|tx3g)", rb"\1" + coding, data, flags=re.S)

    return change


def long_mdat(data):
    """The length of the samples in 64 bits, in the room that ffmpeg leaves for it."""
    long = lambda m: struct.pack(">I4sQ", 1, b"mdat", int.from_bytes(m[1], "big") + 8)
    return re.sub(rb"\0\0\0\x08(?:free|wide)(.{4})mdat", long, data, count=1, flags=re.S)


def itunes(name, text):
    value = struct.pack(">II", 1, 0) + text.encode()
    return box("----", box("mean", b"\0\0\0\0com.apple.iTunes"), box("name", bytes(4), name.encode()), box("data", value))


def samsung_trailer():
    part = struct.pack("<HHI", 0, 0x0A01, 14) + b"Image_UTC_Data1704067200000"
    index = b"SEFH" + struct.pack("<IIHHII", 106, 1, 0, 0x0A01, len(part), len(part))
    return part + index + struct.pack("<I", len(index)) + b"SEFT"


# ---- chunks of WAV, AIFF, CAF and W64; tags


def before(*heads):
    return lambda data: b"".join(heads) + data


def behind(*ends):
    return lambda data: data + b"".join(ends)


def chunk(name, content, order="<"):
    return name.encode() + struct.pack(order + "I", len(content)) + content + bytes(len(content) % 2)


def wav(*chunks, name=b"RIFF", size=None):
    content = b"WAVE" + b"".join(chunks)
    return name + struct.pack("<I", len(content) if size is None else size) + content


def aiff(kind, *chunks):
    content = kind + b"".join(chunks)
    return b"FORM" + struct.pack(">I", len(content)) + content


def caf(chunks, **sizes):
    return b"caff\0\1\0\0" + b"".join(n.encode() + struct.pack(">q", sizes.get(n, len(c))) + c for n, c in chunks.items())


def caf_of_mp4(data):
    """AAC as older iOS keeps it: its packets one after the other, and a table of their lengths."""
    content = lambda kind: re.search(rb"(.{4})%b(.*)" % kind, data, re.S)
    inside = lambda found: found[2][: int.from_bytes(found[1], "big") - 8]
    sizes = struct.unpack_from(f">{(len(inside(content(b'stsz'))) - 12) // 4}I", inside(content(b"stsz")), 12)
    table = b"".join(bytes([0x80 | s >> 7, s & 0x7F]) for s in sizes)
    desc = struct.pack(">d4s5I", RATE_HZ, b"aac ", 0, 0, 1024, 1, 0)
    return caf({"desc": desc, "info": struct.pack(">I", 1) + b"title\0Ball\0", "kuki": inside(content(b"esds")), "free": bytes(2001),
                "pakt": struct.pack(">qqii", len(sizes), 1024 * len(sizes), 0, 0) + table, "data": bytes(4) + dict(boxes(data))["mdat"]})


def w64(name, content, n_more=0):
    identifier = "2E91CF11A5D628DB04C10000" if name == b"riff" else "F3ACD3118CD100C04F8EDB8A"
    return name + bytes.fromhex(identifier) + struct.pack("<Q", 24 + len(content) + n_more) + content + bytes(-len(content) % 8)


def bext(history, originator=b"ZOOM Handy Recorder H4n"):
    when = (b"2024-05-11", b"14:23:36", 2285085600, 1, b"")
    return chunk("bext", struct.pack("<256s32s32s10s8sQH254s", b"Ball on plate", originator, b"JP00ZOOM0001", *when) + history)


def info(**tags):
    return chunk("LIST", b"INFO" + b"".join(chunk(k, v.encode() + b"\0") for k, v in tags.items()))


def id3(*frames, padding=0):
    """ID3v2.3"""
    content = b"".join(n.encode() + struct.pack(">IH", len(c), 0) + c for n, c in frames) + bytes(padding)
    return b"ID3\3\0\0" + bytes(len(content) >> shift & 0x7F for shift in (21, 14, 7, 0)) + content


def ape(**tags):
    """APEv2, as programs append it that even out the loudness."""
    items = b"".join(struct.pack("<II", len(v), 0) + k.encode() + b"\0" + v.encode() for k, v in tags.items())
    end = lambda flags: struct.pack("<8sIIIIQ", b"APETAGEX", 2000, len(items) + 32, len(tags), flags, 0)
    return end(0xA0000000) + items + end(0x80000000)


def comments(*tags):
    """A Vorbis comment: KEY=VALUE ..."""
    counted = lambda text: struct.pack("<I", len(text)) + text
    return counted(b"a device") + struct.pack("<I", len(tags)) + b"".join(counted(t.encode()) for t in tags)


def picture(jpeg):
    return struct.pack(">II", 3, 10) + b"image/jpeg" + struct.pack(">6I", 0, 64, 64, 24, 0, len(jpeg)) + jpeg


def cue_sheet(n_frames):
    index = struct.pack(">QB3s", 0, 1, b"")
    track = lambda at, number, n: struct.pack(">QB12sB13sB", at, number, b"", 0, b"", n) + n * index
    return struct.pack(">128sQB258sB", b"", 0, 0, b"", 3) + track(0, 1, 1) + track(RATE_HZ, 2, 1) + track(n_frames, 255, 0)


def flac_blocks(*added):
    """FLAC with these blocks of metadata: (type, content)."""

    def change(data):
        at, is_last = 4, False
        while not is_last:
            is_last, at = data[at] & 0x80, at + 4 + int.from_bytes(data[at + 1 : at + 4], "big")
        head = b"".join(bytes([k]) + len(c).to_bytes(3, "big") + c for k, c in added)
        return b"fLaC\0" + data[5:42] + head + b"\x81\0\0\0" + data[at:]  # what it is first, padding of 0 bytes last

    return change


def unknown_lengths(data):
    """WebM as a browser writes it while it records: clusters without a length."""
    length = rb"(?:\x01.{7}|[\x10-\x1F].{3}|[\x20-\x3F].{2}|[\x40-\x7F].)"
    return re.sub(rb"\x1F\x43\xB6\x75" + length, b"\x1F\x43\xB6\x75\x01" + b"\xFF" * 7, data, flags=re.S)


def second_program_first(data):
    """MPEG-TS whose first program is described later than the second: the streams are not numbered as programs list them."""
    pid = lambda at: struct.unpack_from(">H", data, at + 1)[0] & 0x1FFF
    at = next(at for at in range(0, len(data), 188) if pid(at) == 0x1000)
    return data[: at + 1] + b"\x1F\xFF" + data[at + 3 :]  # an empty packet
