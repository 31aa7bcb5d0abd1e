#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "report/plan_layout.hpp"
#include "report/text.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

namespace {

using report::json_number;
using report::json_string;

/// Entries per task: some 60 kB of text, large beside the cost of a task; and tasks per wave, whose texts fit the cache.
constexpr std::size_t kGrain = 1024, kWave = 32;

void append(std::string& text, double x) {
    text += json_number(x);
}
void append(std::string& text, std::int32_t x) {
    text += fmt::format_int(x).c_str();
}
void append(std::string& text, std::uint8_t x) {
    text += fmt::format_int(x).c_str();
}
void append(std::string& text, const std::string& x) {
    text += json_string(x);
}

/// A vector is [x, y, ...], or null where nothing of it is known.
template <class Components>
void append_components(std::string& text, const Components& x, int count) {
    bool absent = true;
    for (int k = 0; k < count; ++k) absent = absent && std::isnan(x[static_cast<std::size_t>(k)]);
    if (absent) {
        text += "null";
        return;
    }
    for (int k = 0; k < count; ++k) {
        text += k == 0 ? '[' : ',';
        text += json_number(x[static_cast<std::size_t>(k)]);
    }
    text += ']';
}
void append(std::string& text, const Vec2& x) {
    append_components(text, std::array{x.x(), x.y()}, 2);
}
void append(std::string& text, const Vec3& x) {
    append_components(text, std::array{x.x(), x.y(), x.z()}, 3);
}
void append(std::string& text, const std::array<double, 5>& x) {
    append_components(text, x, 5);
}

/// Room for one entry, generously: pages that stay unused cost nothing, while a text of hundreds of megabytes that has
/// to move because it grew costs as much as writing its numbers.
template <class T>
constexpr std::size_t room_for() {
    constexpr std::size_t kNumber = 22;
    if constexpr (std::is_same_v<T, Vec3>) return 3 * kNumber;
    if constexpr (std::is_same_v<T, Vec2>) return 2 * kNumber;
    if constexpr (std::is_same_v<T, std::array<double, 5>>) return 5 * kNumber;
    return kNumber;
}

/// The growing text. Objects have one "key": value per line.
class PlanText {
public:
    explicit PlanText(std::size_t room) { text_.reserve(room); }
    void open() {
        text_ += '{';
        empty_ = true;
    }
    void close() {
        text_ += empty_ ? "}" : "\n}";
        empty_ = false;
    }
    void key(std::string_view name) {
        text_ += empty_ ? "\n" : ",\n";
        text_ += json_string(name);
        text_ += ": ";
        empty_ = false;
    }
    void add(std::string_view name, std::string_view value) {
        key(name);
        text_ += value;
    }
    template <class T>
    void add_array(std::string_view name, const std::vector<T>& values);
    std::string take() && { return std::move(text_); }

private:
    std::string text_;
    bool empty_ = true;
    std::vector<std::string> chunks_ = std::vector<std::string>(kWave);  // used again and again: their memory stays warm
};

template <class T>
std::string chunk_text(std::string text, std::span<const T> values, bool flags) {
    text.clear();
    for (const T& value : values) {
        if (!text.empty()) text += ',';
        if constexpr (std::is_same_v<T, std::uint8_t>) {
            if (flags) {
                text += value ? "true" : "false";
                continue;
            }
        }
        append(text, value);
    }
    return text;
}

/// All threads write the chunks of a wave, which are then appended in order: the same text for any number of threads.
template <class T>
void PlanText::add_array(std::string_view name, const std::vector<T>& values) {
    key(name);
    text_ += '[';
    for (std::size_t start = 0; start < values.size(); start += kWave * kGrain) {
        const std::span<const T> wave = std::span(values).subspan(start, std::min(kWave * kGrain, values.size() - start));
        const auto done = parallel_for(wave.size(), kGrain, Control{}, "plan.json", [&](std::size_t begin, std::size_t end) {
            std::string& chunk = chunks_[begin / kGrain];
            chunk = chunk_text(std::move(chunk), wave.subspan(begin, end - begin), report::is_flag(name));
        });
        TRUNNION_REQUIRE(done.has_value());
        for (std::size_t k = 0; k * kGrain < wave.size(); ++k) {
            if (start > 0 || k > 0) text_ += ',';
            text_ += chunks_[k];
        }
    }
    text_ += ']';
}

/// The text of an object, as the caller made it, without the space around it.
std::string object_text(const std::string& json) {
    const std::size_t first = json.find_first_not_of(" \t\r\n");
    if (first == std::string::npos) return "{}";
    const std::string trimmed = json.substr(first, json.find_last_not_of(" \t\r\n") - first + 1);
    TRUNNION_REQUIRE(trimmed.front() == '{' && nlohmann::json::accept(trimmed));
    return trimmed;
}

template <class T, class Text>
std::string list_text(const std::vector<T>& items, std::string_view separator, Text&& text) {
    std::string all = "[";
    for (const T& item : items) {
        if (all.size() > 1) all += separator;
        all += text(item);
    }
    return all + ']';
}

}  // namespace

std::string plan_to_json(const PlanDocument& plan) {
    TRUNNION_REQUIRE(plan.schema == kPlanSchema);
    TRUNNION_REQUIRE(!report::inconsistency(plan));

    std::size_t room = plan.job_json.size() + plan.metrics_json.size() + (std::size_t{1} << 16);
    const auto count = [&]<class T>(std::string_view, const std::vector<T>& values) { room += room_for<T>() * values.size(); };
    report::for_each_pose_array(plan, count);
    for (const auto& [key, values] : plan.extra) count(key, values);
    report::for_each_machine_array(plan, count);

    PlanText text(room);
    const auto add_array = [&](std::string_view key, const auto& values) { text.add_array(key, values); };
    text.open();
    text.add("trunnion", json_string(plan.trunnion));
    text.add("schema", std::to_string(plan.schema));
    text.add("job", object_text(plan.job_json));
    text.add("passes", list_text(plan.passes, ",", [](const PlanPass& pass) {
                 return fmt::format("[{},{},{}]", pass.first, pass.count, json_string(pass.kind));
             }));
    text.key("poses");
    text.open();
    report::for_each_pose_array(plan, add_array);
    for (const auto& [key, values] : plan.extra) text.add_array(key, values);
    text.close();
    text.key("machine");
    text.open();
    text.add("name", json_string(plan.machine_name));
    text.add("axes", list_text(plan.axes, ",", [](const std::string& letter) { return json_string(letter); }));
    report::for_each_machine_array(plan, add_array);
    text.close();
    text.add("metrics", object_text(plan.metrics_json));
    text.add("checks", list_text(plan.checks, ",\n", [](const PlanCheck& check) {
                 return fmt::format("{{\"what\": {}, \"bound\": {}, \"engine\": {}, \"holds\": {}}}", json_string(check.what),
                                    json_string(check.bound), json_string(check.engine), check.holds);
             }));
    text.key("timings_s");
    text.open();
    for (const auto& [stage, seconds] : plan.timings_s) text.add(stage, json_number(seconds));
    text.close();
    text.add("warnings", list_text(plan.warnings, ",\n", [](const std::string& warning) { return json_string(warning); }));
    if (plan.interrupted) text.add("interrupted", "true");
    text.close();
    return std::move(text).take() + '\n';
}

}  // namespace trunnion
