# SPDX-License-Identifier: GPL-3.0-or-later
"""`pip install tools/python`: CMake builds the component `python` of the repository, and what it installs is the package.

Where tools/run or tools/test has built (build/release) for a Python of this version, its libraries are taken and the
module alone is compiled. Else the build folder is build/pip-cp311, and stays: the next installation compiles what
changed. One that was copied or moved with the repository is of the place where it was made, and is not taken. Further
variables of CMake: the environment's CMAKE_ARGS. BOUNCELAB_BUILD names a folder in which the module is built already, by
tools/package.
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parents[2]
SETUP = "tools/setup --python installs what is needed"


def version() -> str:
    lists = ROOT / "CMakeLists.txt"
    found = re.search(r"^project\(bouncelab VERSION ([0-9.]+)", lists.read_text() if lists.exists() else "", re.MULTILINE)
    if found is None:
        sys.exit(f"bouncelab: {ROOT} is not the repository: the module is built from the whole of it, in place "
                 "(git clone, then pip install tools/python)")
    return found[1]


class CMakeBuild(build_ext):
    """Takes what CMake installs."""

    def run(self) -> None:
        built = os.environ.get("BOUNCELAB_BUILD")
        if built is None:
            built = self.build()
        with tempfile.TemporaryDirectory() as prefix:
            self.call("cmake", "--install", built, "--component", "python", "--strip", "--prefix", prefix)
            package, = Path(prefix).rglob("bouncelab/__init__.py")
            shutil.copytree(package.parent, Path(self.build_lib).resolve() / "bouncelab", dirs_exist_ok=True)

    def build(self) -> Path:
        """Makes the module; the folder that it stands in."""
        missing = [tool for tool in ("cmake", "ninja", "c++", "pkg-config") if shutil.which(tool) is None]
        if not Path(sysconfig.get_paths()["include"], "Python.h").exists():
            missing.append("Python.h of " + sys.executable + " (python3-dev)")
        if missing:
            sys.exit(f"bouncelab: missing: {', '.join(missing)}; {SETUP}")
        build = ROOT / "build" / "release"
        if self.is_for_this_python(build):
            self.call("cmake", "--preset", "release", *shlex.split(os.environ.get("CMAKE_ARGS", "")))
        else:
            build = ROOT / "build" / "pip-cp{}{}".format(*sys.version_info[:2])
            if build.exists() and not self.is_of_this_place(build):
                shutil.rmtree(build)
            self.call("cmake", "--preset", "release", "-B", build, "-DBOUNCELAB_COMPONENTS=python",
                      "-DBOUNCELAB_BINDINGS=OFF", "-DBOUNCELAB_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}",
                      *shlex.split(os.environ.get("CMAKE_ARGS", "")))
        self.call("cmake", "--build", build, "--target", "bouncelab_python_package")
        return build

    @staticmethod
    def cached(build: Path, variable: str) -> str:
        """What CMake knows in this folder; empty where it does not."""
        cache = build / "CMakeCache.txt"
        found = cache.exists() and re.search(f"^{variable}:INTERNAL=(.*)$", cache.read_text(), re.MULTILINE)
        return found[1] if found else ""

    def is_of_this_place(self, build: Path) -> bool:
        """Whether it was configured here, for these sources: CMake refuses others."""
        sources = self.cached(build, "CMAKE_HOME_DIRECTORY")
        return os.path.exists(sources) and os.path.samefile(sources, ROOT)

    def is_for_this_python(self, build: Path) -> bool:
        """Whether this folder was configured here with the module, for the same version of Python."""
        version = "Python;{};{};".format(*sys.version_info[:2])
        return (self.cached(build, "_Python3_INTERPRETER_PROPERTIES").startswith(version)
                and self.is_of_this_place(build))

    @staticmethod
    def call(*command) -> None:
        # pip's own PYTHONPATH is not for the interpreters that the build starts
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        try:
            subprocess.run(command, cwd=ROOT, check=True, env=environment)
        except subprocess.CalledProcessError:
            sys.exit(f"bouncelab: the build stopped in: {' '.join(map(str, command[:3]))} ...; the reason is above; {SETUP}")


setup(version=version(), packages=[], py_modules=[], ext_modules=[Extension("bouncelab._core", [])],
      cmdclass={"build_ext": CMakeBuild})
