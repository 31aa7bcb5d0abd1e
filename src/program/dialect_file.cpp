// Dialect files: TOML, strict, every message with file and line. The format is described in docs/dialects.md.
#include <algorithm>

#include "base/toml_reader.hpp"
#include "program/embedded.hpp"
#include "program/text.hpp"
#include "trunnion/program/dialect.hpp"

namespace trunnion {

namespace {

constexpr std::array<std::string_view, 8> kConditions{"tcp", "vector", "plane", "spindle", "lift", "blend", "invalid", "cutter"};
constexpr std::array<std::string_view, 21> kPlaceholders{
    "title",  "part",    "version",  "machine", "tool",         "length",     "length6",
    "rpm",    "rpm3",    "diameter", "corner",  "blend",        "lift",       "rotary_zero",
    "rotary", "plane_1", "plane_2",  "plane_3", "plane_offset", "plane_sign", "tolerance"};

/// "?cond ?!cond text"
TemplateLine parse_line(std::string_view line, TomlReader& r, std::string_view key) {
    TemplateLine parsed;
    while (!line.empty() && line.front() == '?') {
        const std::size_t end = std::min(line.find(' '), line.size());
        std::string_view name = line.substr(1, end - 1);
        line.remove_prefix(std::min(end + 1, line.size()));
        const bool wanted = name.empty() || name.front() != '!';
        if (!wanted) name.remove_prefix(1);
        if (std::find(kConditions.begin(), kConditions.end(), name) == kConditions.end())
            r.wrong(key, fmt::format("has a line under the condition \"{}\"; known are {}", name, fmt::join(kConditions, ", ")));
        parsed.conditions.push_back({std::string(name), wanted});
    }
    for (std::size_t at = 0; (at = line.find('{', at)) != std::string_view::npos; ++at) {
        const std::size_t end = line.find('}', at);
        const std::string_view name = line.substr(at + 1, end == std::string_view::npos ? end : end - at - 1);
        if (end == std::string_view::npos || std::find(kPlaceholders.begin(), kPlaceholders.end(), name) == kPlaceholders.end())
            r.wrong(key, fmt::format("has the placeholder \"{{{}}}\"; known are {}", name, fmt::join(kPlaceholders, ", ")));
    }
    parsed.text = line;
    return parsed;
}

std::vector<TemplateLine> lines(TomlReader& r, std::string_view key) {
    std::vector<TemplateLine> all;
    const std::string text = r.text(key, "");
    std::string_view rest = text;
    while (!rest.empty()) all.push_back(parse_line(detail::take_line(rest), r, key));
    return all;
}

template <std::size_t N>
std::array<std::string, N> texts(TomlReader& r, std::string_view key, std::array<std::string, N> fallback) {
    if (!r.has(key)) {
        r.texts(key);
        return fallback;
    }
    const std::vector<std::string> given = r.texts(key);
    if (given.size() != N) {
        r.wrong(key, fmt::format("must be {} texts in brackets", N));
        return fallback;
    }
    std::copy_n(given.begin(), N, fallback.begin());
    return fallback;
}

Dialect read_dialect(TomlReader& r) {
    Dialect d;
    d.title = r.text("title", "");
    d.ending = r.text("ending", "nc");
    const std::string syntax = r.word("syntax", "", {"apt", "linuxcnc", "fanuc", "siemens", "heidenhain"});
    d.syntax = syntax == "apt"        ? Syntax::apt
               : syntax == "fanuc"    ? Syntax::fanuc
               : syntax == "siemens"  ? Syntax::siemens
               : syntax == "linuxcnc" ? Syntax::linuxcnc
                                      : Syntax::heidenhain;
    d.needs_machine = d.syntax != Syntax::apt;
    d.vector = r.flag("vector", false);
    d.without_tcp = r.flag("without_tcp", false);
    if (d.vector && d.without_tcp) r.wrong("without_tcp", "cannot be true with vector: machine positions hold rotary words");
    d.comment = texts<2>(r, "comment", d.comment);
    d.comment_length = static_cast<std::size_t>(r.integer("comment_length", static_cast<int>(d.comment_length), 20, 200));
    d.comment_on_own_line = r.flag("comment_on_own_line", false);
    d.header = lines(r, "header");
    d.footer = lines(r, "footer");

    TomlReader number = r.table("number");
    const std::string style = number.word("style", "plain", {"plain", "point", "sign"});
    d.number = style == "point" ? Dialect::Number::point : style == "sign" ? Dialect::Number::sign : Dialect::Number::plain;
    d.linear_decimals = number.integer("linear_decimals", d.linear_decimals, 1, 10);
    d.rotary_decimals = number.integer("rotary_decimals", d.rotary_decimals, 1, 10);
    d.vector_decimals = number.integer("vector_decimals", d.vector_decimals, 3, 12);
    d.machine_decimals = number.integer("machine_decimals", d.machine_decimals, 1, 10);
    d.feed_digits = number.integer("feed_digits", d.feed_digits, 2, 12);
    d.feed_decimals = number.integer("feed_decimals", d.feed_decimals, 0, 12);
    number.finish();

    TomlReader block = r.table("block");
    d.line_number = block.text("number", "");
    d.first_number = block.integer("first_number", d.first_number, 0, 1'000'000);
    d.number_step = block.integer("number_step", d.number_step, 1, 1000);
    d.cut = block.text("cut", "");
    d.rapid = block.text("rapid", "");
    if (d.cut.empty()) block.wrong("cut", "is missing: the word that opens a cutting move");
    if (d.rapid.empty()) block.wrong("rapid", "is missing: the word that opens a rapid move");
    d.motion_always = block.flag("motion_always", false);
    d.position_always = block.flag("position_always", false);
    d.position = texts<3>(block, "position", d.position);
    d.direction = texts<3>(block, "direction", d.direction);
    d.rotary = block.text("rotary", d.rotary);
    if (d.rotary.find("{}") == std::string::npos) block.wrong("rotary", "must hold {}, the letter of the axis");
    d.separator = block.text("separator", d.separator);
    d.tail = block.text("tail", "");
    d.feed = block.text("feed", d.feed);
    d.rapid_feed = block.text("rapid_feed", "");
    d.feed_line = block.text("feed_line", "");
    d.rapid_line = block.text("rapid_line", "");
    const std::string links = block.word("links", "rapid", {"rapid", "turning-at-feed", "at-feed"});
    d.links = links == "at-feed"           ? Dialect::Links::at_feed
              : links == "turning-at-feed" ? Dialect::Links::turning_at_feed
                                           : Dialect::Links::rapid;
    block.finish();

    const bool plane_known = r.has("plane");
    TomlReader plane = r.table("plane");
    if (plane_known) {
        const std::string angles = plane.word("angles", "", {"zxz", "xyz-moving", "xyz-fixed", "offset"});
        d.plane_angles = angles == "zxz"          ? Dialect::PlaneAngles::zxz
                         : angles == "xyz-moving" ? Dialect::PlaneAngles::xyz_moving
                         : angles == "xyz-fixed"  ? Dialect::PlaneAngles::xyz_fixed
                                                  : Dialect::PlaneAngles::offset;
        d.plane_header = lines(plane, "header");
        d.plane_footer = lines(plane, "footer");
    }
    plane.finish();
    r.finish();
    return d;
}

}  // namespace

Result<Dialect> dialect_from_toml(std::string_view text, std::string_view source) {
    // toml++ throws; nothing of it leaves this function.
    try {
        const toml::table root = toml::parse(text, source);
        TomlErrors errors{std::string(source), {}};
        TomlReader r(&root, "", errors);
        Dialect dialect = read_dialect(r);
        if (errors.first) return tl::unexpected(*errors.first);
        dialect.source = source;
        dialect.name = std::filesystem::path(std::string(source)).stem().string();
        if (dialect.title.empty()) dialect.title = dialect.name;
        return dialect;
    } catch (const toml::parse_error& error) {
        return fail(ErrorCode::invalid_input, fmt::format("{}:{}: {}", source, error.source().begin.line, error.description()));
    }
}

Result<Dialect> load_dialect(const std::filesystem::path& file) {
    auto text = read_file(file);
    if (!text) return fail_up(std::move(text));
    return dialect_from_toml(*text, file.string());
}

Result<Dialect> built_in_dialect(std::string_view name) {
    std::vector<std::string_view> names;
    for (const auto& dialect : detail::embedded_dialects()) {
        names.push_back(dialect.name);
        if (dialect.name != name) continue;
        auto read = dialect_from_toml(dialect.toml, fmt::format("data/dialects/{}.toml", name));
        TRUNNION_REQUIRE(read.has_value());
        read->source = "built-in";
        return read;
    }
    const std::string_view near = nearest_word(name, names);
    return fail(ErrorCode::invalid_input, near.empty()
                                              ? fmt::format("unknown dialect \"{}\"; there are {}", name, fmt::join(names, ", "))
                                              : fmt::format("unknown dialect \"{}\"; did you mean \"{}\"?", name, near));
}

}  // namespace trunnion
