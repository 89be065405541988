"""Wrong arguments of each function of camber.h: the function returns a defined value, and the error names function and
argument.

    python3 tests/c/test_arguments.py LIBRARY [unittest arguments]
"""
import ctypes
import math
import os
import re
import sys
import tempfile
import traceback
import unittest

LIBRARY = sys.argv[1]
HEADER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "apps", "c", "include", "camber.h")
OK, NOT_CERTIFIED, USAGE, INPUT, INTERNAL = range(5)
POINTS = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1]
NODES = [1, 2, 3, 4, 2, 3, 4, 5]
NOT_FINITE = [math.nan, math.inf, -math.inf]

# Pointers that may be NULL, and functions that do nothing for NULL.
OPTIONAL = {("camber_write", "format"), ("camber_get_cells", "nodes"), ("camber_get_cells", "references"),
            ("camber_field_size", "components"), ("camber_run", "options"), ("camber_run_config", "options"),
            ("camber_run_config", "mesh"), ("camber_result_metric_size", "width"),
            ("camber_free_mesh", "mesh"), ("camber_free_result", "result")}


class Cells(ctypes.Structure):
    _fields_ = [("type", ctypes.c_char_p), ("count", ctypes.c_int64), ("nodes", ctypes.c_void_p),
                ("references", ctypes.c_void_p)]


class Options(ctypes.Structure):
    _fields_ = [("metric", ctypes.c_void_p), ("metric_width", ctypes.c_int), ("progress", ctypes.c_void_p),
                ("context", ctypes.c_void_p)]


def functions_of_header():
    """{function: (type of the value, [(type, name) of each argument])}"""
    with open(HEADER, encoding="utf-8") as file:
        text = re.sub(r"/\*.*?\*/", " ", file.read(), flags=re.S)
    found = {}
    for value, name, arguments in re.findall(r"^CAMBER_API ([^(;]*?)(camber_\w+)\(([^)]*)\);", text, flags=re.M):
        parts = [re.fullmatch(r"(.*?)(\w+)", " ".join(a.split())) for a in arguments.split(",") if a.strip() != "void"]
        found[name] = (value.strip(), [(part[1].strip(), part[2]) for part in parts])
    return found


FUNCTIONS = functions_of_header()


def c_type(text):
    if text == "const char*":
        return ctypes.c_char_p
    if text.endswith("*"):
        return ctypes.c_void_p
    return {"int": ctypes.c_int, "int64_t": ctypes.c_int64, "void": None}[text]


def library():
    loaded = ctypes.CDLL(LIBRARY)
    for name, (value, arguments) in FUNCTIONS.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = c_type(value), [c_type(kind) for kind, _ in arguments]
    return loaded


def doubles(values):
    return (ctypes.c_double * len(values))(*values)


def integers(values):
    return (ctypes.c_int32 * len(values))(*values)


def words(*texts):
    return (ctypes.c_char_p * len(texts))(*texts)



class Calls:
    """Valid arguments of each function, and calls with some of them replaced."""

    def __init__(self):
        self.lib = library()
        self.folder = tempfile.mkdtemp()
        self.keep = []  # arrays referenced by structures
        self.cells = self.cells_of(b"tetra", 2, NODES)
        self.mesh = self.made("camber_make", 3, 5, doubles(POINTS), 1, ctypes.byref(self.cells), 1)
        self.with_field = self.made("camber_with_field", self.mesh, b"x", 1, 5, doubles([1] * 5))
        self.path = os.path.join(self.folder, "mesh.meshb").encode()
        assert self.lib.camber_write(self.mesh, self.path, None) == OK
        self.options = self.options_of([0.5] * 5, 1)
        self.result = self.made("camber_run", self.mesh, 1, words(b"remesh"), ctypes.byref(self.options))

    def made(self, name, *arguments):
        out = ctypes.c_void_p()
        status = getattr(self.lib, name)(*arguments, ctypes.byref(out))
        assert status == OK, (name, status, self.lib.camber_error())
        return out

    def cells_of(self, kind, count, nodes):
        array = integers(nodes) if nodes is not None else None
        self.keep.append(array)
        return Cells(kind, count, ctypes.cast(array, ctypes.c_void_p) if nodes is not None else None, None)

    def options_of(self, metric, width):
        array = doubles(metric)
        self.keep.append(array)
        return Options(ctypes.cast(array, ctypes.c_void_p), width, None, None)

    def right(self, name):
        out = ctypes.byref(ctypes.c_void_p())
        remesh = (1, words(b"remesh"), ctypes.byref(self.options))
        count = ctypes.byref(ctypes.c_int())
        return {
            "camber_version": (), "camber_error": (),
            "camber_read": (self.path, out), "camber_write": (self.mesh, self.path, b"gmf-binary"),
            "camber_make": (3, 5, doubles(POINTS), 1, ctypes.byref(self.cells), 1, out),
            "camber_free_mesh": (self.made("camber_read", self.path),),
            "camber_dimension": (self.mesh,), "camber_degree": (self.mesh,), "camber_vertices": (self.mesh,),
            "camber_points": (self.mesh,), "camber_count": (self.mesh, b"tetra"),
            "camber_get_input_points": (self.mesh, 1, (ctypes.c_int64 * 5)()),
            "camber_get_points": (self.mesh, doubles(POINTS)),
            "camber_get_cells": (self.mesh, b"tetra", 1, integers(NODES), integers([0] * 2)),
            "camber_with_field": (self.mesh, b"x", 1, 5, doubles([1] * 5), out),
            "camber_field_size": (self.with_field, b"x", count),
            "camber_get_field": (self.with_field, b"x", doubles([0] * 5)),
            "camber_run": (self.mesh, *remesh, out),
            "camber_run_config": (self.mesh, b'{"stages": ["elevate"]}', None, out),
            "camber_result_mesh": (self.result,), "camber_result_report": (self.result,),
            "camber_result_metric_size": (self.result, count),
            "camber_result_metric": (self.result, doubles([0] * 6 * self.rows_of_metric())),
            "camber_free_result": (self.made("camber_run", self.mesh, 1, words(b"check"), None),),
        }[name]

    def rows_of_metric(self):
        return self.lib.camber_result_metric_size(self.result, None)

    def call(self, function, /, **replaced):
        names = [argument for _, argument in FUNCTIONS[function][1]]
        assert set(replaced) <= set(names), (function, replaced)
        arguments = [replaced.get(name, right) for name, right in zip(names, self.right(function), strict=True)]
        return getattr(self.lib, function)(*arguments)

    def error(self):
        return self.lib.camber_error().decode(errors="replace")


def each_argument(kinds):
    return [(name, argument) for name, (_, arguments) in FUNCTIONS.items() for kind, argument in arguments if kinds(kind)]


class WrongArguments(unittest.TestCase):
    def in_a_process(self, check):
        """Runs `check(calls)` in a separate process, so that a crash fails the test."""
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            code = 1
            try:
                check(Calls())
                code = 0
            except BaseException:  # printed here: the parent only gets the exit code
                traceback.print_exc()
            finally:
                os._exit(code)
        status = os.waitpid(child, 0)[1]
        self.assertFalse(os.WIFSIGNALED(status), f"signal {os.WTERMSIG(status)}")
        self.assertEqual(os.WEXITSTATUS(status), 0)

    def refused(self, calls, function, texts, statuses=(USAGE,), /, **replaced):
        """The call returns one of the statuses, or 0 where it returns a value; its error names the function and all texts."""
        value = calls.call(function, **replaced)
        returns_status = FUNCTIONS[function][0] == "int" and function not in ("camber_dimension", "camber_degree")
        self.assertIn(value, statuses if returns_status else (0, None), f"{function} {replaced}: {calls.error()}")
        for text in (function + ": ", *texts):
            self.assertIn(text, calls.error())

    def test_valid_arguments_of_each_function_are_accepted(self):
        def check(calls):
            for name, (value, _) in FUNCTIONS.items():
                got = calls.call(name)
                expected = {"camber_dimension": 3, "camber_degree": 1}.get(name, OK)
                if value == "int":
                    self.assertEqual(got, expected, f"{name}: {calls.error()}")
                elif value != "void":
                    self.assertIsNotNone(got, name)
        self.assertEqual(len(FUNCTIONS), 24)
        self.in_a_process(check)

    def test_a_null_pointer_is_rejected(self):
        for name, argument in each_argument(lambda kind: kind.endswith("*")):
            with self.subTest(function=name, argument=argument):
                if (name, argument) in OPTIONAL:
                    generated = b'{"input": {"generate": {"annulus": {}}}, "stages": ["elevate"]}'
                    replaced = {"json": generated} if (name, argument) == ("camber_run_config", "mesh") else {}
                    self.in_a_process(lambda calls: self.assertIn(
                        calls.call(name, **{argument: None}, **replaced),
                        {"camber_field_size": (5,), "camber_result_metric_size": (calls.rows_of_metric(),)}.get(
                            name, (OK, None))))
                else:
                    self.in_a_process(lambda calls: self.refused(calls, name, [argument + ": is NULL"], **{argument: None}))

    def test_a_negative_number_is_rejected(self):
        for name, argument in each_argument(lambda kind: kind in ("int", "int64_t")):
            with self.subTest(function=name, argument=argument):
                for value in (-1, -2**31):
                    self.in_a_process(lambda calls: self.refused(calls, name, [f"{argument}: is {value}"], (USAGE, INPUT),
                                                                 **{argument: value}))

    def test_a_number_that_is_not_finite_is_rejected(self):
        def check(calls):
            for bad in NOT_FINITE:
                self.refused(calls, "camber_make", ["coordinates: row 1: ", "not finite"], (INPUT,),
                             coordinates=doubles([0, 0, 0, bad] + POINTS[4:]))
                self.refused(calls, "camber_with_field", ["values: row 3 is not finite"], (INPUT,),
                             values=doubles([1, 1, 1, bad, 1]))
                for name, extra in (("camber_run", {}), ("camber_run", {"word": words(b"check")}),
                                    ("camber_run_config", {"json": b'{"stages": ["remesh"]}'})):
                    for metric, width in (([1, bad, 1, 1, 1], 1), ([1, 0, 1, 0, 0, 1] + [1, bad, 1, 0, 0, 1] * 4, 6)):
                        options = calls.options_of(metric, width)
                        self.refused(calls, name, ["options.metric: ", "at vertex 2: "], (INPUT,),
                                     options=ctypes.byref(options), **extra)
        self.in_a_process(check)

    def test_counts_beyond_the_memory_are_rejected(self):
        def check(calls):
            self.assertEqual(calls.call("camber_make", points=2**62), INTERNAL)
            self.assertIn("not enough memory", calls.error())
            cells = calls.cells_of(b"tetra", 2**62, NODES)
            self.assertEqual(calls.call("camber_make", cells=ctypes.byref(cells)), INTERNAL)
            self.assertIn("not enough memory", calls.error())
            self.refused(calls, "camber_get_cells", ["first: is 2147483647"], first=2**31 - 1)
        self.in_a_process(check)

    def test_wrong_cells_are_rejected(self):
        def check(calls):
            for kind, count, nodes, text, status in (
                    (None, 2, NODES, "cells[0].type: is NULL", USAGE), (b"tetra", -1, NODES, "cells[0].count: is -1", USAGE),
                    (b"tetra", 2, None, "cells[0].nodes: is NULL", USAGE), (b"quad", 2, NODES, "quad: is not a type", INPUT),
                    (b"\xff", 2, NODES, "is not a type", INPUT), (b"tetra", 1, [1, 2, 3, 0], "tetra: row 0: ", INPUT),
                    (b"tetra", 1, [1, 2, 3, -2**31], "tetra: row 0: ", INPUT),
                    (b"tetra", 1, [1, 2, 3, 2**31 - 1], "tetra: row 0: ", INPUT)):
                cells = calls.cells_of(kind, count, nodes)
                self.refused(calls, "camber_make", [text], (status,), cells=ctypes.byref(cells))
            twice = (Cells * 2)(calls.cells, calls.cells)
            self.refused(calls, "camber_make", ["cells[1].type: tetra comes twice"], types=2, cells=twice)
        self.in_a_process(check)

    def test_wrong_words_are_rejected(self):
        def check(calls):
            for texts, text in (
                    ((None,), "word[0]: is NULL"), ((b"curve", None), "word[1]: is NULL"), ((b"",), "word[0]: "),
                    ((b"info",), "word[0]: \"info\" is not a verb"), ((b"--help",), "word[0]: "), ((b"\xff",), "word[0]: "),
                    ((b"curve", b"-o", b"x.mesh"), "word[1]: "), ((b"curve", b"--output=x.mesh"), "word[1]: "),
                    ((b"check", b"--metric=x.sol"), "word[1]: "), ((b"check", b"--page=x.html"), "word[1]: ")):
                self.refused(calls, "camber_run", [text], words=len(texts), word=words(*texts), options=None)
            self.refused(calls, "camber_run", ["words: is 0"], words=0)
            for texts in ((b"curve", b"--objective=length", b"--objective=energy"), (b"remesh", b"--metric=1", b"--metric=2")):
                self.assertEqual(calls.call("camber_run", words=3, word=words(*texts), options=None), USAGE)
                self.assertIn(texts[1].split(b"=")[0].decode() + ": appears 2 times (use it once)", calls.error())
        self.in_a_process(check)

    def test_two_metrics_are_rejected(self):
        def check(calls):
            for texts in ((b"remesh", b"--metric=0.1"), (b"remesh", b"--metric", b"0.1"), (b"curve", b"--metric=natural"),
                          (b"adapt", b"--metric=0.1"), (b"check", b"--metric=x.sol")):
                self.refused(calls, "camber_run", ["word[1]: --metric cannot be combined with options.metric"],
                             words=len(texts), word=words(*texts))
            self.refused(calls, "camber_run", ["options.metric: cannot be combined with repair"], word=words(b"repair"))
            self.refused(calls, "camber_run_config", ["json: \"metric\" cannot be combined with options.metric"],
                         json=b'{"stages": ["elevate"], "metric": {"constant": {"sizes": [1, 1, 1]}}}',
                         options=ctypes.byref(calls.options))
            self.refused(calls, "camber_run_config", ["options.metric: does not belong to a mesh"], mesh=None,
                         options=ctypes.byref(calls.options))
        self.in_a_process(check)

    def test_a_metric_of_a_wrong_width_is_rejected(self):
        def check(calls):
            for width in (-1, 0, 3, 5, 2**31 - 1):
                options = calls.options_of([1] * 5, width)
                for name in ("camber_run", "camber_run_config"):
                    self.refused(calls, name, [f"options.metric_width: is {width}"], options=ctypes.byref(options))
        self.in_a_process(check)

    def test_names_of_arbitrary_bytes_are_accepted_or_rejected_without_a_crash(self):
        def check(calls):
            for name in (b"", b"\xff", b"\xe2\x82", b"a\nb", b"x" * 100000):
                mesh = ctypes.c_void_p()
                if calls.call("camber_with_field", name=name, **{"with": ctypes.byref(mesh)}) == OK:
                    self.assertIn(calls.call("camber_run", mesh=mesh), (OK, NOT_CERTIFIED), calls.error())
                    self.assertEqual(calls.call("camber_get_field", mesh=mesh, name=name), OK)
                self.refused(calls, "camber_get_field", ["name: "], mesh=calls.mesh, name=name)
                self.refused(calls, "camber_get_cells", ["type: "], type=name)
                self.assertEqual(calls.call("camber_count", type=name), 0)
                self.assertEqual(calls.call("camber_read", path=b"/nowhere/" + name), INPUT)
                self.assertEqual(calls.call("camber_write", format=name) in (OK, USAGE), True)
                self.assertIn(calls.call("camber_run_config", json=name), (USAGE, OK))
        self.in_a_process(check)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
