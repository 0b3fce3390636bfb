#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program on a terminal of 80 columns: progress, verdict, Ctrl-C. Run by ctest as cli/terminal.

Environment: SARBLOCK_PROGRAM the program, SARBLOCK_DATASETS the shipped data sets. A pseudo-terminal
takes standard output and standard error; what arrives is replayed on a screen of lines."""
import fcntl
import os
import pathlib
import pty
import select
import signal
import struct
import subprocess
import tempfile
import termios
import unittest

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
COLUMNS = 80


def screen(text):
    """Lines that stand on a terminal once `text` was written: \\r goes to the margin, ESC [K clears."""
    lines, column = [""], 0
    i = 0
    while i < len(text):
        if text.startswith("\033[K", i):
            lines[-1] = lines[-1][:column]
            i += 3
            continue
        c = text[i]
        if c == "\r":
            column = 0
        elif c == "\n":
            lines.append("")
            column = 0
        else:
            lines[-1] = lines[-1][:column].ljust(column) + c + lines[-1][column + 1:]
            column += 1
        i += 1
    return lines


class Terminal:
    """The program with a pseudo-terminal of 80 columns as its outputs."""

    def __init__(self, *arguments):
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, COLUMNS, 0, 0))
        self.process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL,
                                        stdout=slave, stderr=slave, start_new_session=True)
        os.close(slave)
        self.text = ""

    def read(self, until=None):
        """Reads until `until` has come, or to the end."""
        while until is None or until not in self.text:
            select.select([self.master], [], [])
            try:
                data = os.read(self.master, 65536)
            except OSError:  # the other end is closed
                data = b""
            if not data:
                break
            self.text += data.decode()
        return self.text

    def end(self):
        self.read()
        os.close(self.master)
        return self.process.wait()


class TerminalTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.block = self.folder / "block"
        subprocess.run([PROGRAM, "simulate", SCENES / "block-12-strips.toml", "-o", self.block, "-q"],
                       check=True)

    def adjust(self, runs, *more, out="result"):
        return Terminal("adjust", self.block, "-o", self.folder / out, "--threads", 1, "--set",
                        "covariance=montecarlo", "--set", f"montecarlo_runs={runs}", *more)

    def test_the_bar_is_one_line_and_gone_before_the_verdict(self):
        terminal = self.adjust(700)
        self.assertEqual(terminal.end(), 0)
        bar, verdict = terminal.text.find(" %"), terminal.text.find("block-12-strips: accepted")
        self.assertGreater(verdict, 0)
        self.assertTrue(0 < bar < verdict, "no bar before the verdict")
        for drawn in terminal.text[:verdict].split("\r\033[K"):
            self.assertLess(len(drawn), COLUMNS, drawn)
            self.assertNotIn("\n", drawn)
        lines = screen(terminal.text)
        self.assertEqual(lines[0], "block-12-strips: accepted")
        for line in lines:
            self.assertLessEqual(len(line), COLUMNS, line)
            self.assertNotIn("[=", line)

    def test_an_interrupt_ends_the_line_and_leaves_no_result(self):
        terminal = self.adjust(1000000)
        terminal.read(until=" %")
        os.killpg(terminal.process.pid, signal.SIGINT)
        self.assertEqual(terminal.end(), 1)
        lines = [line for line in screen(terminal.text) if line]
        self.assertEqual(lines, ["sarblock: interrupted during montecarlo"])
        self.assertFalse((self.folder / "result" / "summary.json").exists())

    def test_quiet_is_silent(self):
        terminal = Terminal("adjust", self.block, "-o", self.folder / "result", "-q")
        self.assertEqual(terminal.end(), 0)
        self.assertEqual(terminal.text, "")

    def test_check_fits_the_terminal(self):
        terminal = Terminal("check", self.block)
        self.assertEqual(terminal.end(), 0)
        for line in screen(terminal.text):
            self.assertLessEqual(len(line), COLUMNS, line)

    def test_a_refusal_fits_the_terminal_and_is_one_line_elsewhere(self):
        table = self.block / "points.csv"
        text = table.read_text(encoding="utf-8").replace(",tie,", ",tie and control at once,", 1)
        table.write_text(text, encoding="utf-8")
        piped = subprocess.run([PROGRAM, "check", self.block], capture_output=True, text=True, check=False)
        self.assertEqual(piped.returncode, 3)
        self.assertEqual(piped.stderr.count("\n"), 1)
        self.assertGreater(len(piped.stderr), COLUMNS)
        terminal = Terminal("check", self.block)
        self.assertEqual(terminal.end(), 3)
        lines = [line for line in screen(terminal.text) if line]
        self.assertGreater(len(lines), 1)
        for line in lines:
            self.assertTrue(len(line) <= COLUMNS or " " not in line.strip(), line)
        self.assertEqual(" ".join(line.strip() for line in lines), piped.stderr.strip())


if __name__ == "__main__":
    unittest.main()
