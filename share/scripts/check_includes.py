#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that includes run downward only: check_includes.py [ROOT]

Between libraries: core <- storage <- maps <- eval <- slam <- apps. Inside a library
libs/NAME/rooms.txt lists its rooms, the lowest first, one per line:

    room
    room: NAME NAME ...

A room is a folder under src. NAMEs are files (without extension) that belong to it and do
not lie in that folder: public headers, and files directly in src. A public header that is
not named belongs to the room with the source file of its name; what is left belongs to
the room `ground`. A file may include its own room and lower ones, and never itself by way
of others. Exits with 1, naming each include that breaks a rule.
"""

import pathlib
import re
import sys

LIBRARIES = ["core", "storage", "maps", "eval", "slam", "apps"]
SOURCES = {".h", ".cpp", ".inc"}
INCLUDE = re.compile(r'^\s*#\s*include\s+(?:<(superray/[^>]+)>|"([^"]+)")', re.M)


def read_rooms(path):
    """Returns the rooms in order, and the room of each named file."""
    order, named = [], {}
    for line in path.read_text().splitlines():
        line = line.partition("#")[0].strip()
        if not line:
            continue
        room, _, names = line.partition(":")
        order.append(room)
        named.update({name: room for name in names.split()})
    return order, named


class Tree:
    def __init__(self, root):
        self.root = root
        self.errors = []
        self.files = sorted(p for top in ("libs", "apps") for p in (root / top).rglob("*")
                            if p.suffix in SOURCES)
        self.rooms = {}
        for name in LIBRARIES[:-1]:
            path = root / "libs" / name / "rooms.txt"
            if path.exists():
                self.rooms[name] = read_rooms(path)
                self.check_names(name, path)
            else:
                self.errors.append(f"{path.relative_to(root)}: missing")

    def check_names(self, library, path):
        order, named = self.rooms[library]
        folder = self.root / "libs" / library / "src"
        for room in sorted(p.name for p in folder.iterdir() if p.is_dir()):
            if room not in order:
                self.errors.append(f"{path.relative_to(self.root)}: the room {room} is missing")

    def library(self, path):
        parts = path.relative_to(self.root).parts
        return parts[1] if parts[0] == "libs" else "apps"

    def room(self, path):
        """Returns the place of a file's room in its library's order, and its name."""
        library = self.library(path)
        order, named = self.rooms[library]
        source = self.root / "libs" / library / "src"
        if path.stem in named:
            room = named[path.stem]
        elif source in path.parents and path.parent != source:
            room = path.relative_to(source).parts[0]
        elif source in path.parents:
            room = "ground"
        else:
            twins = [p for p in source.glob(f"*/{path.stem}.cpp")]
            room = twins[0].parent.name if len(twins) == 1 else "ground"
        if room not in order:
            return 0, room
        return order.index(room), room

    def included(self, path):
        text = path.read_text()
        for match in INCLUDE.finditer(text):
            public, private = match.groups()
            places = []
            if public:
                places = [self.root / "libs" / public.split("/")[1] / "include" / public]
            else:
                places = [path.parent / private]
                if self.library(path) != "apps":
                    places.append(self.root / "libs" / self.library(path) / "src" / private)
                else:
                    places.append(self.root / "apps" / private)
            for place in places:
                if place.exists():
                    line = text.count("\n", 0, match.start(1 if public else 2)) + 1
                    yield line, place.resolve()
                    break

    def check(self):
        graph = {}
        for path in self.files:
            graph[path] = [target for _, target in self.included(path)]
            for line, target in self.included(path):
                self.check_include(path, line, target)
        self.check_circles(graph)
        return self.errors

    def check_include(self, path, line, target):
        where = f"{path.relative_to(self.root)}:{line}"
        name = target.relative_to(self.root)
        mine, other = self.library(path), self.library(target)
        if LIBRARIES.index(other) > LIBRARIES.index(mine):
            self.errors.append(f"{where}: {mine} includes {name} of the higher {other}")
        elif other == mine and mine in self.rooms:
            (place, room), (target_place, target_room) = self.room(path), self.room(target)
            if target_place > place:
                self.errors.append(f"{where}: room {room} of {mine} includes {name} "
                                   f"of the higher room {target_room}")

    def check_circles(self, graph):
        done, open_files = set(), []

        def visit(path):
            if path in open_files:
                circle = open_files[open_files.index(path):] + [path]
                self.errors.append("circle of includes: " + " -> ".join(
                    str(p.relative_to(self.root)) for p in circle))
            elif path not in done:
                open_files.append(path)
                for target in graph.get(path, []):
                    visit(target)
                open_files.pop()
                done.add(path)

        for path in graph:
            visit(path)


def main():
    default = pathlib.Path(__file__).resolve().parents[2]
    root = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else default
    tree = Tree(root)
    errors = tree.check()
    for error in errors:
        print(error)
    if errors:
        return 1
    print(f"includes of {len(tree.files)} files run downward")
    return 0


if __name__ == "__main__":
    sys.exit(main())
