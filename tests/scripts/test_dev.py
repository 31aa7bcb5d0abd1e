"""./dev installs what is missing, only that, and says in one sentence why it cannot. The package tools are stand-ins: nothing is
installed or built."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = (ROOT / "scripts" / "packages.txt").read_text(encoding="utf-8")

# Knows as installed what the file `installed` lists, as dpkg-query -W -f FORMAT NAME would.
DPKG_QUERY = '#!/bin/sh\ngrep -qx "$4" "$HERE/installed" && printf installed || exit 1\n'
APT_GET = '#!/bin/sh\necho "$*" >>"$HERE/apt.log"\n[ ! -e "$HERE/apt-fails" ] || exit 100\n'
CMAKE = '#!/bin/sh\necho "cmake was asked" >&2\nexit 1\n'
SUDO = '#!/bin/sh\nshift\nexec "$@"\n'


def group(name):
    body = LIST.split(f"[{name}]\n")[1].split("\n[")[0]
    return [line.split()[0] for line in body.splitlines() if line and not line.startswith("#")]


class Dev(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = Path(folder.name)
        for name, text in {"dpkg-query": DPKG_QUERY, "apt-get": APT_GET, "cmake": CMAKE, "sudo": SUDO}.items():
            (self.here / name).write_text(text)
            (self.here / name).chmod(0o755)
        # The script works in its own folder: a copy, so that build/ is not this one's.
        (self.here / "project" / "scripts").mkdir(parents=True)
        for name in ("dev", "scripts/packages.txt"):
            (self.here / "project" / name).write_bytes((ROOT / name).read_bytes())

    def dev(self, *arguments, installed=(), **environment):
        (self.here / "installed").write_text("".join(f"{name}\n" for name in installed))
        path = f"{self.here}:/usr/sbin:/usr/bin:/sbin:/bin"
        done = subprocess.run(["bash", self.here / "project" / "dev", *arguments], env={"PATH": path, "HERE": str(self.here), **environment},
                              capture_output=True, text=True, check=False)
        log = self.here / "apt.log"
        asked = log.read_text().splitlines() if log.exists() else []
        return done.returncode, done.stdout + done.stderr, asked

    def test_only_missing_packages_are_installed_after_one_update(self):
        _, text, asked = self.dev("demo", installed=[name for name in group("build") if name not in ("libfmt-dev", "ninja-build")])
        self.assertEqual(len(asked), 2, asked)
        self.assertRegex(asked[0], r"\bupdate$")
        self.assertRegex(asked[1], r" install --no-install-recommends libfmt-dev ninja-build$")
        self.assertIn("cmake was asked", text)

    def test_with_everything_there_apt_is_not_asked(self):
        _, text, asked = self.dev("demo", installed=group("build"))
        self.assertEqual(asked, [])
        self.assertIn("cmake was asked", text)

    def test_a_package_that_cannot_be_had_is_named_and_nothing_is_built(self):
        (self.here / "apt-fails").touch()
        code, text, _ = self.dev("demo", installed=group("build")[1:])
        self.assertNotEqual(code, 0)
        self.assertIn(f"could not install {group('build')[0]}", text)
        self.assertNotIn("cmake was asked", text)

    def test_where_nothing_may_be_installed_it_says_what_to_run(self):
        code, text, asked = self.dev("demo", TRUNNION_NO_INSTALL="1")
        self.assertNotEqual(code, 0)
        self.assertEqual(asked, [])
        self.assertIn("apt-get install --no-install-recommends " + " ".join(sorted(group("build"))), text)

    def test_a_missing_optional_package_does_not_stop_the_tests(self):
        (self.here / "apt-fails").touch()
        _, text, _ = self.dev("test", installed=group("build") + group("test"))
        for name in group("optional"):
            self.assertIn(f"{name} cannot be installed here", text)
        self.assertIn("cmake was asked", text)

    def test_every_verb_is_in_the_help_and_every_other_word_is_refused(self):
        code, text, _ = self.dev("help")
        self.assertEqual(code, 0)
        cases = (ROOT / "dev").read_text(encoding="utf-8").rsplit("case $verb in", 1)[1]
        verbs = {verb for line in re.findall(r"^([a-z |]+)\)", cases, flags=re.MULTILINE) for verb in line.split(" | ")}
        self.assertGreaterEqual(verbs, {"demo", "test", "build", "lint", "format", "bench", "asan", "tsan", "fuzz", "clean"})
        for verb in verbs:
            self.assertIn(f"./dev {verb}", text)
        code, text, _ = self.dev("dance")
        self.assertNotEqual(code, 0)
        self.assertIn("'dance' is not a verb", text)

    def test_every_package_has_its_reason(self):
        for line in LIST.splitlines():
            if line and not line.startswith(("#", "[")):
                self.assertRegex(line, r"^[a-z0-9.+-]+\s+# \S")


if __name__ == "__main__":
    unittest.main()
