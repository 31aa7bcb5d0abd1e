// Descriptions of cutters: what is accepted, what is refused, and with which words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/tools.hpp"

namespace trunnion {
namespace {

using ::testing::HasSubstr;

std::string refusal(const CutterSpec& spec) {
    const auto cutter = Cutter::from(spec);
    if (cutter) return "(accepted)";
    EXPECT_EQ(cutter.error().code, ErrorCode::invalid_input);
    return cutter.error().text();
}

TEST(CutterFrom, SaysWhatIsWrongAndWhichValueItWas) {
    EXPECT_THAT(refusal(bull_spec(10, 6)),
                AllOf(HasSubstr("corner_mm = 6"), HasSubstr("diameter_mm = 10"), HasSubstr("at most 5")));
    EXPECT_THAT(refusal(ball_spec(-3)), AllOf(HasSubstr("diameter_mm"), HasSubstr("-3")));
    EXPECT_THAT(refusal(ball_spec(0)), HasSubstr("diameter_mm"));
    EXPECT_THAT(refusal(ball_spec(std::nan(""))), HasSubstr("diameter_mm"));
    EXPECT_THAT(refusal(ball_spec(std::numeric_limits<double>::infinity())), HasSubstr("diameter_mm"));
    EXPECT_THAT(refusal(bull_spec(10, -1)), AllOf(HasSubstr("corner_mm"), HasSubstr("-1")));
    EXPECT_THAT(refusal(bull_spec(10, std::nan(""))), HasSubstr("corner_mm"));
    CutterSpec spec = ball_spec(10);
    spec.flute = -1;
    EXPECT_THAT(refusal(spec), HasSubstr("flute_mm"));
    spec.flute = 3;
    EXPECT_THAT(refusal(spec), AllOf(HasSubstr("flute_mm = 3"), HasSubstr("5 mm")));
    spec = ball_spec(10);
    spec.open_bottom = true;
    EXPECT_THAT(refusal(spec), HasSubstr("open"));
    spec = bull_spec(10, 1);
    spec.shape = CutterShape::taper;
    spec.half_angle = radians(85);
    EXPECT_THAT(refusal(spec), HasSubstr("half_angle_deg = 85"));
    spec = bull_spec(10, 1);
    spec.shape = CutterShape::barrel;
    EXPECT_THAT(refusal(spec), HasSubstr("barrel_radius_mm"));
    spec.shape = CutterShape::conical;
    spec.barrel_radius = 100;
    EXPECT_THAT(refusal(spec), HasSubstr("flute_mm"));
    spec.shape = CutterShape::tangential;
    spec.flute = 3;
    EXPECT_THAT(refusal(spec), HasSubstr("leave it out"));
    spec.shape = CutterShape::lens;
    spec.flute = 0;
    spec.barrel_radius = 4;
    EXPECT_THAT(refusal(spec), HasSubstr("barrel_radius_mm = 4"));
    spec = bull_spec(10, 1);
    spec.shape = CutterShape::apt;
    spec.apt_e = 3;
    EXPECT_THAT(refusal(spec), HasSubstr("e_mm = 4"));
    spec.apt_e = -1;
    spec.apt_alpha = radians(60);
    spec.apt_beta = radians(-40);
    EXPECT_THAT(refusal(spec), Not(HasSubstr("accepted")));
}

TEST(CutterFrom, SaysWhatIsWrongWithShankAndHolder) {
    CutterSpec spec = bull_spec(10, 1);
    spec.shank = {{10, 10, -5}};
    EXPECT_THAT(refusal(spec), AllOf(HasSubstr("shank"), HasSubstr("length_mm"), HasSubstr("-5")));
    spec.shank = {{10, 10, 5}, {10, 10, 5}};
    EXPECT_THAT(refusal(spec), HasSubstr("only one shank"));
    spec.shank = {};
    spec.holder = {{40, 50, 30}, {0, 50, 30}};
    EXPECT_THAT(refusal(spec), AllOf(HasSubstr("holder 2"), HasSubstr("diameters")));
}

TEST(CutterFrom, KnowsTheTorusOfItsTip) {
    const Cutter bull = make_cutter(bull_spec(25.4, 6));
    EXPECT_DOUBLE_EQ(bull.tip_corner_radius(), 6);
    EXPECT_DOUBLE_EQ(bull.tip_major_radius(), 6.7);
    const Cutter ball = make_cutter(ball_spec(10));
    EXPECT_DOUBLE_EQ(ball.tip_corner_radius(), 5);
    EXPECT_DOUBLE_EQ(ball.tip_major_radius(), 0);
    EXPECT_DOUBLE_EQ(make_cutter(flat_spec(10)).tip_corner_radius(), 0);
}

TEST(CutterFrom, TakesEveryShapeOverSevenOrdersOfMagnitude) {
    AimedRandom random(31);
    for (int i = 0; i < 3000; ++i) {
        const CutterSpec spec = random_spec(random);
        const auto cutter = Cutter::from(spec);
        ASSERT_TRUE(cutter) << name_of(spec.shape) << " D " << spec.diameter << ": " << cutter.error().text() << " (seed "
                            << random.seed() << ")";
        EXPECT_EQ(cutter->pieces().front().profile.convex_in_space(), !spec.open_bottom);
    }
}

TEST(CutterShapeNames, AreReadBackAndMisspellingsAreAnswered) {
    for (const std::string_view name : cutter_shape_names()) EXPECT_EQ(name_of(*cutter_shape(name)), name);
    const auto wrong = cutter_shape("bal");
    ASSERT_FALSE(wrong);
    EXPECT_THAT(wrong.error().message, HasSubstr("did you mean \"ball\"?"));
}

}  // namespace
}  // namespace trunnion
