#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every rule of check_docs.py and prerequisites.py finds a fault made on purpose, and nothing in pages
that are right; run by ctest as lint/check_docs_test."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from check_headers_test import CHECKER, SPDX, CheckerTest  # noqa: E402
from prerequisites import hidden  # noqa: E402

READY = "# Page\n\nWith the program ([install](install.md)):\n\n"
SHOWN = "\n<!-- run: output -->\n```\n...\n```\n"


class CheckDocsTest(CheckerTest):
    checker = CHECKER.with_name("check_docs.py")
    page = "# Page\n\n    a = b      (7)\n\n[self](page.md), [web](https://example.org)\n"

    def test_accepts_links_and_citations_that_lead_somewhere(self):
        status, output = self.check({
            "docs/page.md": self.page,
            "include/sarblock/core/a.h": SPDX + "/// docs/page.md, eq.\n/// (7).\n",
        })
        self.assertEqual((status, output), (0, ""))

    def test_finds_a_dead_link(self):
        self.expect_finding("docs/page.md", "text\n[a](b.md#c)\n", "docs/page.md:2: 'b.md'")

    def test_finds_a_dead_anchor(self):
        headings = "# A `b` (c), d\n\n## Two\n\n## Two\n"
        self.expect_finding("docs/page.md", headings + "[x](#three)\n", "page.md has no heading '#three'")
        self.assertEqual(self.check({"docs/page.md": headings + "[x](#a-b-c-d), [y](#two-1)\n",
                                     "docs/other.md": "[x](page.md#two)\n"}), (0, ""))

    def test_finds_code_that_differs_from_its_source(self):
        page = "<!-- code: a.cc part -->\n\n```cpp\nint x = 1;\n```\n"
        source = SPDX + "  // [part]\n  int x = {};\n  // [part]\n"
        self.assertEqual(self.check({"docs/page.md": page, "docs/a.cc": source.format(1)}), (0, ""))
        status, output = self.check({"docs/page.md": page, "docs/a.cc": source.format(2)})
        self.assertEqual((status, output), (1, "docs/page.md:1: differs from [part] in a.cc\n"))
        self.expect_finding("docs/page.md", page, "no part [part] in a.cc")

    def test_finds_a_source_that_is_no_more(self):
        index = {"docs/README.md": "[a](architecture.md)\n", "src/core/a.h": SPDX}
        page = "`core/a` and `core/a.h`,\n`core/b`\n"
        self.assertEqual(self.check({**index, "docs/architecture.md": page[:24]}), (0, ""))
        status, output = self.check({**index, "docs/architecture.md": page})
        self.assertEqual((status, output), (1, "docs/architecture.md:2: no source is 'core/b'\n"))

    def test_finds_a_citation_of_a_missing_page(self):
        self.expect_finding("src/core/a.cc", SPDX + "// docs/gone.md\n", "a.cc:2: docs/gone.md")

    def test_finds_a_citation_of_a_missing_equation(self):
        status, output = self.check({"docs/page.md": self.page,
                                     "src/core/a.cc": SPDX + "// docs/page.md, eqs. (7)-(8)\n"})
        self.assertEqual(status, 1)
        self.assertEqual(output.strip(), "src/core/a.cc:2: docs/page.md has no equation (8)")

    def test_finds_a_page_that_no_index_lists(self):
        index = {"docs/README.md": "[a](a.md), [theory](theory/README.md)\n", "docs/a.md": "a\n",
                 "docs/theory/README.md": "[b](b.md)\n", "docs/theory/b.md": "b\n"}
        self.assertEqual(self.check(index), (0, ""))
        status, output = self.check({**index, "docs/theory/c.md": "c\n"})
        self.assertEqual((status, output), (1, "docs/theory/c.md:1: stands neither in docs/README.md nor in "
                                               "docs/theory/README.md\n"))

    def test_finds_terms_out_of_order_and_names_that_the_reference_does_not_know(self):
        tree = {"docs/formats.md": "`role`\n", "docs/adjust_options.md": "", "docs/commands.md": "",
                "docs/glossary.md": "| term | meaning |\n| --- | --- |\n| block | `role` |\n| look | a |\n"}
        self.assertEqual(self.check(tree), (0, ""))
        tree["docs/glossary.md"] += "| island | `rule` |\n"
        self.assertEqual(self.check(tree), (1, "docs/glossary.md:5: 'island' stands after 'look'\n"
                                               "docs/glossary.md:5: 'rule' stands in no page of reference\n"))

    def test_finds_a_citation_file_of_another_release(self):
        tree = {"CMakeLists.txt": "project(sarblock VERSION 1.2.3)\nset(SARBLOCK_RELEASE_DATE 2026-01-02)\n",
                "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.3\ndate-released: 2026-01-02\n"}
        self.assertEqual(self.check(tree), (0, ""))
        tree["CITATION.cff"] = tree["CITATION.cff"].replace("1.2.3", "1.2.2")
        self.assertEqual(self.check(tree), (1, "CITATION.cff:1: the version is not 1.2.3, that of CMakeLists.txt\n"))


class PrerequisitesTest(unittest.TestCase):
    def findings(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ("datasets/scenes/pair.toml", "scripts/demo.sh", "build/left/over.csv",
                         "result/points.csv", "page.md"):
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

    def test_takes_nothing_that_a_build_or_a_run_left_for_shipped(self):
        self.misses("    head build/left/over.csv\n", "build/left/over.csv")
        self.misses("    sarblock check result\n", "result")
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
