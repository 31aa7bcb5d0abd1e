#!/usr/bin/env python3
"""Refuses an include against the flow of the rooms (see ARCHITECTURE.md).

    scripts/check_includes.py [ROOT]

The rooms and their order are read from TRUNNION_ROOMS in CMakeLists.txt. Held here:
  1. a room includes base, itself and rooms to its left, never one to its right, and nothing above the rooms;
  2. a room's private headers (src/<room>/*.hpp) are not seen by other rooms (base's are: it is everybody's ground);
     plan.cpp and job.cpp, which know all rooms, tests and benchmarks may see them;
  3. public headers (include/) include no private ones;
  4. apps see only public headers;
  5. Open CASCADE, Embree and oneTBB appear only in the files that adapt them.
Prints one line per offence, `file:line: what, and what to do`. Exit code: 0 clean, 1 offences, 2 cannot be checked.
"""

import re
import sys
from fnmatch import fnmatch
from pathlib import Path

SUFFIXES = {".hpp", ".h", ".cpp", ".cc", ".inl"}
FOLDERS = ("include", "src", "apps", "tests", "bench")
INCLUDE = re.compile(r'^\s*#\s*include\b\s*(?:"([^"]+)"|<([^>]+)>|(.*))')

# Library -> (which headers are its, where they may stand, what to do otherwise). Tests and benchmarks may use a
# library as a twin or a peer; threads may not even there, or results would depend on more than parallel_for.
ADAPTED = {
    "Open CASCADE": (("*.hxx", "*.lxx"), ("src/part/occt_*", "tests/*", "bench/*"), "move the code to src/part/occt_*.cpp and hand out plain data"),
    "Embree": (("embree*/*",), ("src/check/embree_*", "tests/*", "bench/*"), "move the code to src/check/embree_*.cpp and hand out plain data"),
    "oneTBB": (("tbb/*", "oneapi/*", "execution"), ("src/base/*", "tests/base/*"), "use parallel_for of trunnion/base/parallel.hpp"),
}


def read_rooms(root):
    """The rooms from left to right, as the build has them."""
    text = (root / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"set\(TRUNNION_ROOMS\s+([^)]*)\)", text)
    if not found:
        raise ValueError("CMakeLists.txt: no set(TRUNNION_ROOMS ...), so the order of the rooms is unknown")
    return found.group(1).split()


def includes(text):
    """(line number, header as written, whether in angle brackets) of every include that is not commented out."""
    # Block comments become blank, but keep their line breaks so that the numbers stay right.
    text = re.sub(r"/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.DOTALL)
    for number, line in enumerate(text.splitlines(), start=1):
        match = INCLUDE.match(line)
        if match:
            quoted, angled, computed = match.groups()
            yield number, quoted or angled or computed.strip(), quoted is None


class Checker:
    def __init__(self, root):
        self.root = Path(root)
        self.rooms = read_rooms(self.root)

    def offences(self):
        for folder in FOLDERS:
            for path in sorted((self.root / folder).rglob("*")):
                if path.is_file() and path.suffix in SUFFIXES:
                    yield from self.offences_of(path)

    def offences_of(self, path):
        relative = path.relative_to(self.root)
        here = self.place(relative)
        if here[0] == "stray":
            yield f"{relative}:1: the folder '{here[1]}' is not a room; the rooms are {' '.join(self.rooms)}"
            return
        for number, header, angled in includes(path.read_text(encoding="utf-8", errors="replace")):
            why = self.offence(relative, here, header, angled)
            if why:
                yield f"{relative}:{number}: {why}"

    def place(self, relative):
        """(kind, room): kind is public or private (of a room), top (plan, job), apps, tests or bench."""
        parts = relative.parts
        if parts[0] == "include":
            inside, kind = parts[2:], "public"  # include/trunnion/<room>/...
        elif parts[0] == "src":
            inside, kind = parts[1:], "private"
        else:
            return (parts[0], parts[1] if len(parts) > 2 else None)
        if len(inside) < 2:
            return ("top", None)
        return (kind, inside[0]) if inside[0] in self.rooms else ("stray", inside[0])

    def offence(self, relative, here, header, angled):
        kind, room = here
        if ".." in Path(header).parts and kind not in ("tests", "bench"):
            return f"'{header}' climbs out of its folder; write the path from include/ or src/"
        for library, (patterns, allowed, remedy) in ADAPTED.items():
            if any(fnmatch(header, p) for p in patterns):
                if any(fnmatch(relative.as_posix(), p) for p in allowed):
                    return None
                return f"<{header}> is {library}, which may appear only in {' and '.join(allowed)}: {remedy}"
        target = self.target(relative, header, angled)
        if target is None or kind in ("tests", "bench"):
            return None
        to_kind, to_room = target
        if to_kind == "private" and relative.parts[0] != "src":
            return f"'{header}' is a private header of {to_room}; only public headers (trunnion/...) may be included here"
        if kind in ("apps", "top"):
            return None
        if to_kind == "top":
            return f"room {room} includes '{header}', which stands above all rooms; take what is needed as an argument"
        if self.rooms.index(to_room) > self.rooms.index(room):
            return (f"room {room} includes '{header}' of {to_room}, against the flow {' -> '.join(self.rooms)}; "
                    f"take a function instead (as orientation's Scene does), or move the code")
        if to_kind == "private" and to_room not in (room, "base"):
            return f"room {room} includes '{header}', a private header of {to_room}; put what is needed into include/trunnion/{to_room}/"
        return None

    def target(self, relative, header, angled):
        """Which of our headers this is: (kind, room), or None for a header that is not ours."""
        parts = Path(header).parts
        if parts[0] == "trunnion":
            return self.known("public", parts[1:])
        if angled:
            return None
        if (self.root / "src" / header).is_file():
            return self.known("private", parts)
        beside = self.root / relative.parent / header
        if beside.is_file() and relative.parts[0] in ("include", "src"):
            kind, room = self.place(beside.relative_to(self.root))
            return (kind, room)
        return self.known("private", parts) if parts[0] in self.rooms else None

    def known(self, kind, inside):
        if len(inside) < 2:
            return ("top", None)
        return (kind, inside[0]) if inside[0] in self.rooms else None


def main(arguments):
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    try:
        found = list(Checker(root).offences())
    except (OSError, ValueError) as error:
        print(f"check_includes: {error}", file=sys.stderr)
        return 2
    for line in found:
        print(line)
    if found:
        print(f"{len(found)} includes against the rules of the rooms (ARCHITECTURE.md)")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
