#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every rule of check_headers.py finds a fault made on purpose, and nothing in a clean tree."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECKER = pathlib.Path(__file__).with_name("check_headers.py")
SPDX = "// SPDX-License-Identifier: Apache-2.0\n"


class CheckerTest(unittest.TestCase):
    checker = CHECKER

    def check(self, files):
        """Exit status and output of the checker on a tree of the given files."""
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "include").mkdir()
            (pathlib.Path(folder) / "docs").mkdir()
            for name, text in files.items():
                path = pathlib.Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            done = subprocess.run([sys.executable, str(self.checker), folder], check=False,
                                  capture_output=True, text=True)
            return done.returncode, done.stdout

    def expect_finding(self, name, text, part):
        status, output = self.check({name: text})
        self.assertEqual(status, 1, output)
        self.assertIn(part, output)


class CheckHeadersTest(CheckerTest):
    def test_accepts_a_clean_tree(self):
        status, output = self.check({
            "include/sarblock/geometry/a.h": SPDX + '#include "sarblock/core/b.h"\n'
                                           "double Range(double rho_m, double scale);\n",
            "src/geometry/a.cc": SPDX + '#include "sarblock/geometry/a.h"\n// printf( in a comment\n',
        })
        self.assertEqual((status, output), (0, ""))

    def test_finds_an_include_to_the_right(self):
        self.expect_finding("src/core/a.cc", SPDX + '#include "sarblock/geometry/a.h"\n',
                            "src/core/a.cc:2: layer 'core' must not include 'geometry'")

    def test_orders_rooms_by_private_headers_too(self):
        self.expect_finding("src/normals/a.cc", SPDX + '#include "solve/a.h"\n',
                            "src/normals/a.cc:2: layer 'normals' must not include 'solve'")

    def test_finds_a_circle_of_headers_and_sources(self):
        files = {
            "src/model/a.h": SPDX + '#include "b.h"\n',
            "src/model/a.cc": SPDX + '#include "a.h"\n',
            "src/model/b.h": SPDX + '#include "sarblock/model/c.h"\n',
            "include/sarblock/model/c.h": SPDX,
            "src/model/c.cc": SPDX + '#include "sarblock/model/c.h"\n\n#include "a.h"\n',
        }
        status, output = self.check(files)
        self.assertEqual((status, output),
                         (1, "src/model/c.cc:4: circle of includes: model/a -> model/b -> model/c "
                             "-> model/a\n"))
        files["src/model/c.cc"] = SPDX + '#include "sarblock/model/c.h"\n'
        self.assertEqual(self.check(files), (0, ""))

    def test_finds_a_definition_away_from_its_header(self):
        files = {
            "src/model/a.h": SPDX + "namespace sarblock {\nclass A {\n  int Get() const;\n};\n"
                                    "int Free(int a,\n         int b);\n}  // namespace sarblock\n",
            "src/model/a.cc": SPDX + "int Free(int a,\n         int b) {\n  return a + b;\n}\n",
            "src/model/b.cc": SPDX + "namespace {\nint Free(int a, int b) { return a - b; }\n"
                                     "}  // namespace\n// int Free(int a, int b) {\n"
                                     "int Other() { return Free(1, 2); }\n",
        }
        self.assertEqual(self.check(files), (0, ""))
        files["src/model/b.cc"] += "int A::Get() const {\n  return 1;\n}\n"
        self.assertEqual(self.check(files),
                         (1, "src/model/b.cc:7: defines 'A::Get', which model/a declares\n"))
        files["src/model/b.cc"] = SPDX + "int Free(int a,\n         int b) {\n  return a - b;\n}\n"
        self.assertEqual(self.check(files),
                         (1, "src/model/b.cc:2: defines 'Free', which model/a declares\n"))

    def test_takes_an_inline_header_for_a_part_of_its_unit(self):
        self.assertEqual(self.check({
            "src/model/a.h": SPDX,
            "src/model/a_inline.h": SPDX + '#include "a.h"\n',
            "src/model/a.cc": SPDX + '#include "a.h"\n#include "a_inline.h"\n',
        }), (0, ""))

    def test_finds_a_public_header_that_needs_others(self):
        for include in ('"model/b.h"', '"b.h"'):
            self.expect_finding("include/sarblock/model/a.h", SPDX + f"#include {include}\n",
                                "a.h:2: a public header includes public headers only")

    def test_finds_ceres_in_a_public_header_that_is_not_of_cost(self):
        text = SPDX + "#include <ceres/problem.h>\n"
        self.expect_finding("include/sarblock/model/a.h", text,
                            "a.h:2: only the public headers of 'cost' include Ceres")
        self.assertEqual(self.check({"include/sarblock/cost/a.h": text + "\n" * 40}), (0, ""))

    def test_finds_a_module_without_a_layer(self):
        self.expect_finding("src/odd/a.cc", SPDX, "'odd' is not in LAYERS")

    def test_finds_a_double_without_a_unit(self):
        self.expect_finding("include/sarblock/core/a.h", SPDX + "double height = 0.0;\n",
                            "'height' has no unit suffix")

    def test_finds_a_missing_licence_line(self):
        self.expect_finding("tests/core/a_test.cc", "int main() {}\n", "SPDX")

    def test_finds_a_long_file(self):
        self.expect_finding("src/core/a.cc", SPDX + "\n" * 900, "901 lines")

    def test_finds_too_many_public_headers(self):
        files = {f"include/sarblock/core/a{i}.h": SPDX for i in range(29)}
        self.assertEqual(self.check(files), (1, "include/sarblock/core/a9.h:1: 29 public headers, at most 25\n"))

    def test_finds_a_picture_with_other_arrows_than_the_includes(self):
        page = "```mermaid\nflowchart BT\n  geometry --> core\n  block --> geometry\n```\n"
        files = {
            "docs/architecture.md": page,
            "include/sarblock/core/a.h": SPDX,
            "src/geometry/b.h": SPDX + '#include "sarblock/core/a.h"\n',
            "src/block/c.cc": SPDX + '#include "geometry/b.h"\n#include "sarblock/core/a.h"\n',
        }
        self.assertEqual(self.check(files), (0, ""))
        files["docs/architecture.md"] = page.replace("  block --> geometry\n", "  block --> core\n")
        self.assertEqual(self.check(files), (1, "docs/architecture.md:3: the includes draw other arrows: "
                                                "block --> core, block --> geometry\n"))

    def test_finds_small_files_and_headers_of_one_user_that_no_list_gives_a_reason(self):
        lines = "\n" * 40
        files = {
            "src/core/a.h": SPDX + lines,
            "src/core/a.cc": SPDX + '#include "a.h"\n' + lines,
            "src/core/b.cc": SPDX + '#include "a.h"\n' + lines,
            "src/core/c.cc": SPDX,
            "tests/lint/listed_files.txt": "# a comment\nsmall src/core/c.cc: it ends\nsingle src/core/a.h: b\n",
        }
        self.assertEqual(self.check(files), (0, ""))
        files["src/core/c.cc"] = SPDX + '#include "a.h"\n' + lines
        self.assertEqual(self.check(files), (1, "tests/lint/listed_files.txt:2: 'src/core/c.cc' is not small any more\n"
                                                "tests/lint/listed_files.txt:3: 'src/core/a.h' is not single any more\n"))
        files["src/core/c.cc"] = SPDX
        files["tests/lint/listed_files.txt"] = "small src/core/d.cc\n"
        status, output = self.check(files)
        self.assertEqual(status, 1)
        self.assertEqual(output, "tests/lint/listed_files.txt:1: no line 'small|single FILE: reason'\n"
                                 "src/core/a.h:1: includes of one unit or none: a part of its file, or listed in "
                                 "listed_files.txt\n"
                                 "src/core/c.cc:1: 1 lines: a part of another file, or listed in listed_files.txt with "
                                 "a reason\n")

    def test_finds_a_relative_comparison(self):
        self.expect_finding("tests/core/a_test.cc", SPDX + "a.isApprox(b, 1e-8);\n", "isApprox")

    def test_finds_a_reminder(self):
        self.expect_finding("src/core/a.cc", SPDX + "// TO" "DO: later\n", "a.cc:2: ")

    def test_finds_a_library_that_prints(self):
        self.expect_finding("src/core/a.cc", SPDX + "void F() { std::cout << 1; }\n", "never prints")

    def test_finds_a_machine_flag(self):
        self.expect_finding("src/CMakeLists.txt", "add_compile_options(-march=native)\n", "-march")


if __name__ == "__main__":
    unittest.main()
