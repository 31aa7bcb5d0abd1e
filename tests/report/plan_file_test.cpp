#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <nlohmann/json.hpp>

#include "report/plan_layout.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Documents aimed at trouble: every bit pattern of a double, absent values, odd strings.
class RandomPlan {
public:
    explicit RandomPlan(std::uint64_t seed) : random_(seed) {}

    PlanDocument make() {
        PlanDocument plan;
        const std::size_t n = below(4) == 0 ? 0 : 1 + below(40);
        plan.trunnion = text();
        plan.job_json = fmt::format(R"({{"part": {{"file": {}}}, "n": [1, 2.50, -0.0]}})",
                                    nlohmann::json("<\"" + std::to_string(below(99))).dump());
        for (std::size_t first = 0; first < n;) {
            const std::size_t count = 1 + below(n - first);
            plan.passes.push_back({first, count, std::array{"cut", "lead-in", "lead-out", "link"}[below(4)]});
            first += count;
        }
        report::for_each_pose_array(plan, [&](std::string_view key, auto& array) {
            if (key == "cl" || key == "axis" || below(4) > 0) fill(array, n);
        });
        for (Vec3& axis : plan.axis) axis = Vec3(normal_(random_), normal_(random_), normal_(random_)).normalized();
        for (auto* flags : {&plan.valid, &plan.given})
            for (auto& flag : *flags) flag &= 1;
        for (std::size_t k = below(3); k > 0; --k) fill(plan.extra["extra " + std::to_string(k)], below(2) * n);
        plan.machine_name = text();
        for (std::size_t k = below(6); k > 0; --k) plan.axes.push_back(text());
        report::for_each_machine_array(plan, [&](std::string_view, auto& array) {
            if (below(3) > 0) fill(array, n);
        });
        for (std::size_t k = below(3); k > 0; --k) plan.checks.push_back({text(), text(), text(), below(2) == 0});
        for (std::size_t k = below(3); k > 0; --k) plan.timings_s[text()] = number();
        for (std::size_t k = below(3); k > 0; --k) plan.warnings.push_back(text());
        plan.interrupted = below(3) == 0;
        return plan;
    }

private:
    std::size_t below(std::size_t n) { return random_() % n; }
    double number() {
        switch (below(8)) {
            case 0:
                return kNaN;
            case 1:
                return std::array{0.0,       -0.0,
                                  kInfinity, -kInfinity,
                                  1e22,      123456789012345680000.0,
                                  5e-324,    std::numeric_limits<double>::max()}[below(8)];
            case 2:
                return static_cast<double>(static_cast<std::int64_t>(random_()));
            case 3:
                return std::round(normal_(random_) * 1e5) / 1e3;
            case 4: {
                const double any = std::bit_cast<double>(random_());
                return std::isnan(any) ? kNaN : any;
            }
            default:
                return normal_(random_) * 100;
        }
    }
    std::string text() {
        std::string all;
        for (std::size_t k = below(12); k > 0; --k)
            all += std::array<std::string, 10>{
                "a", "\"", "\\", "\n", std::string(1, '\0'), "\x1f", "é", "刀", "😀", "</script>"}[below(10)];
        return all;
    }
    void fill(std::vector<double>& array, std::size_t n) {
        make_each(array, n, [&] { return number(); });
    }
    void fill(std::vector<Vec2>& array, std::size_t n) {
        make_each(array, n, [&] { return Vec2(number(), number()); });
    }
    void fill(std::vector<Vec3>& array, std::size_t n) {
        make_each(array, n, [&] { return Vec3(number(), number(), number()); });
    }
    void fill(std::vector<std::string>& array, std::size_t n) {
        make_each(array, n, [&] { return text(); });
    }
    void fill(std::vector<std::int32_t>& array, std::size_t n) {
        make_each(array, n, [&] { return static_cast<std::int32_t>(random_()); });
    }
    void fill(std::vector<std::uint8_t>& array, std::size_t n) {
        make_each(array, n, [&] { return static_cast<std::uint8_t>(random_()); });
    }
    void fill(std::vector<std::array<double, 5>>& array, std::size_t n) {
        make_each(array, n, [&] { return std::array{number(), number(), number(), number(), number()}; });
    }
    template <class T, class Make>
    void make_each(std::vector<T>& array, std::size_t n, Make&& make) {
        for (std::size_t i = 0; i < n; ++i) array.push_back(make());
    }
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
};

std::uint64_t bits(double x) {
    return std::bit_cast<std::uint64_t>(x);
}
std::vector<std::uint64_t> all_bits(const PlanDocument& plan) {
    std::vector<std::uint64_t> all;
    struct Collect {
        std::vector<std::uint64_t>& all;
        void operator()(double x) const { all.push_back(bits(x)); }
        void operator()(const Vec2& x) const {
            for (const double c : {x.x(), x.y()}) all.push_back(bits(c));
        }
        void operator()(const Vec3& x) const {
            for (const double c : {x.x(), x.y(), x.z()}) all.push_back(bits(c));
        }
        void operator()(const std::array<double, 5>& x) const {
            for (const double c : x) all.push_back(bits(c));
        }
        void operator()(std::int32_t x) const { all.push_back(static_cast<std::uint64_t>(x)); }
        void operator()(std::uint8_t x) const { all.push_back(x); }
        void operator()(const std::string& x) const {
            for (const char c : x + "|") all.push_back(static_cast<std::uint64_t>(c));
        }
    } collect{all};
    const auto each = [&](std::string_view key, const auto& array) {
        collect(std::string(key));
        for (const auto& x : array) collect(x);
    };
    report::for_each_pose_array(plan, each);
    report::for_each_machine_array(plan, each);
    for (const auto& [key, array] : plan.extra) each(key, array);
    for (const auto& [stage, seconds] : plan.timings_s) {
        collect(stage);
        collect(seconds);
    }
    for (const auto& pass : plan.passes) {
        collect(pass.kind);
        all.push_back(pass.first);
        all.push_back(pass.count);
    }
    for (const auto& check : plan.checks) {
        collect(check.what);
        collect(check.bound);
        collect(check.engine);
        all.push_back(check.holds);
    }
    for (const auto* words : {&plan.warnings, &plan.axes}) each("", *words);
    for (const auto* word : {&plan.trunnion, &plan.job_json, &plan.metrics_json, &plan.machine_name}) collect(*word);
    all.push_back(plan.interrupted);
    return all;
}

PlanDocument small_plan() {
    PlanDocument plan;
    plan.trunnion = "0.1.0";
    plan.job_json = "{}";
    plan.passes = {{0, 2, "cut"}};
    plan.cl = {{0, 0, 1}, {1, 0, 1}};
    plan.axis = {{0, 0, 1}, {0, 0.6, 0.8}};
    plan.valid = {1, 0};
    plan.why = {"", "gouge of 0.2 mm"};
    plan.time_s = {0, 1.5};
    return plan;
}

std::string edited(const std::function<void(nlohmann::ordered_json&)>& edit) {
    auto json = nlohmann::ordered_json::parse(plan_to_json(small_plan()));
    edit(json);
    return json.dump();
}

std::string refusal(std::string_view text) {
    const auto plan = plan_from_json(text);
    EXPECT_FALSE(plan);
    if (plan) return "";
    EXPECT_EQ(plan.error().code, ErrorCode::unreadable);
    return plan.error().message;
}

RC_GTEST_PROP(PlanFile, ReadsBackBitForBitWhatItWrote, (std::uint64_t seed)) {
    const PlanDocument plan = RandomPlan(seed).make();
    const std::string text = plan_to_json(plan);
    const auto again = plan_from_json(text);
    if (!again) RC_FAIL(again.error().text() + "\n" + text);
    RC_ASSERT(all_bits(*again) == all_bits(plan));
    RC_ASSERT(plan_to_json(*again) == text);
}

RC_GTEST_PROP(PlanFile, IsJsonThatAnIndependentReaderUnderstandsAlike, (std::uint64_t seed)) {
    const PlanDocument plan = RandomPlan(seed).make();
    const auto json = nlohmann::json::parse(plan_to_json(plan));
    RC_ASSERT(json["poses"]["cl"].size() == plan.size());
    for (std::size_t i = 0; i < plan.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            RC_ASSERT(bits(json["poses"]["axis"][i][k].get<double>()) == bits(plan.axis[i][static_cast<Eigen::Index>(k)]));
        if (i < plan.lead_deg.size() && std::isfinite(plan.lead_deg[i]))
            RC_ASSERT(bits(json["poses"]["lead_deg"][i].get<double>()) == bits(plan.lead_deg[i]));
        if (i < plan.why.size()) RC_ASSERT(json["poses"]["why"][i].get<std::string>() == plan.why[i]);
    }
}

RC_GTEST_PROP(PlanFile, RefusesEveryTruncatedFile, (std::uint64_t seed, std::uint64_t where)) {
    const std::string text = plan_to_json(RandomPlan(seed).make());
    const std::size_t end = text.size() - 1;  // without the newline it is complete
    RC_ASSERT(!plan_from_json(std::string_view(text).substr(0, where % end)));
}

RC_GTEST_PROP(PlanFile, SurvivesAnyChangedByte, (std::uint64_t seed, std::uint64_t where, char byte)) {
    std::string text = plan_to_json(RandomPlan(seed).make());
    text[where % text.size()] = byte;
    if (const auto plan = plan_from_json(text)) RC_ASSERT(plan_from_json(plan_to_json(*plan)).has_value());
}

TEST(PlanFile, HasTheKeysOfTheDesignInOrder) {
    const auto json = nlohmann::ordered_json::parse(plan_to_json(small_plan()));
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    EXPECT_EQ(keys, (std::vector<std::string>{"trunnion", "schema", "job", "passes", "poses", "machine", "metrics", "checks",
                                              "timings_s", "warnings"}));
    EXPECT_EQ(json["passes"].dump(), R"([[0,2,"cut"]])");
    EXPECT_EQ(json["poses"]["valid"].dump(), "[true,false]");
}

TEST(PlanFile, WritesBytesThatAreNotUtf8AsReplacementCharacters) {
    PlanDocument plan = small_plan();
    // A lone continuation byte, an overlong slash, a surrogate, a truncated sequence.
    plan.why = {"a\x80z", "\xC0\xAF \xED\xA0\x80 \xE2\x82"};
    const auto again = plan_from_json(plan_to_json(plan));
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->why[0], "a\uFFFDz");
    EXPECT_EQ(again->why[1], "\uFFFD\uFFFD \uFFFD\uFFFD\uFFFD \uFFFD\uFFFD");
}

TEST(PlanFile, IsTheSameTextForManyPosesWrittenInChunks) {
    PlanDocument plan;
    plan.job_json = "{}";
    std::string expected = "\"cl\": [";
    for (int i = 0; i < 20'000; ++i) {
        plan.cl.emplace_back(i, 0.5, -i);
        plan.axis.emplace_back(0, 0, 1);
        expected += fmt::format("{}[{},0.5,{}]", i > 0 ? "," : "", i, i > 0 ? fmt::format("-{}", i) : "0");
    }
    EXPECT_NE(plan_to_json(plan).find(expected + "]"), std::string::npos);
}

TEST(PlanFile, RefusesAnotherSchema) {
    EXPECT_EQ(refusal(edited([](auto& json) { json["schema"] = 7; })), "the plan has schema 7 but this program reads schema 1");
    EXPECT_EQ(refusal(edited([](auto& json) { json["schema"] = "1"; })), "schema must be a whole number");
    EXPECT_EQ(refusal(edited([](auto& json) { json.erase("schema"); })), "the plan has no schema");
}

TEST(PlanFile, RefusesArraysOfUnequalLength) {
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["valid"].push_back(true); })),
              "poses.valid has 3 entries but poses.cl has 2, both must have one per pose");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["my_deg"] = {1.0}; })),
              "poses.my_deg has 1 entries but poses.cl has 2, both must have one per pose");
    EXPECT_EQ(refusal(edited([](auto& json) { json["machine"]["time_s"].erase(1); })),
              "machine.time_s has 1 entries but poses.cl has 2, both must have one per pose");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"].erase("axis"); })),
              "poses.axis has 0 entries but poses.cl has 2, every pose needs its axis");
}

TEST(PlanFile, RefusesAnAxisThatIsNotADirection) {
    EXPECT_EQ(refusal(edited([](auto& json) {
                  json["poses"]["axis"][1] = {0, 0.6, 0.9};
              })).substr(0, 27),
              "poses.axis[1] has length 1.");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["axis"][0] = nullptr; })),
              "poses.axis[0] has length nan but must have length 1 to within 1e-06");
    // 0.9e-6 too long still passes, 1.1e-6 does not.
    EXPECT_TRUE(plan_from_json(edited([](auto& json) { json["poses"]["axis"][0] = {0, 0, 1.0000009}; })));
    EXPECT_FALSE(plan_from_json(edited([](auto& json) { json["poses"]["axis"][0] = {0, 0, 1.0000011}; })));
}

TEST(PlanFile, RefusesWhatIsNotANumberWithItsKeyAndIndex) {
    EXPECT_EQ(refusal(edited([](auto& json) { json["machine"]["time_s"][1] = "soon"; })),
              "machine.time_s[1] must be a number or null but is a string");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["cl"][1] = {1, 2}; })), "poses.cl[1] must have 3 numbers but has 2");
    EXPECT_EQ(refusal(edited([](auto& json) {
                  json["poses"]["cl"][1] = {1, 2, 3, 4};
              })),
              "poses.cl[1] must have 3 numbers but has more");
    EXPECT_EQ(refusal(edited([](auto& json) {
                  json["poses"]["cl"][0] = {1, 2, true};
              })),
              "poses.cl[0] must be a number or null but is true or false");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["valid"][0] = 1; })), "poses.valid[0] must be true or false");
    EXPECT_EQ(refusal(edited([](auto& json) {
                  json["machine"]["branch"] = {0, 256};
              })),
              "machine.branch[1] must be a whole number from 0 to 255");
    EXPECT_EQ(refusal(edited([](auto& json) { json["poses"]["why"][0] = 3; })), "poses.why[0] must be a string but is a number");
}

TEST(PlanFile, RefusesPassesThatDoNotCoverThePoses) {
    EXPECT_EQ(refusal(edited([](auto& json) { json["passes"][0][1] = 3; })),
              "passes[0] has 3 poses from 0 on but there are only 2 poses");
    EXPECT_EQ(refusal(edited([](auto& json) { json["passes"][0][1] = 1; })), "the passes end at pose 1 but there are 2 poses");
    EXPECT_EQ(refusal(edited([](auto& json) { json["passes"][0][0] = 1; })),
              "passes[0] begins at pose 1 but must begin at pose 0");
    EXPECT_EQ(refusal(edited([](auto& json) { json["passes"][0][2] = "jump"; })),
              "passes[0] is a \"jump\", which is none of cut, lead-in, lead-out, link");
}

TEST(PlanFile, RefusesUnknownAndRepeatedKeys) {
    EXPECT_EQ(refusal(edited([](auto& json) { json["colour"] = "red"; })), "colour is not a key of a plan");
    std::string text = plan_to_json(small_plan());
    text.insert(1, "\"schema\": 1,");
    EXPECT_EQ(refusal(text), "schema is there twice");
}

TEST(PlanFile, RefusesWhatIsNotJsonAndSaysWhere) {
    EXPECT_EQ(refusal(""), "not a plan: not JSON text (Empty: no JSON found)");
    EXPECT_EQ(refusal("[1, 2]"), "a plan is a JSON object, this is something else");
    std::string text = plan_to_json(small_plan());
    const std::size_t offset = text.find("1.5");
    text.replace(offset, 3, "1.x");
    const std::string message = refusal(text);
    EXPECT_NE(message.find(fmt::format("near byte {}", offset)), std::string::npos) << message;
    EXPECT_EQ(refusal(plan_to_json(small_plan()) + "{}"), "something follows the end of the plan");
    EXPECT_EQ(refusal(edited([](auto&) {}).replace(0, 1, "{\"job\": {\"a\": 01},")), "job is not valid JSON");
}

TEST(PlanFile, WillNotWriteWhatItWouldNotRead) {
    PlanDocument plan = small_plan();
    plan.time_s.pop_back();
    EXPECT_THROW(plan_to_json(plan), std::logic_error);
    plan = small_plan();
    plan.job_json = "{";
    EXPECT_THROW(plan_to_json(plan), std::logic_error);
    plan = small_plan();
    plan.extra["cl"] = {1, 2};
    EXPECT_THROW(plan_to_json(plan), std::logic_error);
}

}  // namespace
}  // namespace trunnion
