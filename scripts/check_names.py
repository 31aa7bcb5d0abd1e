#!/usr/bin/env python3
"""Checks names with clang-tidy (.clang-tidy) in the files that changed, or in all.

    scripts/check_names.py --build FOLDER [--all] [--jobs N] [FILE ...]

FOLDER holds compile_commands.json of a configured build. A changed header is looked at through the sources that include it.
Exit code: 0 clean, 1 names to change, 2 cannot be checked.
"""

import argparse
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from changes import changed_files

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("include/", "src/", "apps/", "tests/", "bench/")


def compiled_sources(build):
    """Sources of the project that this build compiles, as seen from ROOT."""
    entries = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    paths = {Path(entry["directory"], entry["file"]).resolve() for entry in entries}
    names = sorted(p.relative_to(ROOT).as_posix() for p in paths if p.is_relative_to(ROOT))
    return [name for name in names if name.startswith(FOLDERS)]


def sources_that_show(changed, sources):
    """The changed sources, and for each changed header the sources that include it by name; all of them for want of one that
    does (a header reached only through other headers)."""
    wanted = {name for name in changed if name in sources}
    text = {name: (ROOT / name).read_text(encoding="utf-8", errors="replace") for name in sources}
    for header in (name for name in changed if name.startswith(FOLDERS) and name.endswith(".hpp")):
        as_written = header.split("/", 1)[1]  # include/trunnion/x.hpp and src/room/x.hpp are both written without the first folder
        include = re.compile(rf'#\s*include\s+"(?:{re.escape(as_written)}|{re.escape(Path(header).name)})"')
        seen_in = [name for name in sources if include.search(text[name])]
        if not seen_in:
            return sources
        # One look is enough: names do not depend on who includes them. The source of the same name, if there is one.
        wanted.add(min(seen_in, key=lambda name: (Path(name).stem != Path(header).stem, name)))
    return sorted(wanted)


def check(build, source):
    """What clang-tidy says of one source and the headers it shows, without its noise."""
    done = subprocess.run(["clang-tidy", "-p", str(build), "--quiet", str(ROOT / source)], capture_output=True, text=True, check=False)
    complaints = [line.removeprefix(f"{ROOT}/") for line in done.stdout.splitlines() if re.match(r".*: (error|warning): ", line)]
    if done.returncode != 0 and not complaints:
        complaints = [f"{source}:1: clang-tidy failed: {done.stderr.strip() or done.stdout.strip()}"]
    return complaints


def main():
    parser = argparse.ArgumentParser(description="Checks names with clang-tidy in the files that changed, or in all.")
    parser.add_argument("--build", type=Path, required=True, help="folder of a configured build")
    parser.add_argument("--all", action="store_true", help="every source, not only changed ones")
    parser.add_argument("--jobs", type=int, default=1, help="sources at a time (default 1)")
    parser.add_argument("files", nargs="*", help="these sources or headers instead of what changed")
    options = parser.parse_args()
    try:
        sources = compiled_sources(options.build)
    except OSError as error:
        print(f"check_names: {error}: configure the build first (./dev build)", file=sys.stderr)
        return 2
    changed = options.files or (None if options.all else changed_files(ROOT))
    chosen = sources if changed is None else sources_that_show(changed, sources)
    print(f"names in {len(chosen)} of {len(sources)} sources", file=sys.stderr)
    with ThreadPoolExecutor(max_workers=max(1, options.jobs)) as pool:
        # A header is shown by many sources: each complaint once.
        complaints = sorted({line for lines in pool.map(lambda source: check(options.build, source), chosen) for line in lines})
    print("\n".join(complaints), end="\n" if complaints else "")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
