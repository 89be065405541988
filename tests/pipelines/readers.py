"""Requirements of tests: external programs and Python modules that read or write meshes."""
import importlib.util
import os
import shutil
import unittest


def is_there(name):
    return shutil.which(name) is not None or importlib.util.find_spec(name) is not None


def needs(name):
    """Decorator: skips the test if neither a program nor a Python module of that name is installed. With
    CAMBER_NO_SKIP=1 the test fails."""
    def decorate(test):
        if is_there(name):
            return test
        if os.environ.get("CAMBER_NO_SKIP") != "1":
            return unittest.skip(f"{name} is not installed")(test)

        def absent(self, *_):
            self.fail(f"{name} is not installed")
        return absent
    return decorate
