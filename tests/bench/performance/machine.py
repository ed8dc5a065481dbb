# SPDX-License-Identifier: GPL-3.0-or-later
"""On what it was measured: processor, memory, system, compiler, versions, load."""
import os
import platform
import re
import shutil
import subprocess
import time
from importlib import metadata
from pathlib import Path


def output_of(command):
    """The first line, or nothing where there is no such program."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip().split("\n")[0]
    except OSError:
        return ""


def found(pattern, path):
    try:
        match = re.search(pattern, Path(path).read_text(encoding="utf-8", errors="replace"), re.M)
    except OSError:
        return ""
    return match.group(1).strip() if match else ""


def of_package(name):
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def of_debian(package):
    return output_of(["dpkg-query", "-W", "-f", "${Version}", package]) if shutil.which("dpkg-query") else ""


def processor():
    family, model = found(r"^cpu family\s*: (.*)", "/proc/cpuinfo"), found(r"^model\s*: (.*)", "/proc/cpuinfo")
    name = found(r"^model name\s*: (.*)", "/proc/cpuinfo") or platform.processor() or platform.machine()
    flags = found(r"^flags\s*: (.*)", "/proc/cpuinfo").split()
    vectors = [flag for flag in ("avx512f", "avx2", "fma") if flag in flags]
    caches = [text for level in range(2, 5) if (text := cache(level))]
    guest = ", a virtual machine" if "hypervisor" in flags else ""
    return f"{name} (family {family}, model {model}; {', '.join(vectors) or 'no wide vectors'}; {', '.join(caches)}){guest}"


def cache(index):
    folder = Path(f"/sys/devices/system/cpu/cpu0/cache/index{index}")
    level, text = found(r"(.*)", folder / "level"), found(r"(.*)", folder / "size")
    return f"L{level} {text}" if text else ""


def load():
    return " ".join(f"{value:.1f}" for value in os.getloadavg())


def lines(build, moment):
    """@param build  the build folder; None: the load alone"""
    facts = {f"load at the {moment} (1, 5, 15 min)": load()}
    if build is not None:
        system = found(r'^PRETTY_NAME="?([^"]*)', "/etc/os-release")
        compiler = found(r"^CMAKE_CXX_COMPILER:[A-Z]*=(.*)", build / "CMakeCache.txt")
        memory_kib = found(r"^MemTotal:\s*(\d+)", "/proc/meminfo")
        facts = {
            "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
            "bouncelab": output_of([build / "tools" / "bouncelab" / "bouncelab", "--version"]),
            "processor": processor(),
            "cores": str(len(os.sched_getaffinity(0))),
            "memory": f"{int(memory_kib) / 2**20:.1f} GiB" if memory_kib else "",
            "system": f"{system}, Linux {platform.release()}",
            "compiler": output_of([compiler or "c++", "--version"]),
            "build": found(r"^CMAKE_BUILD_TYPE:[A-Z]*=(.*)", build / "CMakeCache.txt"),
            "peers": f"aubio-tools {of_debian('aubio-tools') or 'not installed'}, SciPy {of_package('scipy')}, NumPy {of_package('numpy')}, "
                     f"iminuit {of_package('iminuit')}, FFTW {of_debian('libfftw3-single3')}, libsndfile {of_debian('libsndfile1')}, "
                     f"Python {platform.python_version()}",
        } | facts
    return [{"part": "run", "case": "machine", "what": what, "value": value, "unit": ""} for what, value in facts.items()]
