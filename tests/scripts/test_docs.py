"""The documents keep their word: links lead somewhere, and whole jobs shown in docs/ run to a valid plan."""

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("TRUNNION_PROGRAM", "")


def documents():
    return sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def without_code(text):
    return re.sub(r"```.*?```", "", text, flags=re.DOTALL)


def jobs(text):
    """The TOML blocks that are whole jobs: they say what to machine and with what."""
    blocks = re.findall(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    return [block for block in blocks if "[part]" in block and "[cutter]" in block]


class Documents(unittest.TestCase):
    def test_relative_links_lead_to_files_of_the_project(self):
        broken = []
        for document in documents():
            for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", without_code(document.read_text(encoding="utf-8"))):
                if "://" not in link and not (document.parent / link).exists():
                    broken.append(f"{document.relative_to(ROOT)}: {link}")
        self.assertEqual(broken, [])

    def test_every_method_has_its_page_and_every_page_an_example(self):
        pages = {page.stem: jobs(page.read_text(encoding="utf-8")) for page in (ROOT / "docs" / "methods").glob("*.md")}
        table = (ROOT / "include/trunnion/orientation/method.hpp").read_text(encoding="utf-8")
        methods = re.search(r"using Method = std::variant<([^>]*)>", table).group(1)
        for method in (word.strip() for word in methods.split(",")):
            header = (ROOT / f"include/trunnion/orientation/{re.sub('(?<!^)(?=[A-Z])', '_', method).lower()}.hpp").read_text(encoding="utf-8")
            name = re.search(r'name = "([^"]+)"', header).group(1)
            self.assertIn(name, pages, f"docs/methods/{name}.md is missing")
            self.assertTrue(pages[name], f"docs/methods/{name}.md shows no whole job")

    @unittest.skipUnless(PROGRAM, "TRUNNION_PROGRAM is not set")
    def test_jobs_shown_in_the_documents_run_to_a_valid_plan(self):
        for document in documents():
            for number, job in enumerate(jobs(document.read_text(encoding="utf-8"))):
                with self.subTest(f"{document.relative_to(ROOT)} job {number}"), tempfile.TemporaryDirectory() as folder:
                    (Path(folder) / "job.toml").write_text(job, encoding="utf-8")
                    done = subprocess.run([PROGRAM, "plan", "job.toml", "-o", "out", "--quiet"], cwd=folder, capture_output=True, text=True, check=False)
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    self.assertTrue((Path(folder) / "out" / "program.ngc").is_file())


if __name__ == "__main__":
    unittest.main()
