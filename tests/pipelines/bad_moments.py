"""Runs that fail for a reason outside their input: memory, threads, disk space, Ctrl-C.

The moments are set by silent or full pipes, which block the program, and not by a clock.
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

LOADER_FAILED = 127  # exit code of ld.so; its message depends on the missing library


def box_config(cells):
    """A config that generates a box of 6 cells³ tetrahedra."""
    def files():
        return {"run.json": json.dumps({
            "input": {"generate": {"box": {"cells": [cells] * 3}}}, "output": {"mesh": "out.mesh"}}).encode()}
    return files


# ---------------------------------------------------------------- reasons to skip

def address_sanitizer():
    """The address sanitizer reserves terabytes of address space."""
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
        error_output = subprocess.run([CAMBER, "run", "run.json"], cwd=folder, capture_output=True, text=True).stderr
        return "built without OpenCASCADE" if "reads no CAD files" in error_output else ""


# ---------------------------------------------------------------- disk space

def on_a_full_disk(folder):
    """The output folder is a disk of 16 KiB, mounted in a private namespace."""
    os.mkdir(folder.path / "disk")
    script = ('mount -t tmpfs -o size=16k tmpfs disk && "$0" curve in.mesh -o disk/out.mesh; code=$?; '
              'test -z "$(ls -A disk)" || { echo "left on the disk: $(ls -A disk)" >&2; exit 99; }; exit $code')
    return subprocess.run(["unshare", "--mount", "sh", "-c", script, CAMBER], cwd=folder.path, capture_output=True,
                          text=True)


def printing_on_a_full_device(folder):
    """Only standard output, which is full."""
    with open("/dev/full", "w", encoding="ascii") as full:
        done = subprocess.run([CAMBER, "info", "in.mesh"], cwd=folder.path, stdout=full, stderr=subprocess.PIPE, text=True)
    return subprocess.CompletedProcess(done.args, done.returncode, "", done.stderr)


# ---------------------------------------------------------------- memory

def with_ever_more_memory(folder, threads="1"):
    """Runs with 2 MiB more each time until the run succeeds. Each failure must be an error of memory in one line;
    returns the last one."""
    last = None
    for mib in range(12, 400, 2):
        limit = mib << 20
        done = folder.camber("run", "run.json", "--threads", threads,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        if done.returncode == 0 and last:
            os.remove(folder.path / "out.mesh")
            return last
        if done.returncode == LOADER_FAILED or "libgomp: " in done.stderr or done.returncode < 0 and not done.stderr:
            continue    # neither the program nor its libraries can start
        if done.returncode != 4 or len(done.stderr.splitlines()) != 1 or folder.files() != ["run.json"]:
            return done
        if "not enough memory" in done.stderr:
            last = done
    return last


def with_ever_more_memory_for_threads(folder):
    """The same with two threads. The stage of the last failure is random and is removed from the message."""
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
    """The input is a pipe that stays silent."""
    os.mkfifo(folder.path / "in.mesh")
    process = started(folder, "curve", "in.mesh", "-o", "out.mesh")
    with open(folder.path / "in.mesh", "wb") as pipe:   # blocks until the program opens it
        pipe.write(b"MeshVersionFormatted 2\n")
        pipe.flush()
        process.send_signal(signal.SIGINT)
        return ended(process)


def interrupted_working(folder):
    """Interrupts a run of many seconds."""
    process = started(folder, "run", "run.json")
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    return ended(process)


def interrupted_writing(folder):
    """The output is a pipe from which only one byte is read."""
    os.mkfifo(folder.path / "out.mesh")
    process = started(folder, "curve", "in.mesh", "-o", "out.mesh")
    with open(folder.path / "out.mesh", "rb", buffering=0) as pipe:
        pipe.read(1)
        process.send_signal(signal.SIGINT)
        return ended(process)


def interrupted_anywhere(folder, times=24):
    """Interrupts a run at `times` moments: the output is complete or absent. A signal before the handler is installed
    ends the process."""
    begin = time.monotonic()
    last_stopped = folder.camber("curve", "in.mesh", "-o", "out.mesh")
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
            last_stopped = done
    (folder.path / "out.mesh").unlink(missing_ok=True)
    return last_stopped
