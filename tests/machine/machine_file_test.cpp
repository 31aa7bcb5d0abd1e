#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "trunnion/base/file.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kGood = R"(name = "shop"
title = "Shop machine"
tcp = false
rapid_mm_min = 12000
spindle = [0, 0, 2]
work_offset_mm = [1, 2, 3]

[[linear]]
letter = "X"
direction = [1, 0, 0]
travel_mm = [-500, 500]
velocity_mm_min = 30000
acceleration_mm_s2 = 3000
jerk_mm_s3 = 50000

[[linear]]
letter = "Y"
direction = [0, 1, 0]
travel_mm = [-400, 400]
velocity_mm_min = 30000
acceleration_mm_s2 = 3000

[[linear]]
letter = "Z"
direction = [0, 0, 1]
travel_mm = [-100, 600]
velocity_mm_min = 24000
acceleration_mm_s2 = 3000

[[rotary]]
letter = "A"
side = "table"
direction = [1, 0, 0]
point_mm = [0, 0, -60]
sign = -1
travel_deg = [-30, 120]
velocity_deg_min = 9000
acceleration_deg_s2 = 500

[[rotary]]
letter = "C"
side = "table"
direction = [0, 0, 1]
sign = 1
travel_deg = [-360, 360]
velocity_deg_min = 14400
acceleration_deg_s2 = 800
)";

std::string replaced(std::string text, std::string_view from, std::string_view to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(MachineFile, HoldsEveryValueInTheUnitsOfTheCode) {
    const auto m = machine_from_toml(kGood, "shop.toml");
    ASSERT_TRUE(m) << m.error().text();
    EXPECT_EQ(m->name, "shop");
    EXPECT_EQ(m->title, "Shop machine");
    EXPECT_EQ(m->source, "shop.toml");
    EXPECT_FALSE(m->tcp);
    EXPECT_DOUBLE_EQ(m->rapid, 200.0);
    EXPECT_EQ(m->spindle, Vec3(0, 0, 1));
    EXPECT_EQ(m->work_offset, Vec3(1, 2, 3));
    EXPECT_EQ(m->linear[0].limits.jerk, 50000);
    EXPECT_EQ(m->linear[2].limits.lo, -100);
    EXPECT_DOUBLE_EQ(m->linear[2].limits.velocity, 400.0);
    EXPECT_EQ(m->rotary[0].side, Side::table);
    EXPECT_EQ(m->rotary[0].point, Vec3(0, 0, -60));
    EXPECT_EQ(m->rotary[0].sign, -1);
    EXPECT_DOUBLE_EQ(m->rotary[0].limits.hi, radians(120));
    EXPECT_DOUBLE_EQ(m->rotary[1].limits.velocity, radians(240));
    EXPECT_DOUBLE_EQ(m->rotary[1].limits.acceleration, radians(800));
}

struct Mistake {
    const char *from, *to, *message;
};

TEST(MachineFile, EveryMistakeIsNamedWithFileAndLine) {
    const Mistake mistakes[] = {
        {"direction = [1, 0, 0]\ntravel", "direction = [0, 0, 0]\ntravel",
         "shop.toml:10: linear axis X: direction is a zero axis"},
        {"travel_mm = [-400, 400]", "travel_mm = [400, -400]", "shop.toml:19: linear axis Y: travel_mm = [400, -400] is crossed"},
        {"travel_mm = [-400, 400]", "travel_mm = [400, 400]", "shop.toml:19: linear axis Y: travel_mm = [400, 400] is crossed"},
        {"velocity_mm_min = 24000", "velocity_mm_min = 0",
         "shop.toml:27: linear axis Z: velocity_mm_min = 0 must be greater than zero"},
        {"acceleration_deg_s2 = 500", "acceleration_deg_s2 = -5",
         "shop.toml:38: rotary axis A: acceleration_deg_s2 = -5 must be greater than zero"},
        {"travel_deg = [-30, 120]", "travel_dg = [-30, 120]",
         "shop.toml:36: rotary axis A: unknown key \"travel_dg\"; did you mean \"travel_deg\"?"},
        {"rapid_mm_min", "rapid_mm", "shop.toml:4: unknown key \"rapid_mm\"; did you mean \"rapid_mm_min\"?"},
        {"side = \"table\"", "side = \"bed\"", "shop.toml:32: rotary axis A: side = \"bed\" must be \"head\" or \"table\""},
        {"sign = -1", "sign = 2", "shop.toml:35: rotary axis A: sign = 2 must be 1 or -1"},
        {"direction = [0, 0, 1]\nsign", "direction = [-2, 0, 0]\nsign",
         "shop.toml:43: rotary axis C: rotary axes A and C are parallel"},
        {"direction = [0, 1, 0]", "direction = [3, 0, 0]", "shop.toml:25: linear axis Z: the three linear axes lie in one plane"},
        {"spindle = [0, 0, 2]", "spindle = [1, 0, 0]", "shop.toml:33: rotary axis A: rotary axis A is parallel to the spindle"},
        {"letter = \"Y\"", "letter = \"X\"", "shop.toml:17: linear axis X: this letter is used by another axis too"},
        {"letter = \"C\"", "letter = \"Q\"", "shop.toml:41: rotary axis Q: letter = \"Q\" must be one of the letters"},
        {"point_mm = [0, 0, -60]", "point_mm = [0, 0, inf]", "shop.toml:34: rotary axis A: point_mm must be 3 numbers"},
        {"point_mm = [0, 0, -60]", "point_mm = [0, 0]", "shop.toml:34: rotary axis A: point_mm must be 3 numbers"},
        {"name = \"shop\"", "name = shop", "shop.toml:1: "},
        {"name = \"shop\"\n", "", "shop.toml:1: name must be a text in quotes"},
    };
    for (const Mistake& mistake : mistakes) {
        const auto m = machine_from_toml(replaced(kGood, mistake.from, mistake.to), "shop.toml");
        ASSERT_FALSE(m) << mistake.to;
        EXPECT_EQ(m.error().code, ErrorCode::invalid_input);
        EXPECT_THAT(m.error().text(), HasSubstr(mistake.message));
    }
}

TEST(MachineFile, ASectionTooFewIsAnError) {
    const auto m = machine_from_toml(kGood.substr(0, kGood.rfind("[[rotary]]")), "shop.toml");
    ASSERT_FALSE(m);
    EXPECT_THAT(m.error().text(), HasSubstr("needs 2 sections [[rotary]], this file has 1"));
}

TEST(MachineFile, AMissingFileIsNotFound) {
    EXPECT_EQ(load_machine("/nonexistent/machine.toml").error().code, ErrorCode::not_found);
}

TEST(BuiltInMachines, AreThoseOfTheDocumentationAndAllOfThemRead) {
    EXPECT_THAT(built_in_machine_names(),
                ElementsAre("ab-head-head", "ac-head-head", "ac-table-table", "b-head-c-table", "bc-head-head", "bc-table-table",
                            "linuxcnc-5axis", "linuxcnc-xyzac-trt", "linuxcnc-xyzbc-trt", "nutating-head",
                            "nutating-head-c-table", "nutating-table"));
    for (const std::string& name : built_in_machine_names()) {
        const auto m = built_in_machine(name);
        ASSERT_TRUE(m) << name << ": " << m.error().text();
        EXPECT_EQ(m->name, name);
        EXPECT_EQ(m->source, "built-in");
        const auto same = load_machine(std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines" / (name + ".toml"));
        ASSERT_TRUE(same) << same.error().text();
        EXPECT_EQ(same->rotary[1].direction, m->rotary[1].direction);
    }
}

TEST(BuiltInMachines, AMisspeltNameGetsTheNearestOne) {
    const auto m = built_in_machine("ac-tabel-table");
    ASSERT_FALSE(m);
    EXPECT_EQ(m.error().code, ErrorCode::not_found);
    EXPECT_THAT(m.error().text(), HasSubstr("did you mean \"ac-table-table\"?"));
}

TEST(BuiltInMachines, IsoTablesTurnAgainstTheirWordsAndLinuxcncsWithThem) {
    // ISO 841: a positive word moves the tool positively against the work. A = +30: tool axis turned by +30 about X.
    const Vec3 iso = forward(*built_in_machine("ac-table-table"), {0, 0, 0, radians(30), 0}, 100).axis;
    EXPECT_LT((iso - Vec3(0, -0.5, std::cos(radians(30)))).norm(), 1e-15);
    const Vec3 linuxcnc = forward(*built_in_machine("linuxcnc-xyzac-trt"), {0, 0, 0, radians(30), 0}, 100).axis;
    EXPECT_LT((linuxcnc - Vec3(0, 0.5, std::cos(radians(30)))).norm(), 1e-15);
}

}  // namespace
}  // namespace trunnion
