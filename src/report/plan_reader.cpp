#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <simdjson.h>
#include <nlohmann/json.hpp>

#include "report/plan_layout.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

namespace {

namespace json = simdjson::ondemand;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Greatest departure of an axis from unit length: a file written by hand or by another program with six decimals
/// passes, and the tip error on a 100 mm tool stays at 0.1 um.
constexpr double kUnitTolerance = 1e-6;

/// A sentence on its way to plan_from_json, which turns it into an Error. Inside this file refusals travel as
/// exceptions, as simdjson's own do: a Result for each of tens of millions of numbers would cost more than reading them.
struct Refusal {
    std::string sentence;
};
[[noreturn]] void refuse(std::string sentence) {
    throw Refusal{std::move(sentence)};
}

std::string_view kind_name(json::json_type type) {
    switch (type) {
        case json::json_type::array:
            return "a list";
        case json::json_type::object:
            return "an object";
        case json::json_type::number:
            return "a number";
        case json::json_type::string:
            return "a string";
        case json::json_type::boolean:
            return "true or false";
        case json::json_type::null:
            return "null";
    }
    return "something else";
}

void expect(json::value& value, json::json_type wanted, std::string_view place) {
    const json::json_type type = value.type();
    if (type != wanted) refuse(fmt::format("{} must be {} but is {}", place, kind_name(wanted), kind_name(type)));
}

/// "poses.axis[17]", made only when it is needed; without an index just the key.
struct Place {
    std::string_view key;
    std::optional<std::size_t> index;
    std::string text() const { return index ? fmt::format("{}[{}]", key, *index) : std::string(key); }
};

std::string read_string(json::value value, std::string_view place) {
    expect(value, json::json_type::string, place);
    return std::string(value.get_string().value());
}

bool read_flag(json::value value, std::string_view place) {
    expect(value, json::json_type::boolean, place);
    return value.get_bool().value();
}

double read_number(json::value value, const Place& place) {
    const json::json_type type = value.type();
    if (type == json::json_type::number) return value.get_double().value();
    if (type == json::json_type::null && value.is_null()) return kNaN;
    if (type == json::json_type::string) {
        const std::string_view word = value.get_string().value();
        if (word == "inf") return kInfinity;
        if (word == "-inf") return -kInfinity;
    }
    refuse(fmt::format("{} must be a number or null but is {}", place.text(), kind_name(type)));
}

std::int64_t read_integer(json::value value, const Place& place, std::int64_t least, std::int64_t greatest) {
    std::int64_t integer = 0;
    if (value.type() != json::json_type::number || value.get_int64().get(integer) != simdjson::SUCCESS || integer < least ||
        integer > greatest)
        refuse(fmt::format("{} must be a whole number from {} to {}", place.text(), least, greatest));
    return integer;
}

/// Exactly `count` numbers in brackets, or null for none of them known.
template <std::size_t count>
std::array<double, count> read_components(json::value value, const Place& place) {
    std::array<double, count> x;
    const json::json_type type = value.type();
    if (type == json::json_type::null && value.is_null()) {
        x.fill(kNaN);
        return x;
    }
    if (type != json::json_type::array)
        refuse(fmt::format("{} must be a list of {} numbers but is {}", place.text(), count, kind_name(type)));
    std::size_t filled = 0;
    for (json::value component : value.get_array()) {
        if (filled == count) refuse(fmt::format("{} must have {} numbers but has more", place.text(), count));
        x[filled++] = read_number(component, place);
    }
    if (filled != count) refuse(fmt::format("{} must have {} numbers but has {}", place.text(), count, filled));
    return x;
}

template <class T>
T read_entry(json::value value, const Place& place) {
    if constexpr (std::is_same_v<T, double>) {
        return read_number(value, place);
    } else if constexpr (std::is_same_v<T, Vec2>) {
        const auto x = read_components<2>(value, place);
        return {x[0], x[1]};
    } else if constexpr (std::is_same_v<T, Vec3>) {
        const auto x = read_components<3>(value, place);
        return {x[0], x[1], x[2]};
    } else if constexpr (std::is_same_v<T, std::array<double, 5>>) {
        return read_components<5>(value, place);
    } else if constexpr (std::is_same_v<T, std::string>) {
        return read_string(value, place.text());
    } else if constexpr (std::is_same_v<T, std::uint8_t>) {
        // Flags are true and false, branches numbers; which of them an array holds was decided by its key.
        if (value.type() == json::json_type::boolean) return value.get_bool().value() ? 1 : 0;
        return static_cast<std::uint8_t>(read_integer(value, place, 0, std::numeric_limits<std::uint8_t>::max()));
    } else {
        static_assert(std::is_same_v<T, std::int32_t>);
        using Limits = std::numeric_limits<std::int32_t>;
        return static_cast<std::int32_t>(read_integer(value, place, Limits::min(), Limits::max()));
    }
}

/// `expected`: how many entries to make room for.
template <class T>
std::vector<T> read_array(json::value value, std::string_view key, std::size_t expected = 0) {
    expect(value, json::json_type::array, key);
    std::vector<T> array;
    array.reserve(expected);
    for (json::value entry : value.get_array()) {
        const Place place{key, array.size()};
        if constexpr (std::is_same_v<T, std::uint8_t>) {
            const bool flags = report::is_flag(key.substr(key.rfind('.') + 1));
            if ((entry.type() == json::json_type::boolean) != flags)
                refuse(fmt::format("{} must be {}", place.text(), flags ? "true or false" : "a whole number"));
        }
        array.push_back(read_entry<T>(entry, place));
    }
    return array;
}

/// Calls read(key, value) for each member, and refuses a key that comes twice.
template <class Read>
void read_object(json::object object, std::string_view place, Read&& read) {
    std::set<std::string, std::less<>> seen;
    for (json::field field : object) {
        const std::string key(field.unescaped_key().value());
        const std::string full = place.empty() ? key : fmt::format("{}.{}", place, key);
        if (!seen.insert(key).second) refuse(fmt::format("{} is there twice", full));
        read(key, full, field.value());
    }
}

json::object object_at(json::value value, std::string_view place) {
    expect(value, json::json_type::object, place);
    return value.get_object();
}

/// The text of an object, kept as it stands. On-demand parsing skips it, so it is checked here.
std::string read_object_text(json::value value, std::string_view place) {
    std::string text(object_at(value, place).raw_json().value());
    text.erase(text.find_last_of('}') + 1);
    if (!nlohmann::json::accept(text)) refuse(fmt::format("{} is not valid JSON", place));
    return text;
}

PlanPass read_pass(json::value value, const Place& place) {
    if (value.type() != json::json_type::array) refuse(fmt::format("{} must be [first, count, kind]", place.text()));
    PlanPass pass;
    std::size_t filled = 0;
    for (json::value item : value.get_array()) {
        const std::int64_t greatest = std::numeric_limits<std::int64_t>::max();
        if (filled == 0) pass.first = static_cast<std::size_t>(read_integer(item, place, 0, greatest));
        if (filled == 1) pass.count = static_cast<std::size_t>(read_integer(item, place, 0, greatest));
        if (filled == 2) pass.kind = read_string(item, place.text());
        if (++filled > 3) break;
    }
    if (filled != 3) refuse(fmt::format("{} must be [first, count, kind]", place.text()));
    return pass;
}

PlanCheck read_check(json::value value, const Place& place) {
    PlanCheck check;
    int found = 0;
    read_object(object_at(value, place.text()), place.text(),
                [&](std::string_view key, std::string_view full, json::value member) {
                    ++found;
                    if (key == "what")
                        check.what = read_string(member, full);
                    else if (key == "bound")
                        check.bound = read_string(member, full);
                    else if (key == "engine")
                        check.engine = read_string(member, full);
                    else if (key == "holds")
                        check.holds = read_flag(member, full);
                    else
                        refuse(fmt::format("{} is not known: a check has what, bound, engine and holds", full));
                });
    if (found != 4) refuse(fmt::format("{} must have what, bound, engine and holds", place.text()));
    return check;
}

template <class T, class Read>
std::vector<T> read_list(json::value value, std::string_view key, Read&& read) {
    expect(value, json::json_type::array, key);
    std::vector<T> list;
    for (json::value item : value.get_array()) list.push_back(read(item, Place{key, list.size()}));
    return list;
}

void read_poses(json::value value, PlanDocument& plan) {
    std::size_t expected = 0;
    read_object(object_at(value, "poses"), "poses", [&](const std::string& key, std::string_view full, json::value array) {
        bool known = false;
        report::for_each_pose_array(plan, [&](std::string_view name, auto& values) {
            if (name != key) return;
            known = true;
            using T = typename std::decay_t<decltype(values)>::value_type;
            values = read_array<T>(array, full, expected);
            expected = std::max(expected, values.size());
        });
        if (!known) plan.extra[key] = read_array<double>(array, full, expected);
    });
    for (std::size_t i = 0; i < plan.axis.size(); ++i)
        if (const double length = plan.axis[i].norm(); !(std::abs(length - 1.0) <= kUnitTolerance))
            refuse(fmt::format("poses.axis[{}] has length {} but must have length 1 to within {}", i, length, kUnitTolerance));
}

void read_machine(json::value value, PlanDocument& plan) {
    read_object(object_at(value, "machine"), "machine", [&](std::string_view key, std::string_view full, json::value member) {
        if (key == "name") {
            plan.machine_name = read_string(member, full);
            return;
        }
        if (key == "axes") {
            plan.axes = read_array<std::string>(member, full);
            return;
        }
        bool known = false;
        report::for_each_machine_array(plan, [&](std::string_view name, auto& values) {
            if (name != key) return;
            known = true;
            using T = typename std::decay_t<decltype(values)>::value_type;
            values = read_array<T>(member, full, plan.size());
        });
        if (!known)
            refuse(fmt::format("{} is not known: a machine has name, axes, positions, time_s, feed_mm_min and branch", full));
    });
}

PlanDocument read_document(json::document& document) {
    PlanDocument plan;
    std::set<std::string, std::less<>> found;
    if (document.type() != json::json_type::object) refuse("a plan is a JSON object, this is something else");
    read_object(document.get_object(), "", [&](const std::string& key, std::string_view full, json::value value) {
        found.insert(key);
        if (key == "trunnion")
            plan.trunnion = read_string(value, full);
        else if (key == "schema") {
            std::int64_t schema = 0;
            if (value.type() != json::json_type::number || value.get_int64().get(schema) != simdjson::SUCCESS)
                refuse("schema must be a whole number");
            if (schema != kPlanSchema)
                refuse(fmt::format("the plan has schema {} but this program reads schema {}", schema, kPlanSchema));
        } else if (key == "job")
            plan.job_json = read_object_text(value, full);
        else if (key == "passes")
            plan.passes = read_list<PlanPass>(value, full, read_pass);
        else if (key == "poses")
            read_poses(value, plan);
        else if (key == "machine")
            read_machine(value, plan);
        else if (key == "metrics")
            plan.metrics_json = read_object_text(value, full);
        else if (key == "checks")
            plan.checks = read_list<PlanCheck>(value, full, read_check);
        else if (key == "timings_s")
            read_object(object_at(value, full), full, [&](const std::string& stage, std::string_view where, json::value seconds) {
                plan.timings_s[stage] = read_number(seconds, Place{where, {}});
            });
        else if (key == "warnings")
            plan.warnings = read_array<std::string>(value, full);
        else if (key == "interrupted")
            plan.interrupted = read_flag(value, full);
        else
            refuse(fmt::format("{} is not a key of a plan", full));
    });
    if (document.current_location().error() != simdjson::OUT_OF_BOUNDS) refuse("something follows the end of the plan");
    for (const char* key : {"trunnion", "schema", "job", "passes", "poses"})
        if (!found.contains(key)) refuse(fmt::format("the plan has no {}", key));
    if (auto wrong = report::inconsistency(plan)) refuse(std::move(*wrong));
    return plan;
}

}  // namespace

Result<PlanDocument> plan_from_json(std::string_view text) {
    // simdjson counts in 32 bits.
    if (text.size() >= std::numeric_limits<std::uint32_t>::max())
        return fail(ErrorCode::unsupported, fmt::format("a plan of {} bytes is too large, 4 GiB is the limit", text.size()));
    json::parser parser;
    json::document document;
    std::size_t start = 0;
    try {
        const simdjson::padded_string padded(text);
        start = reinterpret_cast<std::size_t>(padded.data());
        document = parser.iterate(padded);
        try {
            return read_document(document);
        } catch (const simdjson::simdjson_error& error) {
            const char* place = nullptr;
            const bool known = document.current_location().get(place) == simdjson::SUCCESS;
            const std::size_t offset = known ? reinterpret_cast<std::size_t>(place) - start : text.size();
            return fail(ErrorCode::unreadable,
                        fmt::format("not a plan: the JSON is broken near byte {} ({})", offset, error.what()));
        }
    } catch (const Refusal& refusal) {
        return fail(ErrorCode::unreadable, refusal.sentence);
    } catch (const simdjson::simdjson_error& error) {  // before there is a document: empty, not UTF-8, no memory
        return fail(ErrorCode::unreadable, fmt::format("not a plan: not JSON text ({})", error.what()));
    }
}

}  // namespace trunnion
