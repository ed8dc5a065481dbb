# SPDX-License-Identifier: GPL-3.0-or-later
"""setuptools as it is installed. pip hides what is installed from a build and would fetch setuptools instead, which
needs a network; the packages of Debian, those of the interpreter and those of the virtual environment are shown here."""
import site
import sys
import sysconfig

sys.path += ["/usr/lib/python3/dist-packages", sysconfig.get_paths(vars={"base": sys.base_prefix})["purelib"],
             *site.getsitepackages()]
try:
    import wheel  # noqa: F401
    from setuptools.build_meta import *  # noqa: F401,F403
except ImportError as missing:
    sys.exit(f"bouncelab: {missing.name} is missing; tools/setup --python installs what is needed")


def get_requires_for_build_wheel(config_settings=None):
    return []  # nothing to fetch
