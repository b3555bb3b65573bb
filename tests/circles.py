#!/usr/bin/env python3
"""Finds circles of files: a file that uses an item of another one, which uses, directly or over others, an item of the first.

    python3 tests/circles.py crates/aps-raytrace/src ...

Prints each circle with the items that cause it, and exits with 1 if there is one. Tests are left out, and so are re-exports.
It reads text, not types: methods are seen by nobody, macros only by their name.
"""

import re
import sys
from pathlib import Path

COMMENT_OR_LITERAL = re.compile(
    r"""//[^\n]*|/\*.*?\*/|b?r(?P<hashes>\#*)".*?"(?P=hashes)|b?"(?:\\.|[^"\\])*"|b?'(?:\\[^']+|[^\\'])'""", re.DOTALL
)
TEST = re.compile(r"#\[cfg\((?:all\()?test\b[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*")
INLINE_MODULE = re.compile(r"\bmod\s+(\w+)\s*\{")
MODULE = re.compile(r"\bmod\s+(\w+)\s*;")
USE = re.compile(r"\buse\s+([^;]+);")
DEFINITION = re.compile(r"\b(?:fn|struct|enum|trait|const|static|type|union|macro_rules!)\s+(?:mut\s+)?([A-Za-z_]\w*)")
PATH = re.compile(r"(?<![\w:])(?:[a-z_]\w*)(?:::\w+)+")


def without_literals(text):
    """Replaces comments by nothing and literals by empty strings."""
    return COMMENT_OR_LITERAL.sub(lambda found: "" if found[0].startswith("/") else '""', text)


def closing(text, opening):
    """Returns the place of the brace that closes the one at `opening`."""
    depth = 0
    for place in range(opening, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise ValueError("a brace is not closed")


def without_tests(text):
    while found := TEST.search(text):
        # A field ends with the brace of its struct, what follows it there is lost too.
        end = re.compile("[;{}]").search(text, found.end()).start()
        after = {";": end + 1, "}": end}.get(text[end]) or closing(text, end) + 1
        text = text[: found.start()] + text[after:]
    return text


def outermost(text):
    """Keeps what stands outside of all braces."""
    kept, depth = [], 0
    for character in text:
        depth += {"{": 1, "}": -1}.get(character, 0)
        if depth == 0 or character == "{" and depth == 1:
            kept.append(character)
    return "".join(kept)


def imports(tree):
    """Lists the paths of a `use` tree, each with the name it gets."""
    tree = tree.strip()
    if group := re.fullmatch(r"(.*?)\{(.*)\}", tree, re.DOTALL):
        parts, depth, start = [], 0, 0
        for place, character in enumerate(group[2] + ","):
            depth += {"{": 1, "}": -1}.get(character, 0)
            if character == "," and depth == 0:
                parts.append(group[2][start:place])
                start = place + 1
        return [found for part in parts if part.strip() for found in imports(group[1] + part.strip())]
    path, _, name = tree.partition(" as ")
    path = [part.strip() for part in path.split("::")]
    if path[-1] == "self":
        path.pop()
    return [(name.strip() or path[-1], path)]


class Module:
    """A module of a crate: its file, the items it defines, the names it imports and the rest of its text."""

    def __init__(self, crate, place, file, text, folder):
        self.file, self.children = file, {}
        crate[place] = self
        while found := INLINE_MODULE.search(text):
            end = closing(text, found.end() - 1)
            self.children[found[1]] = place + (found[1],)
            Module(crate, place + (found[1],), file, text[found.end() : end], folder / found[1])
            text = text[: found.start()] + text[end + 1 :]
        for name in MODULE.findall(text):
            for below in (folder / f"{name}.rs", folder / name / "mod.rs"):
                if below.exists():
                    self.children[name] = place + (name,)
                    read(crate, place + (name,), below, folder / name)
        found = [pair for tree in USE.findall(text) for pair in imports(" ".join(tree.split()))]
        self.globs = [path[:-1] for name, path in found if name == "*"]
        self.names = {name: path for name, path in found if name != "*"}
        self.text = USE.sub("", text)
        self.items = set(DEFINITION.findall(outermost(self.text)))


def read(crate, place, file, folder):
    Module(crate, place, file, without_tests(without_literals(file.read_text())), folder)


def resolve(crate, place, path, seen, following=()):
    """Finds the file and the item that a path means in the module at `place`; nothing for what other crates define.

    `seen` are the places and paths of this search; `following` are the imports of this module that lead to the path, of which
    none begins with itself.
    """
    if not path or (place, *path) in seen:
        return None
    seen.add((place, *path))
    first, rest = path[0], path[1:]
    if first in ("crate", "self", "super"):
        return resolve(crate, {"crate": (), "self": place, "super": place[:-1]}[first], rest, seen)
    module = crate[place]
    if first in module.children:
        return resolve(crate, module.children[first], rest, seen)
    if first in module.items:
        return module.file, first
    if first in module.names and first not in following:
        return resolve(crate, place, module.names[first] + rest, seen, (*following, first))
    if following:
        return None
    found = (resolve(crate, place, glob + path, seen, ("*",)) for glob in module.globs)
    return next(filter(None, found), None)


def edges(crate):
    """Tells for each file which items of which other files it uses."""
    used = {}
    for place, module in crate.items():
        words = set(re.findall(r"\w+", module.text))
        paths = [path for name, path in module.names.items() if name in words]
        paths += [path.split("::") for path in PATH.findall(module.text)]
        paths += [[word] for word in words if word not in module.names] if module.globs else []
        for path in paths:
            file, item = resolve(crate, place, path, set()) or (module.file, None)
            if file != module.file:
                used.setdefault(module.file, {}).setdefault(file, set()).add(item)
    return used


def reachable(used, start):
    seen, ahead = set(), [start]
    while ahead:
        for file in used.get(ahead.pop(), ()):
            if file not in seen:
                seen.add(file)
                ahead.append(file)
    return seen


def main(folders):
    are_none = True
    for folder in map(Path, folders):
        crate = {}
        root = next(root for root in (folder / "lib.rs", folder / "main.rs") if root.exists())
        read(crate, (), root, folder)
        used = edges(crate)
        beyond = {file: reachable(used, file) for file in used}
        for file in sorted(used):
            for other in sorted(used[file]):
                if file in beyond.get(other, ()):
                    are_none = False
                    print(f"{file} uses {', '.join(sorted(used[file][other]))} of {other.relative_to(folder)}, which needs it")
    return 0 if are_none else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
