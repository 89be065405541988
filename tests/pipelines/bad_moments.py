"""Runs of the program that end badly for a reason outside their input: no memory, no threads, no room, Ctrl-C.

Each is told by what the program does, not by a clock: pipes that are silent or full say where it is.
"""
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import time

from program import CAMBER

LOADER_FAILED = 127  # what ld.so ends with, in words that depend on what it lacked


def box_config(cells):
    """A generated box of 6 cells³ tetrahedra."""
    def files():
        return {"run.json": json.dumps({
            "input": {"generate": {"box": {"cells": [cells] * 3}}}, "output": {"mesh": "out.mesh"}}).encode()}
    return files


# ---------------------------------------------------------------- what cannot be tried here

def address_sanitizer():
    """It maps terabytes."""
    with open(CAMBER, "rb") as file:
        return "does not work with the address sanitizer" if b"__asan_init" in file.read() else ""


def no_threads_to_refuse():
    if len(os.sched_getaffinity(0)) < 2:
        return "one processor: no thread is wanted"
    return address_sanitizer()


def no_disk():
    if os.geteuid() != 0 or not shutil.which("mount"):
        return "wants root, to mount a small disk"
    probe = subprocess.run(["unshare", "--mount", "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True)
    return "" if probe.returncode == 0 else "no disk can be mounted here"


def no_cad():
    with tempfile.TemporaryDirectory() as folder:
        config = {"input": {"generate": {"box": {"cells": [1, 1, 1]}}}, "geometry": {"cad": {"file": "none.step"}}}
        with open(os.path.join(folder, "run.json"), "w", encoding="utf-8") as file:
            json.dump(config, file)
        said = subprocess.run([CAMBER, "run", "run.json"], cwd=folder, capture_output=True, text=True).stderr
        return "built without OpenCASCADE" if "reads no CAD files" in said else ""


# ---------------------------------------------------------------- room

def on_a_full_disk(folder):
    """The output's folder is a disk of 16 KiB; the program's own view of the mounts goes with it."""
    os.mkdir(folder.path / "disk")
    script = ('mount -t tmpfs -o size=16k tmpfs disk && "$0" curve in.mesh -o disk/out.mesh; code=$?; '
              'test -z "$(ls -A disk)" || { echo "left on the disk: $(ls -A disk)" >&2; exit 99; }; exit $code')
    return subprocess.run(["unshare", "--mount", "sh", "-c", script, CAMBER], cwd=folder.path, capture_output=True,
                          text=True)


def printing_on_a_full_device(folder):
    """No output but what is printed."""
    with open("/dev/full", "w", encoding="ascii") as full:
        done = subprocess.run([CAMBER, "info", "in.mesh"], cwd=folder.path, stdout=full, stderr=subprocess.PIPE, text=True)
    return subprocess.CompletedProcess(done.args, done.returncode, "", done.stderr)


# ---------------------------------------------------------------- memory

def with_ever_more_memory(folder, threads="1"):
    """With 2 MiB more each time, until the run is done. Every failure must be one of memory, whole and in one line; the
    last that ran out on the way is told."""
    last = None
    for mib in range(12, 400, 2):
        limit = mib << 20
        done = folder.camber("run", "run.json", "--threads", threads,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        if done.returncode == 0 and last:
            os.remove(folder.path / "out.mesh")
            return last
        if done.returncode == LOADER_FAILED or "libgomp: " in done.stderr or done.returncode < 0 and not done.stderr:
            continue    # not even the program itself fits, or what its libraries begin with
        if done.returncode != 4 or len(done.stderr.splitlines()) != 1 or folder.files() != ["run.json"]:
            return done
        if "not enough memory" in done.stderr:
            last = done
    return last


def with_ever_more_memory_for_threads(folder):
    """Which stage is the last that runs out is chance here, so it is not told."""
    done = with_ever_more_memory(folder, "2")
    if done:
        done.stderr = re.sub(r"(?<=^camber: )[a-z.]+: (?=not enough memory)", "", done.stderr)
    return done


# ---------------------------------------------------------------- Ctrl-C

def started(folder, *arguments):
    return subprocess.Popen([CAMBER, *arguments], cwd=folder.path, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True)


def ended(process):
    out, err = process.communicate(timeout=60)
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def interrupted_reading(folder):
    """The mesh is a pipe that stays silent."""
    os.mkfifo(folder.path / "in.mesh")
    process = started(folder, "curve", "in.mesh", "-o", "out.mesh")
    with open(folder.path / "in.mesh", "wb") as pipe:   # opens when the program does
        pipe.write(b"MeshVersionFormatted 2\n")
        pipe.flush()
        process.send_signal(signal.SIGINT)
        return ended(process)


def interrupted_working(folder):
    """A run of many seconds."""
    process = started(folder, "run", "run.json")
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    return ended(process)


def interrupted_writing(folder):
    """The output is a pipe that is read no more than one byte."""
    os.mkfifo(folder.path / "out.mesh")
    process = started(folder, "curve", "in.mesh", "-o", "out.mesh")
    with open(folder.path / "out.mesh", "rb", buffering=0) as pipe:
        pipe.read(1)
        process.send_signal(signal.SIGINT)
        return ended(process)


def interrupted_anywhere(folder, times=24):
    """At so many times in a run: it is whole or it left nothing. A signal before the program listens ends it as such."""
    begin = time.monotonic()
    told = folder.camber("curve", "in.mesh", "-o", "out.mesh")
    length = time.monotonic() - begin
    whole = (folder.path / "out.mesh").read_bytes()
    for i in range(times):
        (folder.path / "out.mesh").unlink(missing_ok=True)
        process = started(folder, "curve", "in.mesh", "-o", "out.mesh")
        time.sleep(length * i / times)
        process.send_signal(signal.SIGINT)
        done = ended(process)
        left = folder.files()
        if done.returncode == 0 and (folder.path / "out.mesh").read_bytes() == whole:
            continue
        if done.returncode not in (130, -signal.SIGINT) or left != ["in.mesh"]:
            return done
        if done.returncode == 130:
            told = done
    (folder.path / "out.mesh").unlink(missing_ok=True)
    return told
