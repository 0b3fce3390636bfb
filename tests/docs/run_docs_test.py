#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every rule of run_docs.py finds a fault made on purpose, and nothing in a clean tree. The program
is a script that knows one command, `adjust BLOCK -o FOLDER [--set KEY=VALUE]`."""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import run_docs  # noqa: E402


PROGRAM = """#!/bin/sh
case "$*" in
  *keys) printf 'adjust\\trobust\\nadjust\\tcorrection.position.degree\\nsimulate\\tpoints.count\\n' ;;
  *markdown) printf '{}' ;;
  --help) printf 'Options:\\n  -h,--help   Help\\n  --set TEXT  Key\\n\\nSubcommands:\\n'
          printf '  adjust  A\\n  simulate  S\\n' ;;
  simulate*) printf 'Options:\\n  -h,--help   Help\\n' ;;
  *--help) printf 'Positionals:\\n  block TEXT REQUIRED  B\\n\\nOptions:\\n  -h,--help   Help\\n'
           printf '  -o,--output TEXT REQUIRED  O\\n' ;;
  *) printf 'rms 1.234 m\\npoints 10\\n'; [ -d "$2" ] || { echo "$2 is no block" >&2; exit 3; } ;;
esac
"""
SCENES = "### `[points]`\n\n| key |\n| --- |\n| `count` |\n"


class RunDocsTest(unittest.TestCase):
    def check(self, page, scenes=SCENES, commands="{}"):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder) / "project"
            (root / "docs").mkdir(parents=True)
            (root / "datasets" / "block").mkdir(parents=True)
            (root / "docs/commands.md").write_text(commands, encoding="utf-8")
            (root / "docs/scenes.md").write_text(scenes, encoding="utf-8")
            (root / "docs/page.md").write_text(page, encoding="utf-8")
            (root / "CMakePresets.json").write_text('{"name": "dev"}', encoding="utf-8")
            program = pathlib.Path(folder) / "sarblock"
            program.write_text(PROGRAM, encoding="utf-8")
            program.chmod(0o755)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                status = run_docs.main(["--program", str(program), "--root", str(root),
                                        "--scratch", str(pathlib.Path(folder) / "scratch")])
            return status, printed.getvalue()

    def accepts(self, page):
        status, output = self.check(page)
        self.assertEqual(status, 0, output)
        return output

    def finds(self, page, part):
        status, output = self.check(page)
        self.assertEqual(status, 1, output)
        self.assertIn(part, output)

    def test_runs_commands_in_order_and_accepts_what_ends_well(self):
        output = self.accepts("    mkdir b\n    sarblock adjust b -o r  # a comment\n\n"
                              "and `sarblock adjust datasets/block -o r` in a line\n")
        self.assertIn("3 run", output)

    def test_finds_a_command_that_fails(self):
        self.finds("text\n\n    sarblock adjust no -o r\n", "docs/page.md:3: ends with 3, not 0")

    def test_finds_an_inline_command_that_fails(self):
        self.finds("see `sarblock adjust no -o r`\n", "docs/page.md:1: ends with 3")

    def test_holds_a_command_to_the_exit_code_stated(self):
        self.accepts("<!-- run: exit 3 -->\n\n    sarblock adjust no -o r\n")
        self.finds("<!-- run: exit 4 -->\n\n    sarblock adjust no -o r\n", "ends with 3, not 4")

    def test_does_not_run_what_is_long_but_checks_it(self):
        self.assertIn("0 run, 1 long", self.accepts("<!-- run: long -->\n\n    sarblock adjust no -o r\n"))
        self.finds("<!-- run: long -->\n\n    sarblock adjust no -o r --speed 3\n",
                   "'--speed' is no option of 'sarblock adjust'")
        self.finds("<!-- run: long -->\n\n    sarblock adjust no -o r --set robst=huber\n",
                   "'robst' is no key of --set for 'sarblock adjust'")
        self.finds("<!-- run: long -->\n\n    sarblock adjust no\n", "needs --output")

    def test_takes_keys_of_numbered_groups(self):
        self.accepts("<!-- run: long -->\n\n"
                     "    sarblock adjust no -o r --set correction.position.0.degree=2\n")

    def test_checks_a_synopsis(self):
        self.accepts("<!-- run: form -->\n\n    sarblock adjust BLOCK -o RESULT [OPTION]...\n")
        self.finds("<!-- run: form -->\n\n    sarblock adjst BLOCK -o RESULT\n", "'adjst' is no command")

    def test_finds_unknown_options_in_inline_code(self):
        self.accepts("`--set KEY=VALUE`, `--set robust=huber`, `sarblock adjust BLOCK`\n")
        self.finds("give `--strong`\n", "'--strong' is an option of no command")
        self.finds("give `--set robst=huber`\n", "'robst' is no key of --set")
        self.finds("`sarblock adjust BLOCK --strong`\n", "'--strong' is no option")

    def test_compares_output(self):
        command = "    sarblock adjust datasets/block -o r\n\n<!-- run: output -->\n```\n"
        self.accepts(command + "rms 1.23 m\npoints 10\n```\n")
        self.accepts(command + "...\npoints 10\n```\n")
        self.accepts(command + "rms ...\npoints 10\n```\n")
        self.finds(command + "points ...\npoints 10\n```\n", "prints something else")
        self.finds(command + "rms 1.30 m\npoints 10\n```\n", "prints something else")
        self.finds(command + "rms 1.23 m\n```\n", "prints something else")

    def test_compares_messages(self):
        command = "<!-- run: exit 3 -->\n\n    sarblock adjust no -o r\n\n<!-- run: messages -->\n```\n"
        self.accepts(command + "no is no block\n```\n")
        self.finds(command + "no is a block\n```\n", "prints something else")

    def test_writes_files(self):
        self.accepts("<!-- run: file b/list.csv -->\n\n```csv\na,b\n```\n\n"
                     "    grep -q a,b b/list.csv\n    sarblock adjust b -o r\n")

    def test_runs_nothing_that_the_page_does_not_show(self):
        self.finds("<!-- run: first mkdir b -->\n\n    sarblock adjust b -o r\n",
                   "'first' is no annotation")
        self.finds("    sarblock adjust build -o r\n", "ends with 3, not 0")

    def test_leaves_out_what_needs_shared_data(self):
        output = self.accepts("<!-- run: shared images/*.xml -->\n\n    sarblock adjust *.xml -o la\n"
                              "    sarblock adjust la -o r\n    sarblock adjust ../shared/b -o r\n"
                              "    sarblock adjust one.xml -o one\n")
        self.assertIn("0 run", output)
        self.assertIn("4 without shared data", output)

    def test_finds_scripts_and_presets_that_do_not_exist(self):
        self.finds("    scripts/gone.sh\n", "there is no scripts/gone.sh")
        self.finds("    cmake --preset gone\n", "there is no preset 'gone'")
        self.accepts("    cmake --preset dev\n")

    def test_finds_an_unknown_annotation(self):
        self.finds("<!-- run: lnog -->\n\n    sarblock adjust no -o r\n", "'lnog' is no annotation")

    def test_holds_the_page_of_scenes_to_the_keys_of_a_scene(self):
        status, output = self.check("", scenes=SCENES + "| `colour` |\n")
        self.assertEqual(status, 1)
        self.assertIn("docs/scenes.md:1: no scene has a key points.colour", output)
        status, output = self.check("", scenes="text\n")
        self.assertEqual(status, 1)
        self.assertIn("the key points.count is missing", output)

    def test_holds_the_page_of_commands_to_what_the_program_prints(self):
        status, output = self.check("", commands="{ }")
        self.assertEqual(status, 1)
        self.assertIn("docs/commands.md:1: the options changed", output)


if __name__ == "__main__":
    unittest.main()
