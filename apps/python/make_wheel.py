#!/usr/bin/env python3
"""Makes a wheel of the package in a build directory.

    python3 apps/python/make_wheel.py BUILD_DIRECTORY FOLDER

The wheel is for the Python version of the build, and for machines with the same system libraries. It contains the CAD
reader, but no system libraries (docs/python.md).
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

METADATA = """Metadata-Version: 2.1
Name: camber
Version: {version}
Summary: Curved (P2) meshes of triangles and tetrahedra, always valid
License: Apache-2.0
Requires-Python: >=3.9
Requires-Dist: numpy>=1.22
"""
WHEEL = "Wheel-Version: 1.0\nGenerator: camber\nRoot-Is-Purelib: false\nTag: {tag}\n"


def tag():
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    return f"{python}-{python}-" + re.sub(r"[^A-Za-z0-9]", "_", sysconfig.get_platform())


def strip(path):
    for program in ("llvm-strip-19", "llvm-strip", "strip"):
        if shutil.which(program):
            subprocess.run([program, "--strip-unneeded", path], check=True)
            return


def copied(build, folder):
    """Copy the package without caches, with the CAD reader."""
    package = os.path.join(folder, "camber")
    shutil.copytree(os.path.join(build, "python", "camber"), package, ignore=shutil.ignore_patterns("__pycache__"))
    reader = os.path.join(build, "lib", "libcamber_occ.so")
    if os.path.exists(reader):
        shutil.copy(reader, package)
    for name in os.listdir(package):
        if name.endswith(".so"):
            strip(os.path.join(package, name))


def main():
    build, out = sys.argv[1:3]
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
    with open(os.path.join(source, "CMakeLists.txt")) as file:
        version = re.search(r"project\(camber VERSION ([0-9.]+)", file.read())[1]
    os.makedirs(out, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        copied(build, folder)
        info = os.path.join(folder, f"camber-{version}.dist-info")
        os.mkdir(info)
        shutil.copy(os.path.join(source, "LICENSE"), info)
        for name, text in (("METADATA", METADATA.format(version=version)), ("WHEEL", WHEEL.format(tag=tag()))):
            with open(os.path.join(info, name), "w") as file:
                file.write(text)
        subprocess.run([sys.executable, "-m", "wheel", "pack", folder, "-d", out], check=True, stdout=subprocess.DEVNULL)
    print(os.path.join(out, f"camber-{version}-{tag()}.whl"))


if __name__ == "__main__":
    main()
