"""The keywords of the verbs equal the arguments of the program; verbs.py equals the output of its generator."""
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
    def test_verbs_py_equals_the_output_of_its_generator(self):
        made = subprocess.run([sys.executable, os.path.join(SOURCE, "make_verbs.py"), os.path.join(BUILD, "python")],
                              capture_output=True, text=True, check=True).stdout
        with open(os.path.join(SOURCE, "camber", "verbs.py")) as file:
            self.assertEqual(file.read(), made, "python3 apps/python/make_verbs.py build/python > apps/python/camber/verbs.py")

    def test_every_argument_is_a_keyword_or_excluded_by_name(self):
        described = json.loads(camber._camber.arguments())
        for verb, (subject, _, without) in make_verbs.VERBS.items():
            keywords = set(inspect.signature(getattr(camber, verb)).parameters)
            for argument in described[verb]["arguments"]:
                name = argument["name"]
                if (verb, name) == ("adapt", "solve") or name in subject:
                    continue  # a function in Python and a command in the program; the subject of the verb
                here = make_verbs.python_name(name) in keywords
                self.assertNotEqual(here, name in make_verbs.NOT_HERE | without or argument["positional"] and not here,
                                    f"{verb}: {name}")

    def test_command_metric_has_the_keywords_that_from_solution_passes_on(self):
        # `from_solution` passes them on unchanged.
        names = {a["name"] for a in json.loads(camber._camber.arguments())["metric"]["arguments"]}
        self.assertLessEqual({"complexity", "norm", "gradation", "size", "geometry-error"}, names)

    def test_docstrings_describe_every_keyword(self):
        for verb in make_verbs.VERBS:
            function = getattr(camber, verb)
            for name in inspect.signature(function).parameters:
                self.assertIn(f"\n    {name}: ", function.__doc__, verb)


if __name__ == "__main__":
    shared.main()
