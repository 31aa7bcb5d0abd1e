"""scripts/check_includes.py on small trees made for it: each rule refuses its offence, names file and line, and lets the
legal neighbour of that offence pass."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "check_includes.py"
CMAKE = "project(x)\nset(TRUNNION_ROOMS base part path check)\n"


class CheckIncludes(unittest.TestCase):
    def run_on(self, files, cmake=CMAKE):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "CMakeLists.txt").write_text(cmake)
            for name, text in files.items():
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            done = subprocess.run([sys.executable, "-B", SCRIPT, root], capture_output=True, text=True, check=False)
            return done.returncode, done.stdout + done.stderr

    def assert_refused(self, files, *words):
        code, text = self.run_on(files)
        self.assertEqual(code, 1, text)
        for word in words:
            self.assertIn(word, text)

    def assert_accepted(self, files):
        code, text = self.run_on(files)
        self.assertEqual((code, text), (0, ""))

    def test_a_room_may_include_base_itself_and_the_rooms_to_its_left(self):
        self.assert_accepted({
            "include/trunnion/path/path.hpp": '#include "trunnion/base/vec.hpp"\n#include "trunnion/part/part.hpp"\n#include <vector>\n',
            "src/path/path.cpp": '#include "trunnion/path/path.hpp"\n#include "path/own.hpp"\n#include "beside.hpp"\n#include <fmt/format.h>\n',
            "src/path/own.hpp": "", "src/path/beside.hpp": "",
        })

    def test_an_include_to_the_right_is_refused_with_file_and_line(self):
        self.assert_refused({"src/part/part.cpp": '#include <vector>\n\n#include "trunnion/check/check.hpp"\n'},
                            "src/part/part.cpp:3:", "against the flow base -> part -> path -> check")

    def test_a_public_header_is_held_to_the_flow_too(self):
        self.assert_refused({"include/trunnion/path/path.hpp": "#include <trunnion/check/check.hpp>\n"}, "include/trunnion/path/path.hpp:1:")

    def test_base_includes_no_room(self):
        self.assert_refused({"src/base/file.cpp": '#include "trunnion/part/part.hpp"\n'}, "src/base/file.cpp:1:")

    def test_the_private_header_of_another_room_is_refused_even_to_the_left(self):
        self.assert_refused({"src/path/path.cpp": '#include "part/table.hpp"\n', "src/part/table.hpp": ""}, "a private header of part")

    def test_the_private_headers_of_base_are_open_to_every_room(self):
        self.assert_accepted({"src/path/path.cpp": '#include "base/toml.hpp"\n', "src/base/toml.hpp": ""})

    def test_a_public_header_may_not_include_a_private_one_of_its_own_room(self):
        self.assert_refused({"include/trunnion/part/part.hpp": '#include "part/table.hpp"\n', "src/part/table.hpp": ""}, "only public headers")

    def test_the_plan_sees_every_room_and_no_room_sees_the_plan(self):
        self.assert_accepted({"src/plan.cpp": '#include "trunnion/check/check.hpp"\n#include "trunnion/plan.hpp"\n#include "part/table.hpp"\n',
                              "src/part/table.hpp": "", "include/trunnion/plan.hpp": '#include "trunnion/path/path.hpp"\n'})
        self.assert_refused({"src/check/check.cpp": '#include "trunnion/plan.hpp"\n'}, "stands above all rooms")

    def test_apps_see_public_headers_only(self):
        self.assert_accepted({"apps/cli/main.cpp": '#include "trunnion/plan.hpp"\n#include "print.hpp"\n', "apps/cli/print.hpp": ""})
        self.assert_refused({"apps/cli/main.cpp": '#include "part/table.hpp"\n', "src/part/table.hpp": ""}, "apps/cli/main.cpp:1:", "private header of part")

    def test_tests_and_benchmarks_may_see_private_headers(self):
        files = {"tests/part/table_test.cpp": '#include "part/table.hpp"\n', "bench/b.cpp": '#include "part/table.hpp"\n', "src/part/table.hpp": ""}
        self.assert_accepted(files)

    def test_foreign_libraries_stay_in_their_adapters(self):
        self.assert_accepted({"src/part/occt_step.cpp": "#include <gp_Pnt.hxx>\n", "src/base/parallel.cpp": "#include <oneapi/tbb/info.h>\n",
                              "src/check/embree_tree.cpp": "#include <embree3/rtcore.h>\n", "tests/part/twin_test.cpp": "#include <gp_Pnt.hxx>\n"})
        self.assert_refused({"src/part/step.cpp": "#include <gp_Pnt.hxx>\n"}, "src/part/step.cpp:1:", "Open CASCADE", "src/part/occt_*")
        self.assert_refused({"include/trunnion/part/part.hpp": "#include <TopoDS.hxx>\n"}, "Open CASCADE")
        self.assert_refused({"src/check/check.cpp": "#include <tbb/parallel_for.h>\n"}, "oneTBB", "parallel_for")
        self.assert_refused({"tests/check/check_test.cpp": "#include <execution>\n"}, "oneTBB")
        self.assert_refused({"src/check/tree.cpp": "#include <embree3/rtcore.h>\n"}, "Embree")

    def test_an_include_in_a_comment_does_not_count_and_does_not_shift_the_line(self):
        self.assert_accepted({"src/part/part.cpp": '// #include "trunnion/check/check.hpp"\n/*\n#include "trunnion/check/check.hpp"\n*/\n'})
        self.assert_refused({"src/part/part.cpp": '/* one\ntwo */\n#  include   "trunnion/check/check.hpp"\n'}, "src/part/part.cpp:3:")

    def test_climbing_out_of_the_folder_is_refused(self):
        self.assert_refused({"src/path/path.cpp": '#include "../part/table.hpp"\n', "src/part/table.hpp": ""}, "climbs out")

    def test_a_folder_that_is_no_room_is_refused(self):
        self.assert_refused({"src/helpers/misc.cpp": "#include <vector>\n"}, "'helpers' is not a room")

    def test_every_offence_is_reported(self):
        code, text = self.run_on({"src/part/a.cpp": '#include "trunnion/check/check.hpp"\n', "src/base/b.cpp": '#include "trunnion/path/path.hpp"\n'})
        self.assertEqual(code, 1)
        self.assertIn("src/part/a.cpp:1:", text)
        self.assertIn("src/base/b.cpp:1:", text)
        self.assertIn("2 includes", text)

    def test_without_the_list_of_rooms_nothing_is_called_clean(self):
        code, text = self.run_on({}, cmake="project(x)\n")
        self.assertEqual(code, 2)
        self.assertIn("TRUNNION_ROOMS", text)


if __name__ == "__main__":
    unittest.main()
