#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a campaign costs: processor time per hour of sound and per million impacts, the price of dividing a run into
shards, calls to the file system, bytes of parts; and what that predicts, beside a campaign on this machine.

    campaign_cost.py BOUNCELAB [--recordings 40] [--drops 12] [--rate 48000] [--shards 8] [--impacts 1000000] [--work DIR]

The recordings are synthesized (60 impacts a drop). Processor time is user and system time of the processes (wait4), with
--threads 1; plain run and shards take turns, and the least of --repeat runs counts. Calls are counted by strace, which
has to be installed. The prediction for this machine takes the cores as free.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import wave
from pathlib import Path

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("bouncelab")
parser.add_argument("--recordings", type=int, default=40)
parser.add_argument("--drops", type=int, default=12, help="of a recording")
parser.add_argument("--rate", type=int, default=48000)
parser.add_argument("--shards", type=int, default=8)
parser.add_argument("--impacts", type=int, default=1_000_000, help="of the table for restitution and compare")
parser.add_argument("--repeat", type=int, default=3)
parser.add_argument("--cores", type=int, default=os.cpu_count())
parser.add_argument("--work", type=Path, help="keeps the files there, and takes recordings that are there already")
arguments = parser.parse_args()
bouncelab = str(Path(arguments.bouncelab).resolve())


def run(*words, cwd, check=True):
    """@return processor time [s]"""
    process = subprocess.Popen([bouncelab, *map(str, words)], cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = process.stderr.read().decode(errors="replace")
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if check and process.returncode != 0:
        sys.exit(f"bouncelab {' '.join(map(str, words))}: exit code {process.returncode}: {message}")
    return usage.ru_utime + usage.ru_stime


def calls(*words, cwd):
    """@return calls by name and by descriptor, of the file system [-]"""
    counts = []
    for kind in "%file", "%desc":
        with tempfile.NamedTemporaryFile("r") as table:
            subprocess.run(["strace", "-f", "-c", "-U", "calls,name", "-e", f"trace={kind}", "-o", table.name, bouncelab,
                            *map(str, words)], cwd=cwd, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            total = re.search(r"^\s*(\d+)\s+total", table.read(), re.M)
            counts.append(int(total.group(1)) if total else 0)
    return counts


def made_recordings(folder):
    """@return length of all [s]"""
    folder.mkdir(exist_ok=True)
    for k in range(arguments.recordings):
        sound = folder / f"r{k:04}.wav"
        if sound.exists():
            continue
        run("simulate", "--drops", arguments.drops, "--impacts", 60, "--asperities", 100000, "--seed", k, "--out", "impacts.csv",
            "--force", cwd=folder)
        run("synthesize", "impacts.csv", "--rate", arguments.rate, "--snr-db", 30, "--seed", k, "--out", sound.name, cwd=folder)
    seconds = 0.0
    for sound in folder.glob("*.wav"):
        with wave.open(str(sound)) as opened:
            seconds += opened.getnframes() / opened.getframerate()
    return seconds


def size_of(folder, pattern):
    return sum(file.stat().st_size for file in folder.glob(pattern))


def main(work):
    sound_h = made_recordings(work / "sound") / 3600
    names = sorted(f"sound/{file.name}" for file in (work / "sound").glob("*.wav"))
    (work / "list.txt").write_text("".join(name + "\n" for name in names))
    print(f"{len(names)} recordings, {sound_h:.3f} h of sound at {arguments.rate} Hz; {arguments.shards} shards")

    common = ["--list", "list.txt", "--threads", 1]
    plain_s, shards_s, merge_s = [], [], []
    for _ in range(arguments.repeat):
        plain_s.append(run("detect", *common, "--out", "plain.h5", "--force", cwd=work))
        shutil.rmtree(work / "shards.h5.parts", ignore_errors=True)
        shards_s.append(sum(run("detect", *common, "--out", "shards.h5", "--shard", f"{k}/{arguments.shards}", cwd=work)
                            for k in range(1, arguments.shards + 1)))
        merge_s.append(run("merge", "shards.h5.parts", "--force", cwd=work))
    if (work / "plain.h5").read_bytes() != (work / "shards.h5").read_bytes():
        sys.exit("plain.h5 and shards.h5 differ")
    plain, shards, merge = min(plain_s), min(shards_s), min(merge_s)
    again = sum(run("detect", *common, "--out", "shards.h5", "--shard", f"{k}/{arguments.shards}", cwd=work)
                for k in range(1, arguments.shards + 1))
    n_impacts = arguments.recordings * arguments.drops * 60
    part_bytes = size_of(work / "shards.h5.parts", "*.part")
    print(f"detect in one piece     {plain:9.2f} s of a processor, {plain / sound_h:.1f} s per hour of sound")
    print(f"detect in shards        {shards:9.2f} s, merge {merge:.2f} s: {100 * ((shards + merge) / plain - 1):+.1f} %")
    print(f"complete shards again   {again:9.2f} s")
    print(f"parts                   {part_bytes:9} bytes, {part_bytes / n_impacts:.0f} an impact; the table {size_of(work, 'plain.h5')}")
    shutil.rmtree(work / "shards.h5.parts")
    first = ["detect", *common, "--out", "shards.h5", "--shard", f"1/{arguments.shards}"]
    by_name, by_descriptor = calls(*first, cwd=work)
    own = len(range(0, len(names), arguments.shards))
    print(f"a shard of {own} recordings: {by_name} calls with a path, {by_descriptor} with a descriptor")

    drops = arguments.impacts // 100
    if not (work / "impacts.h5").exists():
        run("simulate", "--drops", drops, "--impacts", 100, "--asperities", 1000000, "--threads", 1, "--out", "impacts.h5", cwd=work)
    million = arguments.impacts / 1e6
    simulate_s = run("simulate", "--drops", drops // 10, "--impacts", 100, "--asperities", 1000000, "--threads", 1, "--out", "some.h5",
                     "--force", cwd=work) * 10 / million
    restitution_s = run("restitution", "impacts.h5", "--out", "samples.h5", "--threads", 1, "--force", cwd=work) / million
    print(f"per million impacts     simulate {simulate_s:.1f} s, restitution {restitution_s:.2f} s")

    shutil.rmtree(work / "campaign", ignore_errors=True)
    (work / "campaign.toml").write_text(f'command = "detect"\nout = "campaign"\nlist = "list.txt"\n'
                                        f"[jobs]\nshards = {arguments.shards}\nmax-jobs = {arguments.cores}\n")
    begin = time.perf_counter()
    campaign_s = run("campaign", "campaign.toml", "--on", "local", cwd=work)
    measured = time.perf_counter() - begin
    own_s = restitution_s * n_impacts / 1e6
    print(f"campaign on {arguments.cores} cores: predicted {shards + merge + own_s:.1f} s of processors, measured {campaign_s:.1f} s; "
          f"predicted {shards / arguments.cores + merge + own_s:.1f} s on the clock, measured {measured:.1f} s (load {os.getloadavg()[0]:.1f})")

    hours, cores = 10_000, 1_000
    impacts = n_impacts / sound_h * hours
    print(f"predicted: {hours} h on {cores} cores: shards {shards / sound_h * hours / cores / 60:.0f} min, "
          f"{impacts:.1e} impacts, parts {part_bytes / n_impacts * impacts / 1e9:.1f} GB, "
          f"merge {merge / n_impacts * impacts / 60:.0f} min, restitution {restitution_s * impacts / 1e6 / 60:.0f} min")


if arguments.work:
    arguments.work.mkdir(parents=True, exist_ok=True)
    main(arguments.work.resolve())
else:
    with tempfile.TemporaryDirectory() as folder:
        main(Path(folder))
