#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A page that cannot be followed, made on purpose, is found, and a page that can is not; run by ctest
as lint/check_docs_test."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from prerequisites import hidden  # noqa: E402

READY = "# Page\n\nWith the program ([install](install.md)):\n\n"
SHOWN = "\n<!-- run: output -->\n```\n...\n```\n"


class PrerequisitesTest(unittest.TestCase):
    def findings(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ("datasets/scenes/pair.toml", "scripts/demo.sh", "build/left/over.csv", "page.md"):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text if name == "page.md" else "", encoding="utf-8")
            return [message for _, message in hidden(root, root / "page.md")]

    def accepts(self, text):
        self.assertEqual(self.findings(READY + text + SHOWN), [])

    def misses(self, text, *names):
        found = self.findings(READY + text + SHOWN)
        self.assertEqual([message.split("'")[1] for message in found], list(names), found)

    def test_accepts_what_is_shipped_and_what_commands_above_made(self):
        self.accepts("    sarblock simulate datasets/scenes/pair.toml -o b --set points.count=4\n"
                     "    cp -r b wrong && sed -i s/a/b/ wrong/points.csv\n"
                     "    sarblock adjust wrong -o r --rejections b/residuals.csv > log.txt\n"
                     "    head -3 r/p*s.csv | cut -d, -f1 && cat log.txt\n")

    def test_finds_a_folder_that_only_a_hidden_comment_makes(self):
        self.misses("<!-- run: first cp -r b typo -->\n\n    sarblock check typo\n", "typo")

    def test_finds_a_block_that_no_command_made(self):
        self.misses("    sarblock check block\n", "block")
        self.misses("    sarblock import sentinel1 s1a-*.xml -o b\n", "s1a-*.xml")
        self.misses("<!-- run: long -->\n\n    sarblock study tradeoff gone.toml -o t\n", "gone.toml")

    def test_finds_options_redirections_and_readers_of_missing_files(self):
        self.misses("    sarblock simulate datasets/scenes/pair.toml -o b\n"
                    "    sarblock adjust b -o r --rejections old/residuals.csv\n", "old/residuals.csv")
        self.misses("    sed s/a/b/ gone.csv > new.csv\n    wc -l new.csv\n", "gone.csv")

    def test_takes_nothing_that_lies_in_a_build_for_shipped(self):
        self.misses("    head build/left/over.csv\n", "build/left/over.csv")
        self.misses("    ctest --preset dev -R a\n", "build/dev")
        self.accepts("    cmake --preset dev\n    cmake --build --preset dev\n    ctest --preset dev -R a\n")
        self.accepts("    scripts/demo.sh\n    ls build/release\n")

    def test_finds_a_command_whose_order_is_wrong(self):
        self.misses("    sarblock check b\n    sarblock simulate datasets/scenes/pair.toml -o b\n", "b")

    def test_takes_files_fetched_by_commands_shown(self):
        self.accepts("    git clone https://example.org/data\n"
                     "    unzip -j data/product.zip '*/annotation/s1a-iw2-*.xml'\n\n"
                     "    sarblock import sentinel1 s1a-iw2-*.xml -o la\n")

    def test_takes_files_that_stand_in_the_page_under_their_name(self):
        block = "<!-- run: file b/block.toml -->\n\n```toml\na = 1\n```\n\n    sarblock check b\n"
        self.accepts("Save as `b/block.toml`:\n\n" + block)
        self.assertIn("does not name", "".join(self.findings(READY + block + SHOWN)))

    def test_takes_folders_outside_of_which_the_text_tells(self):
        self.misses("    sarblock check ../data/block\n", "../data/block")
        self.accepts("With the test data in `../data`:\n\n    sarblock check ../data/block\n")

    def test_looks_at_commands_inside_sentences(self):
        self.misses("see `sarblock check gone`\n", "gone")
        self.accepts("see `sarblock check BLOCK` and `sarblock --dump-manual markdown`\n")

    def test_asks_where_the_program_comes_from_and_what_it_prints(self):
        command = "    sarblock simulate datasets/scenes/pair.toml -o b\n"
        self.assertIn("no link to install.md", self.findings(command + SHOWN)[0])
        self.assertEqual(self.findings("    scripts/demo.sh\n    PATH=$PWD/build/release/src/cli:$PATH\n"
                                       + command + SHOWN), [])
        self.assertEqual(self.findings(READY + command), ["what it prints is not shown"])
        self.assertEqual(self.findings(READY + "<!-- run: long -->\n\n" + command), [])


if __name__ == "__main__":
    unittest.main()
