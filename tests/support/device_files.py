#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""One sound in files as phones, recorders, cameras, messengers and editors write them: with tags, other tracks, chunks.

    device_files.py SOUND.wav OUT_FOLDER     (SOUND.wav: mono, 16 bit, 48 kHz, some 4 s)

Prints a line for each file: FILE <tab> TWIN. The twin holds the same samples and nothing else: the plain WAV file where
the coding loses nothing, the same packets without tags, or what ffmpeg decodes of the file. Whatever reads sound has to
give the same answer for both. What this ffmpeg cannot encode is left out, and counted on standard error.
"""
import base64
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import wave

sys.dont_write_bytecode = True

from device_bytes import (  # noqa: E402
    RATE_HZ, adding, aiff, apac, ape, before, behind, bext, box, caf, caf_of_mp4, chunk, comments, cue_sheet,
    flac_blocks, id3, info, itunes, long_mdat, measured, picture, rotated, samsung_trailer, second_program_first, sound_last,
    unknown_lengths, w64, wav,
)

BARE = "-map_metadata -1 -fflags +bitexact"  # no tags, not even the name of the program
PICTURE = "-f lavfi -i testsrc=s=64x64:r=10:d=4"  # a video to go with the sound
MEMO = "-metadata title='New Recording' -metadata artist=Ann -metadata date=2024-05-11"
KEYS = "-map_metadata -1 -movflags use_metadata_tags"  # tags as Apple and Android write them: any key, in moov/meta/keys

# Each coding once, without tags: the twins, and what the files below are made from.
CODED = {
    "aac.m4a": "-c:a aac -b:a 128k",
    "alac.m4a": "-c:a alac",
    "flac.flac": "-c:a flac",
    "mp3.mp3": "-c:a libmp3lame -b:a 128k -write_id3v1 0 -id3v2_version 0",  # with a Xing header
    "no_xing.mp3": "-c:a libmp3lame -b:a 128k -write_id3v1 0 -id3v2_version 0 -write_xing 0",
    "opus.opus": "-c:a libopus -b:a 96k",
    "voip.ogg": "-ar 16000 -c:a libopus -application voip -frame_duration 60 -b:a 16k",
    "vorbis.ogg": "-c:a libvorbis -q:a 4",
    "ima.wav": "-c:a adpcm_ima_wav",
    "mp3.wav": "-c:a libmp3lame -b:a 128k",
}

# The files: name, twin, what it is made from (arguments of ffmpeg, a file, or bytes), changes of that
# twins: sound = the plain WAV; decoded = what ffmpeg decodes of the first track, decoded:1 of the next; one of CODED


def mp4_files(n_frames):
    aac, alac = "-i twins/aac.m4a", "-i twins/alac.m4a"
    video = f"{PICTURE} {aac} -map 0:v -map 1:a -c:v mpeg4 -c:a copy"
    texts = f"{PICTURE} -i parts/words.srt {aac} -map 0:v -map 1 -map 2:a -c:v mpeg4 -c:s mov_text -c:a copy"
    two = f"{PICTURE} {aac} -i parts/silence.m4a -c:v mpeg4 -c:a copy -metadata:s:a:0 language=deu -map 0:v"
    apple = (f"{KEYS} -metadata com.apple.quicktime.make=Apple -metadata com.apple.quicktime.model='iPhone 16 Pro' "
             "-metadata com.apple.quicktime.software=18.1 -metadata com.apple.quicktime.creationdate=2024-11-02T15:04:05 "
             "-metadata com.apple.quicktime.location.ISO6709=+48.1375+011.5755+519.000/")
    android = f"-brand mp42 {KEYS} -metadata com.android.version=14 -metadata com.android.capture.fps=30.0"
    samsung = box("smta", bytes(4), box("mdln", b"SM-S911B\0")), box("auth", b"\0\0\0\0\x15\xC7Galaxy S23\0")
    composer = struct.pack(">II11sIIH", 49, 11, b"WM/Composer", 1, 22, 8) + "Memo 12\0".encode("utf-16-le")
    program = box("data", struct.pack(">II", 1, 0), b"com.apple.VoiceMemos (iPhone Version 17.5.1 (Build 21F90))")
    memo = itunes("voice-memo-uuid", "6F5B2C1A-0D3E-4F71-8A9B-112233445566"), box("©too", program)
    gapless = itunes("iTunSMPB", f" 00000000 00000400 {-n_frames % 1024:08X} {n_frames:016X}" + " 00000000" * 8)
    told = box("tsrp", b'{"attributedString":["tap ",{"timeRange":[0.5,0.7]}]}')
    camera = box("uuid", bytes(range(16)), b"PROF" * 5), box("meta", bytes(4), box("xml ", bytes(4), b"<NonRealTimeMeta/>"))
    letters = "Recording of a ball that bounces on plate"
    titles = "日本語の録音", "Bällé à terre", "ball 🏀 table", "two\nlines", "e=0.9; h=1 m;", "a\\b#c\"d'", "\n"
    for n in range(41):
        yield f"title_{n:02}.m4a", "aac.m4a", f"{aac} -c copy -metadata title={shlex.quote(letters[:n])}"
    for n in range(1, 5):
        yield f"title_alac_{n}.m4a", "sound", f"{alac} -c copy -metadata title={shlex.quote(letters[:n])}"
    for n, title in enumerate(titles):
        yield f"title_odd_{n}.m4a", "aac.m4a", f"{aac} -c copy -metadata title={shlex.quote(title)}"
    yield from [
        ("untagged.m4a", "decoded", f"{aac} -c copy {BARE}"),  # the twin of many others, by another way
        ("long_comment.m4a", "aac.m4a", f"{aac} -i parts/long.txt -map 0 -map_metadata 1 -c copy"),
        ("all_tags.m4a", "aac.m4a", f"{aac} -c copy {MEMO} -metadata album=Lab -metadata track=3/7 -metadata genre=Speech -metadata comment=x"),
        ("voice_memo.m4a", "aac.m4a", f"{aac} -c copy {MEMO}", adding("moov/udta/meta/ilst", *memo, gapless), adding("moov/trak/udta", told)),
        ("voice_memo_lossless.m4a", "sound", f"{alac} -c copy {MEMO}", adding("moov/udta/meta/ilst", *memo)),
        ("iphone.mov", "aac.m4a", f"{video} {apple}", rotated, adding("moov/udta", box("©mak", b"\0\5\x15\xC7Apple"), bytes(4))),
        ("iphone_metadata_first.mov", "aac.m4a", f"{texts} {apple}", rotated, measured(b"mebx")),
        ("iphone_16.mov", "aac.m4a", f"{two} -map 1:a -map 2:a {apple}", rotated, apac(1)),
        ("iphone_apac_first.mov", "decoded:1", f"{two} -map 2:a -map 1:a {apple}", rotated, apac(0)),
        ("quicktime.mov", "sound", f"-i twins/sound.wav -c:a pcm_s24le {MEMO}"),
        ("android.m4a", "aac.m4a", f"{aac} -c copy -f mp4 {android}", long_mdat),
        ("android.mp4", "aac.m4a", f"{video} {android} -metadata location=+52.5-13.4/", rotated),
        ("android.3gp", "aac.m4a", f"{aac} -c copy -f 3gp {MEMO} -metadata album=Calls"),
        ("pixel.mp4", "aac.m4a", f"{texts} {android} {MEMO}", measured(b"mett")),
        ("samsung.mp4", "aac.m4a", video, adding("moov/udta", *samsung), behind(box("sefd", samsung_trailer()))),
        ("samsung_trailer.mp4", "aac.m4a", video, adding("moov/udta", *samsung), behind(samsung_trailer())),
        ("windows.m4a", "aac.m4a", f"{aac} -c copy {MEMO}", adding("moov/udta", box("Xtra", composer))),
        ("gopro.mp4", "aac.m4a", texts, measured(b"gpmd"), adding("moov/udta", box("FIRM", b"HD9.01.01.60.00"))),
        ("sony.mov", "sound", f"{PICTURE} -i twins/sound.wav -c:v mpeg4 -c:a pcm_s16be -brand XAVC", behind(*camera)),
        ("moov_first.m4a", "aac.m4a", f"{aac} -c copy -movflags +faststart {MEMO}"),
        ("moov_and_free_first.m4a", "aac.m4a", f"{aac} -c copy -moov_size 9000 {MEMO}"),
        ("long_mdat.mov", "aac.m4a", f"{video} {MEMO}", long_mdat),
        ("fragments.mp4", "decoded", f"{aac} -c copy -movflags frag_keyframe+empty_moov -frag_duration 500000 {MEMO}"),
        ("fragments_video.mp4", "decoded", f"{video} -g 10 -movflags frag_keyframe+empty_moov+default_base_moof {MEMO}"),
        ("dash.mp4", "decoded", f"{aac} -c copy -movflags dash+delay_moov -frag_duration 1000000 {MEMO}"),
        ("chapters.m4a", "aac.m4a", f"{aac} -i parts/chapters.txt -map 0 -map_metadata 1 -c copy"),
        ("cover.m4a", "aac.m4a", f"{aac} -i parts/cover.jpg -map 0 -map 1 -c copy -disposition:v attached_pic {MEMO}"),
        ("timecode_first.mov", "aac.m4a", f"{video} -timecode 01:02:03:04 {MEMO}", sound_last),
        ("subtitle_first.mp4", "aac.m4a", f"{texts} {MEMO} -metadata:s:s language=deu"),
        ("two_languages.mp4", "decoded", f"{two} -map 1:a -map 2:a {MEMO}"),
        ("two_languages_reverse.mp4", "decoded:1", f"{two} -map 2:a -map 1:a {MEMO}"),
        ("trimmed.m4a", "decoded", f"-ss 0.3 {aac} -c copy {MEMO}"),  # by an edit list
        ("delayed.mp4", "decoded", f"{PICTURE} -itsoffset 0.3 {aac} -map 0:v -map 1:a -c:v mpeg4 -c:a copy {MEMO}"),
        ("opus.mp4", "decoded", f"-i twins/opus.opus -c copy {MEMO}"),
        ("ios_aac.caf", "decoded", "twins/aac.m4a", caf_of_mp4),
        ("ios_alac.caf", "sound", f"{alac} -c copy {MEMO}"),
        ("recorder.aac", "decoded", f"{aac} -c copy -f adts", before(id3(("TIT2", b"\0odd")))),
    ]


def recorder_files(pcm):
    n = len(pcm) // 2
    numbers = struct.unpack(f"<{n}h", pcm)
    swapped, pcm24 = struct.pack(f">{n}h", *numbers), b"".join(b"\0" + pcm[k : k + 2] for k in range(0, 2 * n, 2))
    floats = struct.pack(f"<{n}f", *(x / 32768 for x in numbers))
    fmt = lambda tag=1, bits=16, more=b"": struct.pack("<HHIIHH", tag, 1, RATE_HZ, RATE_HZ * bits // 8, bits // 8, bits) + more
    extensible = struct.pack("<HHI", 22, 24, 4) + bytes.fromhex("0100000000001000800000AA00389B71")
    fmt16, fmt24, fmt_extensible = (chunk("fmt ", f) for f in (fmt(), fmt(1, 24), fmt(0xFFFE, 24, extensible)))
    fmt_float = chunk("fmt ", fmt(3, 32, bytes(2))) + chunk("fact", struct.pack("<I", n))
    data, data24, without_length = chunk("data", pcm), chunk("data", pcm24), b"data\xFF\xFF\xFF\xFF"
    ds64 = lambda size: chunk("ds64", struct.pack("<QQQI", size + 999, size, n, 0))
    history = b"A=PCM,F=48000,W=24,M=mono,T=ZOOM Handy Recorder H4n;VID;\r\n"
    ixml = lambda size: chunk("iXML", (b"<BWFXML><IXML_VERSION>1.5</IXML_VERSION></BWFXML>" + b" " * 4000)[:size])
    cue = lambda k: struct.pack("<II4sIII", k, k * RATE_HZ, b"data", 0, 0, k * RATE_HZ)
    labels = b"adtl" + chunk("labl", b"\1\0\0\0drop\0") + chunk("note", b"\2\0\0\0hi\0")
    cues = chunk("cue ", struct.pack("<I", 2) + cue(1) + cue(2)) + chunk("LIST", labels)
    editor = chunk("smpl", bytes(36)) + chunk("acid", bytes(24)) + chunk("afsp", b"AFspdate: 2024\0") + chunk("DGDA", bytes(5000))
    tag = id3(("TIT2", b"\1" + "Ball ü".encode("utf-16")), ("COMM", b"\0eng\0odd"))
    big = lambda name, content: chunk(name, content, ">")  # big endian, as all of AIFF
    comm = big("COMM", struct.pack(">hIhHQ", 1, n, 16, 0x400E, RATE_HZ << 48))  # the rate as an extended float
    comm_sowt = big("COMM", struct.pack(">hIhHQ4s2s", 1, n, 16, 0x400E, RATE_HZ << 48, b"sowt", b""))
    ssnd = lambda samples, offset=0: big("SSND", struct.pack(">II", offset, 0) + bytes(offset) + samples)
    marks = big("MARK", struct.pack(">HHI6s", 1, 1, RATE_HZ, b"\5start")) + big("INST", bytes(20))
    marks += big("COMT", struct.pack(">HIHH", 1, 3 * 10**9, 0, 5) + b"loud!\0")
    loop = big("basc", bytes(84)) + big("trns", bytes(86)) + big("cate", bytes(116)) + big("FLLR", bytes(401))
    texts = big("NAME", b"Ball") + big("ANNO", b"odd") + big("(c) ", b"x")
    desc = struct.pack(">d4s5I", RATE_HZ, b"lpcm", 2, 2, 1, 1, 16)
    facts = struct.pack(">I", 2) + b"title\0Ball\0encoder\0iOS 17\0"
    note = b"a ball that bounces\0\0"
    w64_chunks = w64(b"wave", b"")[:16] + w64(b"fmt ", fmt()) + w64(b"bext", bytes(603)) + w64(b"data", pcm)
    files = {
        "zoom_h4n.wav": wav(bext(history), fmt16, data),
        "zoom_odd.wav": wav(bext(history + b"x"), ixml(1001), fmt24, data24),
        "zoom_f3_float.wav": wav(bext(history), ixml(501), chunk("JUNK", bytes(3001)), fmt_float, chunk("data", floats)),
        "tascam.wav": wav(bext(b"A=PCM\r\n", b"TASCAM DR-40X"), fmt_extensible, chunk("PAD ", bytes(511)), data24, cues),
        "sound_devices.wav": wav(chunk("junk", bytes(28)), ixml(3333), fmt16, data, chunk("_PMX", b"<x:xmpmeta/>x")),
        "ios.wav": wav(chunk("JUNK", bytes(28)), fmt16, chunk("FLLR", bytes(4008)), data),  # samples from 4096 on
        "info_before.wav": wav(info(INAM="Ball", ISFT="Recorder 1", ICMT="long " * 30001), fmt16, data),
        "info_after.wav": wav(chunk("fmt ", fmt() + bytes(2)), data, info(IART="Ann", IENG="x"), chunk("id3 ", tag)),
        "id3_before.wav": wav(chunk("id3 ", tag + b"\0"), fmt24, data24, info(INAM="odd")),
        "editor.wav": wav(fmt16, chunk("minf", bytes(16)), chunk("elm1", bytes(213)), data, chunk("regn", bytes(92)), cues, editor),
        "rf64.wav": wav(ds64(3 * n), bext(history), fmt_extensible, without_length, pcm24 + b"\0", ixml(301), name=b"RF64", size=2**32 - 1),
        "bw64.wav": wav(ds64(2 * n), fmt16, chunk("chna", bytes(44)), without_length, pcm, chunk("axml", b"<a/>x"), name=b"BW64", size=2**32 - 1),
        "battery_0.wav": wav(bext(history), fmt16, b"data\0\0\0\0", pcm, size=0),
        "battery_ones.wav": wav(bext(history), fmt16, without_length, pcm, size=2**32 - 1),
        "battery_promise.wav": wav(fmt16, b"data" + struct.pack("<I", 4 * n), pcm, size=4 * n + 36),
        "garageband.aiff": aiff(b"AIFF", comm, marks, loop, ssnd(swapped), big("ID3 ", tag + b"\0")),
        "notes.aiff": aiff(b"AIFF", texts, comm, ssnd(swapped), big("APPL", b"stocx")),
        "offset.aiff": aiff(b"AIFF", comm, ssnd(swapped, 512)),
        "sowt.aifc": aiff(b"AIFC", big("FVER", b"\xA2\x80\x51\x40"), comm_sowt, big("CHAN", bytes(12)), ssnd(pcm), texts),
        "ios.caf": caf({"desc": desc, "chan": struct.pack(">III", 100 << 16 | 1, 0, 0), "info": facts, "free": bytes(3001), "data": bytes(4) + pcm}),
        "ios_unfinished.caf": caf({"desc": desc, "info": facts, "free": bytes(4001), "data": bytes(4) + pcm}, data=-1),
        "note.au": struct.pack(">4s5I", b".snd", 24 + len(note), 2 * n, 3, RATE_HZ, 1) + note + swapped,
        "recorder.w64": w64(b"riff", b"", len(w64_chunks)) + w64_chunks,
    }
    yield from ((name, "sound", content) for name, content in files.items())


def other_files(n_frames, jpeg):
    aac, plain, long = "-i twins/aac.m4a", "-i twins/sound.wav", "-i parts/long.txt -map 0 -map_metadata 1 -c copy"
    video = f"{PICTURE} {plain} -map 0:v -map 1:a"
    live = "-f webm -live 1 -cluster_time_limit 500"
    two = f"{PICTURE} {plain} -i parts/silence.m4a -map 0 -map 1 -map 2 -c:v mpeg2video -c:a mp2"
    frames = ("TIT2", b"\1" + "Ball 日本".encode("utf-16")), ("TPE1", b"\1" + "Ån".encode("utf-16")), ("APIC", b"\0image/jpeg\0\3\0" + jpeg)
    id3v1 = b"TAG" + struct.pack("30s30s30s4s30sB", b"Ball", b"Ann", b"", b"2024", b"", 12)
    block = base64.b64encode(picture(jpeg)).decode()
    tags = comments("TITLE=Ball 日本", "DESCRIPTION=" + "long " * 30000)
    yield from [
        ("tagged.mp3", "mp3.mp3", "twins/mp3.mp3", before(id3(*frames)), behind(ape(REPLAYGAIN_TRACK_GAIN="-3 dB"), id3v1)),
        ("padded.mp3", "mp3.mp3", "twins/mp3.mp3", before(id3(frames[0], padding=100000))),
        ("two_tags.mp3", "mp3.mp3", "twins/mp3.mp3", before(id3(*frames), id3(("TIT2", b"\0x"), padding=7)), behind(ape(Title="x"))),
        ("dictaphone.mp3", "no_xing.mp3", "twins/no_xing.mp3", before(id3(("TIT2", b"\0odd"), padding=1)), behind(id3v1)),
        ("dictaphone_ima.wav", "ima.wav", f"-i twins/ima.wav -c copy {MEMO}"),
        ("dictaphone_mp3.wav", "mp3.wav", f"-i twins/mp3.wav -c copy {MEMO}"),
        ("tagged.flac", "sound", "twins/flac.flac", flac_blocks((4, tags), (6, picture(jpeg)), (5, cue_sheet(n_frames)), (2, b"riffRIFF"))),
        ("padded.flac", "sound", "twins/flac.flac", flac_blocks((1, bytes(200001)), (4, comments()), (6, picture(jpeg)))),
        ("id3_before.flac", "sound", "twins/flac.flac", flac_blocks((4, comments("TITLE=x"))), before(id3(*frames))),
        ("flac.oga", "sound", f"-i twins/flac.flac -c copy {MEMO}"),
        ("tagged.wv", "sound", f"{plain} -c:a wavpack {MEMO}"),
        ("whatsapp.ogg", "voip.ogg", f"-i twins/voip.ogg -c copy {MEMO}"),
        ("telegram.oga", "voip.ogg", f"-i twins/voip.ogg {long}"),  # the tags go over several pages
        ("cover.opus", "opus.opus", f"-i twins/opus.opus -c copy {MEMO} -metadata METADATA_BLOCK_PICTURE={block}"),
        ("long_tags.opus", "opus.opus", f"-i twins/opus.opus {long}"),
        ("long_tags.ogg", "vorbis.ogg", f"-i twins/vorbis.ogg {long}"),
        ("from_a_stream.ogg", "vorbis.ogg", f"-i twins/vorbis.ogg -c copy -output_ts_offset 10 {MEMO}"),
        ("theora.ogv", "decoded", f"{video} -c:v libtheora -c:a libvorbis {MEMO}"),
        ("browser.webm", "decoded", f"-i twins/opus.opus -c copy {live}", unknown_lengths),
        ("browser_video.webm", "decoded", f"{PICTURE} -i twins/opus.opus -c:v libvpx -c:a copy {live}", unknown_lengths),
        ("subtitle_first.mkv", "sound", f"{PICTURE} -i parts/words.srt {plain} -map 1 -map 0 -map 2 -c:s srt -c:v mpeg4 -c:a flac {MEMO} "
                                        "-attach parts/cover.jpg -metadata:s:t mimetype=image/jpeg"),
        ("chapters.mkv", "decoded", f"{aac} -i parts/chapters.txt -map 0 -map_metadata 1 -c copy"),
        ("two_languages.mkv", "decoded:1", f"-i parts/silence.m4a {aac} -map 0 -map 1 -c copy {MEMO} -metadata:s:a:0 language=deu"),
        ("screen.mkv", "sound", f"{video} -c:v mpeg4 -c:a pcm_s16le {MEMO}"),
        ("camcorder.mts", "decoded", f"{video} -c:v libx264 -preset ultrafast -c:a ac3 -f mpegts -mpegts_m2ts_mode 1"),
        ("camcorder.ts", "decoded", f"{video} -c:v mpeg2video -c:a mp2 -metadata service_name=Ball"),
        ("phone.ts", "decoded", f"{aac} -c copy"),
        ("two_programs.ts", "decoded", f"{two} -program st=0:st=1 -program st=2"),
        ("programs_crossed.ts", "decoded:1", f"{two} -program st=0:st=1 -program st=2", second_program_first),
        ("dvd.mpg", "decoded", f"{video} -c:v mpeg2video -c:a mp2 -f vob"),
        ("camera.avi", "sound", f"{video} -c:v mjpeg -c:a pcm_s16le {MEMO} -metadata comment=odd"),
        ("aac.avi", "decoded", f"{PICTURE} {aac} -c:v mpeg4 -c:a copy {MEMO}"),
        ("mp3.avi", "decoded", f"{PICTURE} -i twins/mp3.mp3 -c:v mpeg4 -c:a copy {MEMO}"),
        ("stream.flv", "decoded", f"{PICTURE} {aac} -c:v flv -c:a copy {MEMO}"),
        ("memo.wma", "decoded", f"{plain} -c:a wmav2 -b:a 128k {MEMO}"),
        ("video.wmv", "decoded", f"{video} -c:v msmpeg4 -c:a wmav2 -b:a 128k {MEMO}"),
        ("camera.mxf", "decoded", f"{video} -r 25 -c:v mpeg2video -c:a pcm_s16le"),
        ("phone_nb.amr", "decoded", f"{plain} -ar 8000 -c:a libopencore_amrnb"),
        ("phone_wb.3gp", "decoded", f"{plain} -ar 16000 -c:a libvo_amrwbenc"),
    ]


# ---- making them


def ffmpeg(folder, arguments, name):
    words = ["ffmpeg", "-nostdin", "-v", "error", "-y", *shlex.split(arguments), name]
    if subprocess.run(words, cwd=folder, check=False).returncode != 0:
        sys.exit(f"{name}: ffmpeg failed: {arguments[:500]}")


def make(folder, name, twin, source, *changes):
    """@return the twin"""
    if isinstance(source, str) and source.startswith("-"):
        ffmpeg(folder, source, name)
        source = name
    content = source if isinstance(source, bytes) else (folder / source).read_bytes()
    for change in changes:
        content = change(content)
    (folder / name).write_bytes(content)
    if twin.startswith("decoded"):
        track = twin.partition(":")[2] or "0"
        twin = f"{name}.wav"
        ffmpeg(folder, f"-i {name} -map 0:a:{track} -c:a pcm_f32le {BARE}", f"twins/{twin}")
    return "twins/" + {"sound": "sound.wav"}.get(twin, twin)


def prepare(sound, folder):
    """The plain twin, and the parts that go into files besides the sound. @return the samples"""
    for part in ("twins", "parts"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    with wave.open(sound) as recording:
        if recording.getparams()[:3] != (1, 2, RATE_HZ):
            sys.exit(f"{sound}: not mono of 16 bit at {RATE_HZ} Hz")
        pcm = recording.readframes(recording.getnframes())
    if len(pcm) % 4 == 0:
        pcm = pcm[:-2]  # an odd number of samples: of 24 bit they need a byte of padding
    with wave.open(str(folder / "twins/sound.wav"), "wb") as recording:
        recording.setparams((1, 2, RATE_HZ, 0, "NONE", ""))
        recording.writeframes(pcm)
    chapter = "[CHAPTER]\nTIMEBASE=1/1000\nSTART={}\nEND={}\ntitle=Drop {}\n"
    (folder / "parts/chapters.txt").write_text(";FFMETADATA1\ntitle=odd\n" + chapter.format(0, 900, 1) + chapter.format(900, 2000, 2))
    (folder / "parts/long.txt").write_text(";FFMETADATA1\ntitle=Ball\ncomment=" + "long " * 30000 + "\n")
    (folder / "parts/words.srt").write_text("1\n00:00:00,100 --> 00:00:01,000\nHere it falls\n\n2\n00:00:01,500 --> 00:00:02,000\nDone\n")
    ffmpeg(folder, "-f lavfi -i testsrc=s=64x64 -frames:v 1 -q:v 1", "parts/cover.jpg")
    ffmpeg(folder, f"-f lavfi -i anullsrc=r={RATE_HZ}:cl=mono:d=4 -c:a aac", "parts/silence.m4a")
    return pcm


def main(sound, out):
    folder = pathlib.Path(out)
    pcm = prepare(sound, folder)
    listed = subprocess.run(["ffmpeg", "-v", "error", "-encoders"], capture_output=True, text=True, check=True).stdout
    known = {"copy", *re.findall(r"^ \S{6} (\w+)", listed, re.M)}
    lacking = lambda arguments: next((name for name in re.findall(r"-c:\w+ (\w+)", arguments) if name not in known), None)
    without = {name: lack for name, arguments in CODED.items() if (lack := lacking(arguments))}
    for name in CODED.keys() - without.keys():
        ffmpeg(folder, f"-i twins/sound.wav {BARE} {CODED[name]}", f"twins/{name}")
    left_out = {}
    for case in [*mp4_files(len(pcm) // 2), *recorder_files(pcm), *other_files(len(pcm) // 2, (folder / "parts/cover.jpg").read_bytes())]:
        words = " ".join(word for word in case[1:3] if isinstance(word, str))
        if lack := lacking(words) or next((lack for name, lack in without.items() if name in words), None):
            left_out.setdefault(lack, []).append(case[0])
        else:
            print(folder / case[0], folder / make(folder, *case), sep="\t", flush=True)
    for encoder, names in left_out.items():
        print(f"left out: {len(names)} without the encoder {encoder}: {', '.join(names)}", file=sys.stderr)


if __name__ == "__main__":
    main(*sys.argv[1:])
