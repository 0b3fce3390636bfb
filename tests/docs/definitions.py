# SPDX-License-Identifier: Apache-2.0
"""The program's own definitions and command lines held to them."""
import re
import shlex
import subprocess

PLACEHOLDER = re.compile(r"^\[|\]$|\.\.\.|^<|^[A-Z][A-Z0-9_]*(?:\.\w+)?$|=[A-Z]+$")


def scene_keys(root):
    """Keys of a scene in the tables of docs/scenes.md, each after the tables its heading names."""
    keys, tables = set(), []
    for line in (root / "docs/scenes.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            tables = re.findall(r"`\[+([\w.]+)\]+`", line)
        elif line.startswith("| `"):
            for key in re.findall(r"`(\w+)`", line.split("|")[1]):
                keys.update(f"{'flight.0' if table == 'flight' else table}.{key}" for table in tables)
    return keys


class Definitions:
    def __init__(self, program):
        """Commands and options as `--help` prints them, keys of --set as `--dump-manual keys` does."""
        self.program = program
        options, top = self._help([])
        self.common = {**self._options(options), "-h": {"value": ""}, "--help": {"value": ""}}
        self.commands = {}
        for name in top:
            own, below = self._help([name])
            for path in [[name, inner] for inner in below] or [[name]]:
                options = self._help(path)[0] if below else own
                self.commands[" ".join(path)] = {"options": options}
        self.options = {path: self._options(command["options"])
                        for path, command in self.commands.items()}
        self.every_option = set(self.common).union(*self.options.values())
        self.common["--dump-manual"] = {"value": "FORMAT"}
        keys = subprocess.run([program, "--dump-manual", "keys"], check=True, capture_output=True,
                              text=True).stdout
        for path, command in self.commands.items():
            command["set_keys"] = {line.partition("\t")[2] for line in keys.splitlines()
                                   if line.partition("\t")[0] == path}
        self.every_key = set().union(*(command["set_keys"] for command in self.commands.values()))

    def _help(self, path):
        """Options and subcommands of one `--help`."""
        text = subprocess.run([self.program, *path, "--help"], check=True, capture_output=True,
                              text=True).stdout
        options, commands, section = [], [], ""
        for line in text.splitlines():
            heading = re.match(r"^(\w+):", line)
            entry = re.match(r"^  (\S+)(?: (.*))?$", line)
            if heading:
                section = heading.group(1)
            elif entry and section == "Subcommands":
                commands.append(entry.group(1))
            elif entry and not entry.group(1).startswith("-h,"):
                rest = entry.group(2) or ""
                options.append({
                    "names": entry.group(1).split(","), "positional": section == "Positionals",
                    "value": rest.split(" ")[0] if re.match(r"[A-Z]", rest) else "",
                    "required": "REQUIRED" in rest, "several": "..." in rest[:40]})
        return options, commands

    @staticmethod
    def _options(options):
        return {name: option for option in options if not option["positional"]
                for name in option["names"]}

    def path_of(self, words):
        """Longest command path that the words begin with, and how many words it has."""
        for count in (3, 2, 1):
            if " ".join(words[:count]) in self.commands:
                return " ".join(words[:count]), count
        return None, 0

    def key_is_known(self, key, keys):
        plain = re.sub(r"\.\d+(?=\.)", "", key)
        plain = plain.removeprefix("adjust.")
        for known in keys:
            known = re.sub(r"\.\d+(?=\.)", "", known).removeprefix("adjust.")
            if plain == known or known.startswith(plain + "."):
                return True
        return False

    def faults(self, text, form):
        """What is wrong with a command line that begins with `sarblock`, as messages. `form`: a
        synopsis, in which words such as BLOCK, [OPTION]... and a|b stand for what is given."""
        try:
            words = shlex.split(re.split(r"\s[|>&]+\s", text)[0], comments=True)[1:]
        except ValueError as error:
            return [str(error)]
        if form:
            words = [word.strip("[]").removesuffix("...") for word in words]
            words = [word for word in words if word and word != "OPTION"]
            for number, word in enumerate(words):
                if "|" in word and not word.startswith("-"):
                    found = []
                    for choice in word.split("|"):
                        line = words[:number] + [choice] + words[number + 1:]
                        found += self._faults(line, form)
                    return found
        return self._faults(words, form)

    def _faults(self, words, form):
        path, count = self.path_of(words)
        if path is None:
            if words and not words[0].startswith("-") and not (form and len(words) <= 2):
                return [f"'{words[0]}' is no command"]
            if words and not words[0].startswith("-"):
                known = any(p.startswith(words[0]) for p in self.commands)
                return [] if known or PLACEHOLDER.search(words[0]) else [f"'{words[0]}' is no command"]
            path, options = "", dict(self.common)
        else:
            options = {**self.common, **self.options[path]}
        found, given, number = [], set(), count
        positionals = 0
        while number < len(words):
            word = words[number]
            number += 1
            if not word.startswith("-") or re.match(r"^-[\d.]", word) or word == "-":
                positionals += 1
                continue
            name, equals, value = word.partition("=")
            option = options.get(name)
            if option is None:
                found.append(f"'{name}' is no option of 'sarblock {path}'")
                continue
            given.update(option.get("names", [name]))
            if option["value"] == "":
                continue
            if not equals and number < len(words):
                value = words[number]
                number += 1
            while option.get("several") and number < len(words) and name != "--set" \
                    and not words[number].startswith("-"):
                number += 1
            if name == "--set" and not PLACEHOLDER.search(value):
                key = value.partition("=")[0]
                if not self.key_is_known(key, self.commands.get(path, {}).get("set_keys", [])):
                    found.append(f"'{key}' is no key of --set for 'sarblock {path}'")
        if not form and path and "--help" not in given:
            for option in self.commands[path]["options"]:
                if option["required"] and not option["positional"] and not given & set(option["names"]):
                    found.append(f"'sarblock {path}' needs {option['names'][-1]}")
            needed = sum(o["required"] for o in self.commands[path]["options"] if o["positional"])
            if positionals < needed:
                found.append(f"'sarblock {path}' needs {needed} arguments")
        return found

    def is_form(self, text):
        """True for inline code that names a command without being a complete command line."""
        words = text.split()
        return any(PLACEHOLDER.search(word) for word in words) or "|" in text \
            or bool(self.faults(text, form=False))
