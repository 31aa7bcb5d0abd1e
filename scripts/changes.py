"""What changed: shared by the checks that look only at that."""

import os
import subprocess


def base_commit():
    """What the working tree is compared with: the commit before the last one, or the one that TRUNNION_BASE names. So a check
    says the same before a commit as after it."""
    return os.environ.get("TRUNNION_BASE") or "HEAD~1"


def git(root, *arguments):
    """Lines that git prints, or None where it fails (no repository, no such commit, no git)."""
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)
    except OSError:
        return None
    return done.stdout.splitlines() if done.returncode == 0 else None


def changed_files(root):
    """Files, as seen from `root`, that differ between the base commit and the working tree, new ones included; None without
    such a commit."""
    base = base_commit()
    if not git(root, "rev-parse", "--verify", "--quiet", base + "^{commit}"):
        return None
    # --relative: names as seen from root, also when the project is a folder of a larger repository.
    tracked = git(root, "diff", "--relative", "--name-only", base, "--")
    new = git(root, "ls-files", "--others", "--exclude-standard")
    return None if tracked is None or new is None else sorted({*tracked, *new})
