"""The check of prose: it reads comments and messages and nothing else, finds each habit, and the program keeps its limits."""
import contextlib
import io
import unittest

import prose


def findings(source):
    count = prose.Count(findings=[])
    count.add("a.cpp", source)
    return [(line, phrase) for _, line, phrase, _ in count.findings]


class Texts(unittest.TestCase):
    def read(self, source):
        return [(t.line, t.kind, t.words) for t in prose.texts(source)]

    def test_lines_of_a_comment_are_joined(self):
        self.assertEqual(self.read("/// Returns one\n/// of two.\nint f();\n// A remark.\n"),
                         [(1, "doc", "Returns one of two."), (4, "comment", "A remark.")])

    def test_trailing_comments_are_separate(self):
        self.assertEqual(self.read("int a;  ///< the first\nint b;  ///< the second\n"), [(1, "doc", "the first"), (2, "doc", "the second")])

    def test_adjacent_literals_are_one_message(self):
        self.assertEqual(self.read('f("the mesh has no "\n  "elements of degree 2", 1);'), [(1, "message", "the mesh has no elements of degree 2")])

    def test_code_is_not_prose(self):
        self.assertEqual(self.read("int told = 1'000'000; char c = '\"'; // NOLINT(what is this)\nf(\"told\", \"a/b/c/d\", R\"(what is it for)\");"), [])


class Habits(unittest.TestCase):
    def test_each_habit_is_found_with_its_line(self):
        for sentence, phrase in (("What the mesh has.", "What"), ("Of an element the smallest.", "Of"), ("It is told to the caller.", "is told"),
                                 ("Nothing that nobody sees.", "nobody"), ("The wanted size of it.", "wanted"), ("A mesh as it is.", "as it is"),
                                 ("The field goes along.", "goes along"), ("Writes what is left.", "what is")):
            with self.subTest(sentence):
                for source in (f"int a;\n/// {sentence}\n", f"int a;\nint b;  // {sentence}\n", f'int a;\nf("a message. {sentence}");\n'):
                    self.assertIn((2, phrase), findings(source))

    def test_plain_sentences_have_none(self):
        self.assertEqual(findings("/// Returns the smallest scaled Jacobian of the elements, and 1 for an empty mesh.\n/// Errors: memory.\n"), [])

    def test_identifiers_in_backticks_are_no_words(self):
        self.assertEqual(findings("/// Reads `what is told` from the file.\n"), [])

    def test_a_comment_that_begins_with_a_relative_clause_is_listed_at_any_rate(self):
        self.assertIn((1, "begins with Whether"), findings("/// Whether the mesh is empty.\n"))


class Program(unittest.TestCase):
    def test_comments_and_messages_keep_the_limits(self):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            code = prose.main([])
        self.assertEqual(code, 0, printed.getvalue())


if __name__ == "__main__":
    unittest.main()
