#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The manual page and the completion that the program prints; run by ctest as docs/manual.

Usage: manual_test.py SARBLOCK. The completion is run by bash itself; mandoc checks the page where it is
installed."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from definitions import Definitions  # noqa: E402

PROGRAM = ""

COMPLETE = """
source "$1"
COMP_LINE=$2 COMP_POINT=${#2} COMP_WORDBREAKS=$' \\t\\n"\\'><=;|&(:'
read -ra COMP_WORDS <<< "$2"; [[ $2 == *' ' ]] && COMP_WORDS+=("")
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
function_of=$(complete -p sarblock | sed 's/.*-F \\([^ ]*\\) .*/\\1/')
"$function_of" sarblock "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


def printed(*arguments):
    return subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout


class BashTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "script").write_text(printed("--completion", "bash"), encoding="utf-8")
        (cls.path / "a scene.toml").write_text("", encoding="utf-8")
        (cls.path / "scenes").mkdir()
        (cls.path / "run").write_text(COMPLETE, encoding="utf-8")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def complete(self, line):
        done = subprocess.run(["bash", "--norc", "run", "./script", line], cwd=self.path, check=True,
                              capture_output=True, text=True)
        self.assertEqual(done.stderr, "")
        return [word for word in done.stdout.splitlines() if word]

    def test_completes_commands(self):
        self.assertEqual(self.complete("sarblock sim"), ["simulate"])
        self.assertEqual(self.complete("sarblock import "), ["sentinel1", "nisar", "terrasarx", "iceye", "sicd", "images",
                                                             "isis", "csm"])
        self.assertIn("adjust", self.complete("sarblock "))
        self.assertIn("table1", self.complete("sarblock leberl t"))

    def test_completes_options_of_the_command_and_of_every_command(self):
        self.assertEqual(self.complete("sarblock adjust b --rej"), ["--rejections"])
        self.assertEqual(self.complete("sarblock adjust b --thr"), ["--threads"])
        self.assertEqual(self.complete("sarblock check b --forc"), [])
        self.assertIn("--orbit-step-s", self.complete("sarblock import sentinel1 --orbit"))

    def test_completes_the_values_of_an_enumeration(self):
        self.assertEqual(sorted(self.complete("sarblock import sentinel1 a.xml --grid ")),
                         ["check", "control", "none", "tie"])
        self.assertEqual(self.complete("sarblock --completion b"), ["bash"])

    def test_completes_keys_of_set_and_their_values(self):
        self.assertEqual(self.complete("sarblock adjust b --set robust_"), ["robust_scale="])
        self.assertEqual(self.complete("sarblock adjust b --set robust=hu"), ["huber"])
        self.assertEqual(self.complete("sarblock adjust b --set correction.time.bias=t"), ["true"])
        self.assertEqual(self.complete("sarblock simulate s --set points.cou"), ["points.count="])
        self.assertEqual(self.complete("sarblock simulate s --set adjust.robust=tu"), ["tukey"])
        self.assertEqual(self.complete("sarblock leberl table1 --set rob"), [])

    def test_completes_files_and_folders(self):
        self.assertEqual(sorted(self.complete("sarblock simulate ")),
                         ["a scene.toml", "run", "scenes", "script"])
        self.assertEqual(sorted(self.complete("sarblock simulate s -o s")), ["scenes", "script"])
        self.assertEqual(sorted(self.complete("sarblock check s")), ["scenes", "script"])
        self.assertEqual(self.complete("sarblock adjust b --threads "), [])


class ManualTest(unittest.TestCase):
    def test_names_every_command_option_and_key(self):
        page = printed("--dump-manual", "roff").replace("\\-", "-")
        definitions = Definitions(PROGRAM)
        self.assertGreater(len(definitions.commands), 6)
        for path, command in definitions.commands.items():
            self.assertIn(f"\n.SS sarblock {path}", page)
            for option in command["options"]:
                if not option["positional"]:
                    self.assertIn("\n.B " + ", ".join(option["names"]), page)
        for key in definitions.commands["adjust"]["set_keys"]:
            self.assertIn(f"\n.B {key}\n", page)

    def test_passes_mandoc(self):
        if shutil.which("mandoc") is None:
            self.skipTest("no mandoc")
        done = subprocess.run(["mandoc", "-T", "lint", "-W", "warning"], capture_output=True,
                              text=True, input=printed("--dump-manual", "roff"), check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""))


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
