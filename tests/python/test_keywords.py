"""The verbs' keywords are the program's arguments: the file that has them is what its generator makes."""
import inspect
import json
import os
import subprocess
import sys
import unittest

import shared
from shared import BUILD, camber

SOURCE = os.path.join(os.path.dirname(__file__), "..", "..", "apps", "python")
sys.path.insert(0, SOURCE)
import make_verbs  # noqa: E402


class Keywords(unittest.TestCase):
    def test_the_file_is_as_made(self):
        made = subprocess.run([sys.executable, os.path.join(SOURCE, "make_verbs.py"), os.path.join(BUILD, "python")],
                              capture_output=True, text=True, check=True).stdout
        with open(os.path.join(SOURCE, "camber", "verbs.py")) as file:
            self.assertEqual(file.read(), made, "python3 apps/python/make_verbs.py build/python > apps/python/camber/verbs.py")

    def test_every_argument_is_here_or_left_out_by_name(self):
        described = json.loads(camber._camber.arguments())
        for verb, (subject, _, without) in make_verbs.VERBS.items():
            keywords = set(inspect.signature(getattr(camber, verb)).parameters)
            for argument in described[verb]["arguments"]:
                name = argument["name"]
                if (verb, name) == ("adapt", "solve") or name in subject:
                    continue  # a function here, a command there; what the verb is done to
                here = make_verbs.python_name(name) in keywords
                self.assertNotEqual(here, name in make_verbs.NOT_HERE | without or argument["positional"] and not here,
                                    f"{verb}: {name}")

    def test_keywords_of_solution_metrics(self):
        # `from_solution` passes them on as they are.
        names = {a["name"] for a in json.loads(camber._camber.arguments())["metric"]["arguments"]}
        self.assertLessEqual({"complexity", "norm", "gradation", "size", "geometry-error"}, names)

    def test_docstrings_tell_of_each(self):
        for verb in make_verbs.VERBS:
            function = getattr(camber, verb)
            for name in inspect.signature(function).parameters:
                self.assertIn(f"\n    {name}: ", function.__doc__, verb)


if __name__ == "__main__":
    shared.main()
