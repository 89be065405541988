"""The licences of libraries that come along, from the Debian packages that they are of.

    licences.py FOLDER COMPONENT LIBRARY...

FOLDER gets a file for each package; the licences that these refer to; and COMPONENT.txt, which tells of each library its package, version
and source. With the component `camber` also those of the libraries of which the program has the headers in itself.
"""
import pathlib
import re
import shutil
import subprocess
import sys

COMMON = pathlib.Path("/usr/share/common-licenses")
# Libraries without a file of their own, by a header of each.
HEADERS = {"camber": ["eigen3/Eigen/Core", "range/v3/all.hpp", "tl/expected.hpp", "boost/multiprecision/cpp_int.hpp",
                      "nlohmann/json.hpp", "CLI/CLI.hpp"]}


def spellings(file):
    """The paths by which the package may know the file: its own, and that before /lib became a link into /usr."""
    path = pathlib.Path(file)
    return [str(path.resolve()), str(path), str(pathlib.Path("/", *path.resolve().parts[2:]))]


def packages_of(files):
    """By file, the package that has it."""
    wanted = [name for file in files for name in spellings(file)]
    found = subprocess.run(["dpkg-query", "--search", *wanted], capture_output=True, text=True).stdout  # not all spellings are known
    owners = {path: owner.split(",")[0] for owner, path in re.findall(r"(?m)^(\S.*?): (/.*)$", found)}
    out = {}
    for file in files:
        out[file] = next((owners[name] for name in spellings(file) if name in owners), None)
        if out[file] is None:
            sys.exit(f"licences: no Debian package has {file}: what comes along must have its licence")
    return out


def described(packages):
    """By package, its name and version and those of its source."""
    form = "${Package} ${Version}, source ${source:Package} ${source:Version}\n"
    said = subprocess.run(["dpkg-query", "--show", f"--showformat={form}", *packages], capture_output=True, text=True, check=True).stdout
    return {line.split(" ")[0]: line for line in said.splitlines()}


def main(folder, component, *libraries):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    headers = ["/usr/include/" + header for header in HEADERS.get(component, [])]
    packages = packages_of([*sorted(libraries), *headers])
    sources = described(set(packages.values()))
    lines = []
    for file, package in packages.items():
        name = package.split(":")[0]
        licence = pathlib.Path("/usr/share/doc", name, "copyright")
        shutil.copyfile(licence, folder / name)
        for common in re.findall(rf"{COMMON}/([A-Za-z0-9.-]*[A-Za-z0-9])", licence.read_text(encoding="utf-8", errors="replace")):
            if (COMMON / common).exists():
                shutil.copyfile(COMMON / common, folder / common)
        shown = pathlib.Path(file).name if file in libraries else file.removeprefix("/usr/include/") + " (compiled in)"
        lines.append(f"{shown}: {sources[name]}\n")
    text = "What comes with the program, and Debian's package and source of each. Its licence is in the file of the package's name.\n\n"
    (folder / f"{component}.txt").write_text(text + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
