#!/usr/bin/env python3
"""Demands a line in CHANGELOG.md when the public headers change.

    scripts/check_changelog.py [ROOT]

Compared are the commit before the last one (TRUNNION_BASE names another) and the working tree. Without history to compare with
(no git, a first commit, a shallow clone) it says so and passes. Exit code: 0 good, 1 the line is missing.
"""

import sys
from pathlib import Path

from changes import base_commit, changed_files

LOG = "CHANGELOG.md"
PUBLIC = "include/"


def main(arguments):
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    changed = changed_files(root)
    if changed is None:
        print(f"check_changelog: there is no commit {base_commit()} to compare with; not checked")
        return 0
    headers = [name for name in changed if name.startswith(PUBLIC)]
    if headers and LOG not in changed:
        more = f" and {len(headers) - 1} more" if len(headers) > 1 else ""
        print(f"{LOG}: {headers[0]}{more} changed since {base_commit()} but {LOG} did not; say under [Unreleased] what it means for a user of the library")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
