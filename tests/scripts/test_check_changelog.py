"""scripts/check_changelog.py in small repositories made for it."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "check_changelog.py"


@unittest.skipUnless(subprocess.run(["git", "--version"], capture_output=True, check=False).returncode == 0, "git is not installed")
class CheckChangelog(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        # Nothing of the user's own settings, or of a repository around this one, may reach in.
        self.environment = {"PATH": os.environ["PATH"], "HOME": self.folder.name, "GIT_CONFIG_NOSYSTEM": "1", "GIT_CEILING_DIRECTORIES": str(self.root.parent)}

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=T", "-c", "user.email=t@example.org", "-C", self.root, *arguments], env=self.environment, capture_output=True, check=True)

    def write(self, **files):
        for name, text in files.items():
            path = self.root / {"header": "include/trunnion/a.hpp", "source": "src/a.cpp", "log": "CHANGELOG.md"}[name]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    def commit(self, **files):
        self.write(**files)
        self.git("add", "-A")
        self.git("commit", "-m", "x")

    def check(self, **environment):
        done = subprocess.run([sys.executable, "-B", SCRIPT, self.root], env={**self.environment, **environment}, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr

    def start(self):
        self.git("init")
        self.commit(header="1", source="1", log="1")

    def test_without_a_repository_it_says_that_nothing_was_checked(self):
        code, text = self.check()
        self.assertEqual(code, 0)
        self.assertIn("not checked", text)

    def test_a_first_commit_has_nothing_to_be_compared_with(self):
        self.start()
        code, text = self.check()
        self.assertEqual(code, 0)
        self.assertIn("not checked", text)

    def test_a_changed_header_without_a_line_in_the_log_is_refused(self):
        self.start()
        self.commit(header="2")
        code, text = self.check()
        self.assertEqual(code, 1)
        self.assertIn("include/trunnion/a.hpp", text)

    def test_a_changed_header_with_a_line_in_the_log_passes(self):
        self.start()
        self.commit(header="2", log="2")
        self.assertEqual(self.check(), (0, ""))

    def test_a_change_of_sources_alone_needs_no_line(self):
        self.start()
        self.commit(source="2")
        self.assertEqual(self.check(), (0, ""))

    def test_what_is_not_committed_yet_counts_too(self):
        self.start()
        self.commit(source="2")
        self.write(header="2")
        self.assertEqual(self.check()[0], 1)
        self.write(log="2")
        self.assertEqual(self.check(), (0, ""))

    def test_a_new_header_that_git_does_not_know_yet_counts_too(self):
        self.start()
        self.commit(source="2")
        (self.root / "include/trunnion/new.hpp").write_text("1")
        self.assertEqual(self.check()[0], 1)

    def test_another_base_can_be_named(self):
        self.start()
        self.commit(header="2")
        self.commit(source="2")
        self.assertEqual(self.check()[0], 0)
        self.assertEqual(self.check(TRUNNION_BASE="HEAD~2")[0], 1)


if __name__ == "__main__":
    unittest.main()
