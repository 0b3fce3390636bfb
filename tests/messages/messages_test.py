#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What messages.py finds wrong with a table, by a program that does what each test asks."""
import contextlib
import io
import pathlib
import tempfile
import unittest

import messages
import rows

# Reads in.txt; refuses "bad" lines, and leaves a file where the line asks for one.
PROGRAM = """#!/bin/sh
test "$1" = fill && { printf 'a\\ngood\\na\\n' > in.txt; exit 0; }
number=$(grep -n bad in.txt | cut -d: -f1)
test -z "$number" && exit 0
grep -q leave in.txt && touch left
grep -q print in.txt && echo out
grep -q nowhere in.txt && { echo 'sarblock: is bad' >&2; exit 3; }
echo "sarblock: in.txt:$number: word: is bad" >&2
exit 3
"""
HEAD = "== Words\nmake fill\n$ read\n\n0\n\n"
ROW = "in.txt\n- good\n+ bad\n"


class TableTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.program = self.folder / "program"
        self.program.write_text(PROGRAM, encoding="utf-8")
        self.program.chmod(0o755)
        self.table = self.folder / "words.txt"

    def check(self, text, write=False):
        """Rows, rows that failed, and what is printed."""
        self.table.write_text(text, encoding="utf-8")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            count, failed = messages.check(self.program, self.table, write)
        return count, failed, printed.getvalue()

    def test_a_row_that_is_as_it_says_passes(self):
        self.assertEqual(self.check(HEAD + ROW + "3 in.txt:2: word: is bad\n"), (2, 0, ""))

    def test_another_message_or_exit_code_is_shown(self):
        for answer in ("3 in.txt:2: word: is good", "4 in.txt:2: word: is bad", "0"):
            count, failed, printed = self.check(HEAD + ROW + answer + "\n")
            self.assertEqual((count, failed), (2, 1))
            self.assertIn("words.txt:7: Words", printed)
            self.assertIn("got      3 in.txt:2: word: is bad", printed)

    def test_of_every_second_row_the_first_and_third_are_run(self):
        rest = "\n".join([ROW + "0\n", ROW + "3 in.txt:2: word: is bad\n"])  # the second would fail
        self.table.write_text(HEAD + rest, encoding="utf-8")
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(messages.check(self.program, self.table, False, 2), (2, 0))
            self.assertEqual(messages.check(self.program, self.table, False), (3, 1))

    def test_a_refusal_that_leaves_something_fails(self):
        for word, problem in (("leave", "changed files"), ("print", "wrote to standard output: b'out")):
            _, failed, printed = self.check(HEAD + ROW + f"+ {word}\n3 in.txt:2: word: is bad\n")
            self.assertEqual(failed, 1)
            self.assertIn(problem, printed)

    def test_a_message_names_its_place(self):
        _, failed, printed = self.check(HEAD + ROW + "+ nowhere\n3 is bad\n")
        self.assertEqual(failed, 1)
        self.assertIn("begins with no place", printed)
        self.assertEqual(self.check(HEAD + ROW + "+ nowhere\n3~ is bad\n")[1], 0)

    def test_lines_that_are_not_there_once_fail(self):
        for line, times in (("a", 2), ("b", 0)):
            _, failed, printed = self.check(HEAD + f"in.txt\n- {line}\n+ bad\n3 in.txt:2: word: is bad\n")
            self.assertEqual(failed, 1)
            self.assertIn(f"in.txt has these lines {times} times", printed)

    def test_update_writes_what_is_said(self):
        self.check(HEAD + ROW + "3 \n\n" + ROW + "+ nowhere\n3~\n", write=True)
        self.assertEqual(self.table.read_text(encoding="utf-8"),
                         HEAD + ROW + "3 in.txt:2: word: is bad\n\n" + ROW + "+ nowhere\n3~ is bad\n")

    def test_a_good_input_is_shown_to_be_good(self):
        with self.assertRaisesRegex(rows.Mistake, "words.txt:1: the first row needs exit code 0"):
            self.check("== Words\nmake fill\n$ read\n\n" + ROW + "3 in.txt:2: word: is bad\n")

    def test_lines_that_are_none_of_a_table_are_refused(self):
        for text, problem in (("good a\n", "a section is needed"), (HEAD + "+ bad\n0\n", "the file is to be named"),
                              (HEAD + ROW + "\n", "the row has no answer"), (HEAD + "two words\n0\n", "is no line of a table"),
                              (HEAD + ROW + "= bad\n0\n", "lines of = give a whole file"),
                              (HEAD + "0\n0\n", "an empty line is needed")):
            with self.assertRaisesRegex(rows.Mistake, problem):
                self.check(text)

    def test_contexts_appended_lines_and_whole_files(self):
        for change, number in (("in.txt\n  good\n+ bad\n", 3), ("in.txt\n+ bad\n", 4), ("in.txt\n= bad\n", 1)):
            self.assertEqual(self.check(HEAD + change + f"3 in.txt:{number}: word: is bad\n"), (2, 0, ""))


if __name__ == "__main__":
    unittest.main()
