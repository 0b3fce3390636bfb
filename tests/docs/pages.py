# SPDX-License-Identifier: Apache-2.0
"""Markdown pages as the documentation's tests see them: code blocks, inline code, annotations."""
import dataclasses
import re

ANNOTATION = re.compile(r"^<!-- run: (\w+)(?: (.*?))? -->$")
FENCE = re.compile(r"^```(\w*)\s*$")
SPAN = re.compile(r"(?<!`)`([^`]+)`(?!`)")


@dataclasses.dataclass
class Annotation:
    line: int
    kind: str
    argument: str
    done: bool = False


@dataclasses.dataclass
class Block:
    """A code block. `first` and `last` are the line numbers of its text, counted from 1."""
    first: int
    last: int
    language: str
    lines: list
    annotations: list


@dataclasses.dataclass
class Span:
    """Inline code, its blanks normalised; it may run over a line's end."""
    line: int
    text: str
    annotations: list


@dataclasses.dataclass
class Page:
    name: str
    lines: list
    items: list = dataclasses.field(default_factory=list)    # blocks and spans, in order
    annotations: list = dataclasses.field(default_factory=list)


def _spans(page, first, paragraph, annotations):
    text = "\n".join(paragraph)
    for match in SPAN.finditer(text):
        line = first + text.count("\n", 0, match.start())
        page.items.append(Span(line, " ".join(match.group(1).split()), annotations))


def parse(name, text):
    """Blocks, spans and annotations in order. An annotation belongs to the code block that follows
    or, where a paragraph or a table with inline code follows, to that."""
    page = Page(name, text.splitlines())
    lines, number, pending = page.lines, 0, []
    listed = False                       # inside a list: indented lines continue it
    while number < len(lines):
        line = lines[number]
        annotation, fence = ANNOTATION.match(line), FENCE.match(line)
        if not line.strip():
            number += 1
        elif annotation:
            pending.append(Annotation(number + 1, annotation.group(1), annotation.group(2) or ""))
            page.annotations.append(pending[-1])
            number += 1
        elif fence or (line.startswith("    ") and not listed):
            begin = number + 1 if fence else number
            end = begin
            if fence:
                while end < len(lines) and not lines[end].startswith("```"):
                    end += 1
                code = lines[begin:end]
                number = end + 1
            else:
                while end < len(lines) and (lines[end].startswith("    ") or not lines[end].strip()):
                    end += 1
                while not lines[end - 1].strip():
                    end -= 1
                code = [code_line[4:] for code_line in lines[begin:end]]
                number = end
            page.items.append(Block(begin + 1, end, fence.group(1) if fence else "", code, pending))
            pending = []
        else:
            listed = bool(re.match(r"\s*(?:[-*]|\d+\.)\s", line)) or (listed and line.startswith(" "))
            begin = number
            while number < len(lines) and lines[number].strip() and not FENCE.match(lines[number]) \
                    and not ANNOTATION.match(lines[number]):
                number += 1
            found = len(page.items)
            _spans(page, begin + 1, lines[begin:number], pending)
            if len(page.items) > found:
                pending = []
    return page


def logical_lines(block):
    """(line number, text) of a block's shell lines: continuations joined, here-documents whole."""
    number = 0
    while number < len(block.lines):
        begin, text = number, block.lines[number]
        here = re.search(r"<<\s*'?(\w+)'?", text)
        if here:
            while number + 1 < len(block.lines) and block.lines[number].strip() != here.group(1):
                number += 1
            text = "\n".join(block.lines[begin:number + 1])
        else:
            while text.endswith("\\") and number + 1 < len(block.lines):
                number += 1
                text = text[:-1] + " " + block.lines[number].strip()
        number += 1
        if text.strip():
            yield block.first + begin, text.strip()
