# SPDX-License-Identifier: Apache-2.0
"""What the commands of a page need. A file or folder that a command uses must be made by an earlier
command that the page shows, stand in the page as a block under its name, or be shipped; of a folder
outside the project the text must tell. Before the first
`sarblock` command the page says where the program comes from (a link to install.md or a PATH), and
what is run shows what it prints.

In a `sarblock` command the words before the first option are files; elsewhere a word is a file if it
has a slash or the ending of one."""
import fnmatch
import pathlib
import posixpath
import re
import shlex
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "docs"))
import pages as markdown  # noqa: E402

PLACEHOLDER = re.compile(r"^\[|\]$|\.\.\.|^<|^[A-Z][A-Z0-9_]*(?:\.\w+)?$|=[A-Z]+$")
ENDING = re.compile(r"^[\w*?.-]+\.(?:csv|gz|toml|xml|json|html|txt|EOF|snx|svg|gpkg|kml|deb|zip)$")
FIRST = (r"(?:awk|cat|cd|cmake|cp|cpack|ctest|cut|git|grep|gzip|head|ls|mkdir|mv|ninja|python3|sarblock|sed|sort"
         r"|source|sudo|tail|unzip|wc|zcat)(?: |$)|(?:scripts|build)/")
BELOW = {"import", "plan", "study", "leberl"}  # commands of the program with commands of their own
LANGUAGES = {"", "sh", "bash", "console"}
SHIPPED = {"cmake", "datasets", "docs", "include", "scripts", "src", "tests"}  # not what lies beside them
INSTALL = re.compile(r"\]\([\w./]*install\.md[)#]")


def is_file(word):
    return ("/" in word and "://" not in word) or bool(ENDING.match(word))


class Reader:
    """What a reader has who has followed the page so far."""

    def __init__(self, root):
        self.root, self.here, self.made = root, "", []

    def path(self, word):
        return posixpath.normpath(posixpath.join(self.here, word.removeprefix("$PWD/")))

    def make(self, word):
        self.made.append(self.path(word))

    def has(self, word):
        path = self.path(word)
        if any(path == made or path.startswith(made + "/") or made.startswith(path + "/")
               or fnmatch.fnmatch(made, path) or fnmatch.fnmatch(path, made) for made in self.made):
            return True
        if path.startswith(("/", "..")):
            return path.startswith("/")  # of the system
        return path == "." or (path.split("/")[0] in SHIPPED and any(self.root.glob(path)))


def commands(text):
    """The commands of a line, each as its words; a redirection is a word `>` before its file."""
    lexer = shlex.shlex(text, posix=True, punctuation_chars="|&;<>")
    lexer.whitespace_split, lexer.commenters = True, "#"
    words = []
    for token in lexer:
        if re.fullmatch(r"[|&;]+", token):
            yield words
            words = []
        else:
            words.append(token)
    yield words


def sarblock(words):
    """Files used and files made by a `sarblock` command, of its words after the first."""
    used, made, first = [], [], bool(words) and not words[0].startswith("-")
    if words[:1] == ["convert"]:
        plain = [word for word in words[1:] if not word.startswith("-")]
        return plain[:1], plain[1:]
    words = words[2 if words and words[0] in BELOW else 1:]
    while words:
        word, *words = words
        name, equals, value = word.partition("=")
        if name in ("-o", "--output", "--set", ">"):
            if not equals and words:
                value, *words = words
            made += [] if name == "--set" else [value]
        elif word.startswith("-"):
            first = False
        elif first or is_file(word):
            used.append(word)
    return used, made


def copied(plain):
    return plain[:-1], [plain[-1], *(posixpath.join(plain[-1], posixpath.basename(word))
                                     for word in plain[:-1])]


def cmake(rest, plain):
    preset = re.search(r"--preset (\w+)", " ".join(rest))
    build = [f"build/{preset.group(1)}"] if preset else []
    folders = [word for word in plain if word.startswith("build/")]
    return (build + folders, []) if {"--build", "--install"} & set(rest) else ([], build + folders)


def other(words):
    """Files used and files made by a command of another program."""
    first, rest = words[0], words[1:]
    made = [after for before, after in zip(words, rest) if before in (">", "-o", "--output", "--keep")]
    patterns = [after for before, after in zip(words, rest) if before == "-e"]
    plain = [word for word in rest if not word.startswith("-") and word not in (">", *made, *patterns)]
    files = [word for word in plain if is_file(word)]
    if first in ("cp", "mv"):
        return copied(plain)
    if first == "mkdir":
        return [], plain
    if first == "git":
        return [], [posixpath.basename(plain[-1])] if "clone" in rest else []
    if first == "unzip":
        return plain[:1], [posixpath.basename(word) for word in plain[1:]]
    if first == "cpack":
        return [], ["*.deb"]
    if first == "cmake":
        return cmake(rest, plain)
    if first == "ctest":
        return [f"build/{name}" for name in re.findall(r"--preset (\w+)", " ".join(rest))], []
    if first in ("scripts/demo.sh", "scripts/test.sh"):
        return [first], ["build/release", "build/demo"]
    if first.startswith("scripts/"):  # a folder among its arguments may be one that it makes
        return [first, *(word for word in files if word.count("/") > 1)], []
    if first in ("awk", "grep") or (first == "sed" and "-e" not in rest):
        return [word for word in plain[1:] if is_file(word)], made
    return ([first] if "/" in first else []) + files, made


def needs(reader, text):
    """Files that a line uses and the reader has not; what it makes, the reader has from here on."""
    text = re.sub(r"^(?:\w+=\S+\s+)+(?=\S)", "", text.removeprefix("$ ").split("\n")[0])
    if text.startswith("PATH="):
        return [word for word in text[5:].split(":") if "$PWD" in word and not reader.has(word)]
    if not re.match(FIRST, text):
        return []
    missing = []
    for words in filter(None, commands(text)):
        if words[0] == "cd":
            reader.here = reader.path(words[1])
        used, made = sarblock(words[1:]) if words[0] == "sarblock" else other(words)
        missing += [word for word in used if not PLACEHOLDER.search(word) and not reader.has(word)]
        for word in made:
            reader.make(word)
    return missing


def hidden(root, path):
    """(line, finding) of everything that who reads this page alone could not follow or compare."""
    page = markdown.parse(path.name, path.read_text(encoding="utf-8"))
    written_by_program = path.name == "commands.md"
    reader, ready, silent, above = Reader(root), path.name == "install.md", None, 0
    for item in page.items:
        kinds = {a.kind: a.argument for a in item.annotations}
        lines, is_block = [], isinstance(item, markdown.Block)
        if "form" in kinds:
            continue
        if not is_block:
            if item.text.startswith("../"):
                reader.make(item.text)  # a folder outside the project, of which the text tells
            lines = [(item.line, item.text)] if " " in item.text else []
        elif "file" in kinds:
            if f"`{kinds['file']}`" not in "\n".join(page.lines[above:item.first]):
                yield item.first, f"the text above the block does not name '{kinds['file']}'"
            reader.make(kinds["file"])
        elif "output" in kinds or "messages" in kinds:
            silent = None
        elif item.language in LANGUAGES:
            lines = list(markdown.logical_lines(item))
        above = item.last if is_block else above
        for number, text in lines:
            ready = ready or text.startswith("PATH=") or written_by_program \
                or bool(INSTALL.search("\n".join(page.lines[:number])))
            if is_block and text.startswith("sarblock") and not ready:
                yield number, "no link to install.md above says where the program comes from"
                ready = True
            for word in needs(reader, text):
                yield number, f"'{word}': no command above makes it, and it is not shipped"
        if is_block and any(text.startswith("sarblock") for _, text in lines):
            if silent:
                yield silent, "what it prints is not shown"
            silent = None if "long" in kinds or written_by_program else lines[-1][0]
    if silent:
        yield silent, "what it prints is not shown"
