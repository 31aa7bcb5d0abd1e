// Machine files: TOML, strict, every message with file and line. The format is described in docs/machines.md.
#include <cmath>
#include <initializer_list>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>
#include <Eigen/LU>

#include "trunnion/base/file.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {

namespace {

/// Two axes closer to parallel than this (sine of the angle) cannot be told from parallel ones in a file of six decimals.
constexpr double kParallelSine = 1e-6;
/// Nothing in a machine is larger (mm, degrees, mm/min, ...); beyond it arithmetic would lose the micrometre.
constexpr double kGreatestNumber = 1e9;
constexpr std::string_view kLetters = "XYZABCUVW";

Result<Vec3> unit_direction(const Vec3& v) {
    auto unit = UnitVector::from(v);
    if (!unit) return fail_up(std::move(unit));
    return unit->vec();
}

/// One table of the file. Every getter names the key and the line when it fails.
class Section {
public:
    Section(const toml::table& table, std::string source, std::string where)
        : table_(table), source_(std::move(source)), where_(std::move(where)) {}

    tl::unexpected<Error> wrong(std::string_view key, std::string_view what) const {
        const toml::node* node = table_.get(key);
        return wrong_at(node ? node->source().begin.line : line(), what);
    }
    tl::unexpected<Error> wrong_at(toml::source_index line, std::string_view what) const {
        return fail(ErrorCode::invalid_input, fmt::format("{}:{}: {}{}", source_, line, where_, what));
    }
    toml::source_index line() const { return table_.source().begin.line; }

    Result<void> only(const std::vector<std::string_view>& known) const {
        for (const auto& [key, node] : table_) {
            const std::string_view name = key.str();
            if (std::find(known.begin(), known.end(), name) != known.end()) continue;
            const std::string_view near = nearest_word(name, known);
            return wrong_at(key.source().begin.line,
                            near.empty() ? fmt::format("unknown key \"{}\"; known here: {}", name, fmt::join(known, ", "))
                                         : fmt::format("unknown key \"{}\"; did you mean \"{}\"?", name, near));
        }
        return {};
    }

    Result<double> number(std::string_view key, std::optional<double> fallback = {}) const {
        const toml::node* node = table_.get(key);
        if (!node && fallback) return *fallback;
        if (!node) return wrong(key, fmt::format("{} is missing; give a number", key));
        const auto value = finite(*node);
        if (!value) return wrong(key, fmt::format("{} must be a number of at most {:.0e}", key, kGreatestNumber));
        return *value;
    }
    Result<double> positive(std::string_view key, std::optional<double> fallback = {}) const {
        const auto value = number(key, fallback);
        if (value && !(*value > 0) && !(fallback && *value == *fallback))
            return wrong(key, fmt::format("{} = {} must be greater than zero", key, *value));
        return value;
    }
    Result<std::vector<double>> numbers(std::string_view key, std::size_t count,
                                        std::optional<std::vector<double>> fallback = {}) const {
        const toml::node* node = table_.get(key);
        if (!node && fallback) return *fallback;
        if (!node) return wrong(key, fmt::format("{} is missing; give {} numbers in brackets", key, count));
        const toml::array* array = node->as_array();
        if (!array || array->size() != count) return wrong(key, fmt::format("{} must be {} numbers in brackets", key, count));
        std::vector<double> values;
        for (const toml::node& item : *array) {
            const auto value = finite(item);
            if (!value)
                return wrong(key,
                             fmt::format("{} must be {} numbers in brackets, each at most {:.0e}", key, count, kGreatestNumber));
            values.push_back(*value);
        }
        return values;
    }
    Result<Vec3> vector(std::string_view key, std::optional<std::vector<double>> fallback = {}) const {
        const auto v = numbers(key, 3, std::move(fallback));
        if (!v) return tl::unexpected(v.error());
        return Vec3((*v)[0], (*v)[1], (*v)[2]);
    }
    Result<Vec3> direction(std::string_view key, std::optional<std::vector<double>> fallback = {}) const {
        const auto v = vector(key, std::move(fallback));
        if (!v) return v;
        const auto unit = unit_direction(*v);
        if (!unit) return wrong(key, fmt::format("{} is a zero axis; give a direction such as [0, 0, 1]", key));
        return unit;
    }
    Result<std::string> text(std::string_view key, std::optional<std::string> fallback = {}) const {
        const toml::node* node = table_.get(key);
        if (!node && fallback) return *fallback;
        const auto value = node ? node->value_exact<std::string>() : std::nullopt;
        if (!value || value->empty()) return wrong(key, fmt::format("{} must be a text in quotes", key));
        return *value;
    }
    Result<bool> flag(std::string_view key, bool fallback) const {
        const toml::node* node = table_.get(key);
        if (!node) return fallback;
        const auto value = node->value_exact<bool>();
        if (!value) return wrong(key, fmt::format("{} must be true or false", key));
        return *value;
    }
    Result<char> letter(std::string_view key) const {
        const auto word = text(key);
        if (!word) return tl::unexpected(word.error());
        if (word->size() != 1 || kLetters.find(word->front()) == std::string_view::npos)
            return wrong(key, fmt::format("{} = \"{}\" must be one of the letters {}", key, *word, fmt::join(kLetters, " ")));
        return word->front();
    }
    /// The sections [[key]]; exactly `count` of them.
    Result<std::vector<Section>> sections(std::string_view key, std::size_t count) const {
        const toml::node* node = table_.get(key);
        const toml::array* array = node ? node->as_array() : nullptr;
        if (!array || array->size() != count || !array->is_homogeneous(toml::node_type::table))
            return wrong(key, fmt::format("a five-axis machine needs {} sections [[{}]], this file has {}", count, key,
                                          array ? array->size() : 0));
        std::vector<Section> all;
        for (const toml::node& item : *array) {
            const auto name = item.as_table()->get_as<std::string>("letter");
            all.emplace_back(*item.as_table(), source_,
                             name ? fmt::format("{} axis {}: ", key, name->get()) : fmt::format("{} axis: ", key));
        }
        return all;
    }

private:
    static std::optional<double> finite(const toml::node& node) {
        if (!node.is_number()) return {};
        const double value = *node.value<double>();
        return std::abs(value) <= kGreatestNumber ? std::optional(value) : std::nullopt;
    }
    const toml::table& table_;
    std::string source_, where_;
};

/// Limits as the file writes them: `unit` is "mm" or "deg", `scale` takes it to the code's unit.
Result<AxisLimits> read_limits(const Section& section, std::string_view unit, double scale) {
    const std::string travel_key = fmt::format("travel_{}", unit);
    const auto travel = section.numbers(travel_key, 2);
    if (!travel) return tl::unexpected(travel.error());
    if (!((*travel)[0] < (*travel)[1]))
        return section.wrong(travel_key, fmt::format("{} = [{}, {}] is crossed; the lower end comes first", travel_key,
                                                     (*travel)[0], (*travel)[1]));
    const auto velocity = section.positive(fmt::format("velocity_{}_min", unit));
    if (!velocity) return tl::unexpected(velocity.error());
    const auto acceleration = section.positive(fmt::format("acceleration_{}_s2", unit));
    if (!acceleration) return tl::unexpected(acceleration.error());
    const auto jerk = section.positive(fmt::format("jerk_{}_s3", unit), 0.0);
    if (!jerk) return tl::unexpected(jerk.error());
    return AxisLimits{(*travel)[0] * scale, (*travel)[1] * scale, *velocity * scale / 60.0, *acceleration * scale, *jerk * scale};
}

Result<LinearAxis> read_linear(const Section& section) {
    if (auto known = section.only({"letter", "direction", "travel_mm", "velocity_mm_min", "acceleration_mm_s2", "jerk_mm_s3"});
        !known)
        return fail_up(std::move(known));
    const auto letter = section.letter("letter");
    if (!letter) return tl::unexpected(letter.error());
    const auto direction = section.direction("direction");
    if (!direction) return tl::unexpected(direction.error());
    const auto limits = read_limits(section, "mm", 1.0);
    if (!limits) return tl::unexpected(limits.error());
    return LinearAxis{*letter, *direction, *limits};
}

Result<RotaryAxis> read_rotary(const Section& section) {
    if (auto known = section.only({"letter", "side", "direction", "point_mm", "sign", "travel_deg", "velocity_deg_min",
                                   "acceleration_deg_s2", "jerk_deg_s3"});
        !known)
        return fail_up(std::move(known));
    RotaryAxis axis;
    const auto letter = section.letter("letter");
    if (!letter) return tl::unexpected(letter.error());
    axis.letter = *letter;
    const auto side = section.text("side");
    if (!side) return tl::unexpected(side.error());
    if (*side != "head" && *side != "table")
        return section.wrong("side", fmt::format("side = \"{}\" must be \"head\" or \"table\"", *side));
    axis.side = *side == "head" ? Side::head : Side::table;
    const auto direction = section.direction("direction");
    if (!direction) return tl::unexpected(direction.error());
    axis.direction = *direction;
    const auto point = section.vector("point_mm", std::vector<double>(3, 0.0));
    if (!point) return tl::unexpected(point.error());
    axis.point = *point;
    const auto sign = section.number("sign");
    if (!sign) return tl::unexpected(sign.error());
    if (std::abs(*sign) != 1.0) return section.wrong("sign", fmt::format("sign = {} must be 1 or -1", *sign));
    axis.sign = *sign;
    const auto limits = read_limits(section, "deg", radians(1.0));
    if (!limits) return tl::unexpected(limits.error());
    axis.limits = *limits;
    return axis;
}

Result<Machine> read_machine(const toml::table& root, const std::string& source) {
    const Section top(root, source, "");
    if (auto known = top.only({"name", "title", "tcp", "rapid_mm_min", "spindle", "work_offset_mm", "linear", "rotary"}); !known)
        return fail_up(std::move(known));
    Machine machine;
    machine.source = source;
    const auto name = top.text("name");
    if (!name) return tl::unexpected(name.error());
    machine.name = *name;
    const auto title = top.text("title", *name);
    if (!title) return tl::unexpected(title.error());
    machine.title = *title;
    const auto tcp = top.flag("tcp", true);
    if (!tcp) return tl::unexpected(tcp.error());
    machine.tcp = *tcp;
    const auto rapid = top.positive("rapid_mm_min");
    if (!rapid) return tl::unexpected(rapid.error());
    machine.rapid = *rapid / 60.0;
    const auto spindle = top.direction("spindle", std::vector<double>{0.0, 0.0, 1.0});
    if (!spindle) return tl::unexpected(spindle.error());
    machine.spindle = *spindle;
    const auto work_offset = top.vector("work_offset_mm", std::vector<double>(3, 0.0));
    if (!work_offset) return tl::unexpected(work_offset.error());
    machine.work_offset = *work_offset;

    const auto linear = top.sections("linear", 3);
    if (!linear) return tl::unexpected(linear.error());
    const auto rotary = top.sections("rotary", 2);
    if (!rotary) return tl::unexpected(rotary.error());
    std::string letters;
    const auto letter_taken = [&](char letter) { return letters.find(letter) != std::string::npos; };
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = read_linear((*linear)[i]);
        if (!axis) return tl::unexpected(axis.error());
        machine.linear[i] = *axis;
        if (letter_taken(axis->letter)) return (*linear)[i].wrong("letter", "this letter is used by another axis too");
        letters += axis->letter;
    }
    for (std::size_t i = 0; i < 2; ++i) {
        const auto axis = read_rotary((*rotary)[i]);
        if (!axis) return tl::unexpected(axis.error());
        machine.rotary[i] = *axis;
        if (letter_taken(axis->letter)) return (*rotary)[i].wrong("letter", "this letter is used by another axis too");
        letters += axis->letter;
    }

    // What only the axes together can get wrong.
    Mat3 directions;
    for (int i = 0; i < 3; ++i) directions.col(i) = machine.linear[i].direction;
    if (std::abs(directions.determinant()) < kParallelSine)
        return (*linear)[2].wrong("direction", "the three linear axes lie in one plane; give independent directions");
    const auto& [first, second] = machine.rotary;
    if (first.direction.cross(second.direction).norm() < kParallelSine)
        return (*rotary)[1].wrong(
            "direction", fmt::format("rotary axes {} and {} are parallel; together they could tilt the tool in one plane only",
                                     first.letter, second.letter));
    // The axis next to the spindle in the chain work -> tool: the last of two heads, the first of two tables, else the head.
    const bool both_head = first.side == Side::head && second.side == Side::head;
    const bool both_table = first.side == Side::table && second.side == Side::table;
    const std::size_t carrier = both_head ? 1 : both_table ? 0 : first.side == Side::head ? 0 : 1;
    if (machine.rotary[carrier].direction.cross(machine.spindle).norm() < kParallelSine)
        return (*rotary)[carrier].wrong(
            "direction", fmt::format("rotary axis {} is parallel to the spindle and would only spin the tool about itself",
                                     machine.rotary[carrier].letter));
    return machine;
}

}  // namespace

Result<Machine> machine_from_toml(std::string_view text, std::string_view source) {
    // toml++ throws; nothing of it leaves this function.
    try {
        const toml::table root = toml::parse(text, source);
        return read_machine(root, std::string(source));
    } catch (const toml::parse_error& error) {
        return fail(ErrorCode::invalid_input, fmt::format("{}:{}: {}", source, error.source().begin.line, error.description()));
    }
}

Result<Machine> load_machine(const std::filesystem::path& file) {
    auto text = read_file(file);
    if (!text) return fail_up(std::move(text));
    return machine_from_toml(*text, file.string());
}

}  // namespace trunnion
