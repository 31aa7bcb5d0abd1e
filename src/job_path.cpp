#include "job_path.hpp"

#include <cstdlib>

#include <nlohmann/json.hpp>

namespace trunnion {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// The words of a line, comment removed.
std::vector<std::string> words_of(std::string_view line) {
    line = line.substr(0, line.find('#'));
    std::vector<std::string> words;
    std::string word;
    const auto flush = [&] {
        if (!word.empty()) words.push_back(std::move(word));
        word.clear();
    };
    for (const char c : line) {
        if (c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r')
            flush();
        else
            word += c;
    }
    flush();
    return words;
}

std::optional<double> number_of(const std::string& word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end != word.c_str() + word.size() || !std::isfinite(value)) return {};
    return value;
}

/// [[a, b], ...] of a key; empty with the error recorded.
std::vector<Vec2> pairs_of(TomlReader& r, std::string_view key) {
    std::vector<Vec2> points;
    const toml::array* rows = r.array(key);
    if (!rows) return points;
    points.reserve(rows->size());
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const auto pair = TomlReader::flat((*rows)[i].as_array());
        if (!pair || pair->size() != 2) {
            r.wrong(key, fmt::format("point {} must be two finite numbers in brackets", i));
            return {};
        }
        points.emplace_back((*pair)[0], (*pair)[1]);
    }
    if (points.empty()) r.wrong(key, "holds no points");
    return points;
}

ordered_json json_of(const std::vector<Vec2>& points) {
    ordered_json j = ordered_json::array();
    for (const Vec2& p : points) j.push_back({p.x(), p.y()});
    return j;
}

}  // namespace

Result<NumberTable> read_number_table(const fs::path& file, std::size_t columns) {
    auto text = read_file(file);
    if (!text) return fail_up(std::move(text));
    NumberTable table;
    std::size_t line = 0;
    for (std::size_t start = 0; start < text->size();) {
        const std::size_t end = std::min(text->find('\n', start), text->size());
        const std::vector<std::string> words = words_of(std::string_view(*text).substr(start, end - start));
        start = end + 1;
        ++line;
        if (words.empty()) continue;
        const bool header = table.names.empty() && table.rows.empty() && !number_of(words[0]);
        if (words.size() != columns)
            return fail(ErrorCode::unreadable,
                        fmt::format("{}:{}: holds {} values; every row needs {}", file.string(), line, words.size(), columns));
        if (header) {
            table.names = words;
            continue;
        }
        std::vector<double> row;
        for (const std::string& word : words) {
            const auto value = number_of(word);
            if (!value)
                return fail(ErrorCode::unreadable,
                            fmt::format("{}:{}: \"{}\" is not a finite number", file.string(), line, word));
            row.push_back(*value);
        }
        table.rows.push_back(std::move(row));
    }
    if (table.rows.empty()) return fail(ErrorCode::unreadable, fmt::format("{}: holds no rows of numbers", file.string()));
    return table;
}

std::optional<Pattern> read_given_path(TomlReader& r, std::string_view pattern, const fs::path& folder) {
    if (pattern != GivenCurve::name && pattern != GivenPoints::name) return {};
    const bool curve = pattern == GivenCurve::name;
    std::vector<Vec2> uv = r.has("uv") ? pairs_of(r, "uv") : std::vector<Vec2>{};
    std::vector<Vec2> xy;
    if (!curve && r.has("xy")) xy = pairs_of(r, "xy");
    const int ways = static_cast<int>(r.has("uv")) + static_cast<int>(r.has("xy")) + static_cast<int>(r.has("file"));
    if (ways == 0)
        r.wrong("uv", curve ? "or file is missing: give the curve's points" : "or xy or file is missing: give the points");
    if (ways > 1) r.wrong(r.has("file") ? "file" : "xy", "and uv cannot both be given");
    const std::string name = r.text("file", "");
    if (!name.empty()) {
        const fs::path file = fs::path(name).is_absolute() ? fs::path(name) : fs::absolute(folder / name).lexically_normal();
        if (auto table = read_number_table(file, 2); !table) {
            r.wrong("file", "cannot be used: " + table.error().text());
        } else {
            const bool footprint = table->names.size() == 2 && table->names[0] == "x" && table->names[1] == "y";
            if (!table->names.empty() && !footprint && !(table->names[0] == "u" && table->names[1] == "v"))
                r.wrong("file", fmt::format("has columns {}; name them u,v{}", fmt::join(table->names, ","),
                                            curve ? "" : " (contacts) or x,y (footprint)"));
            else if (footprint && curve)
                r.wrong("file", "has columns x,y, but a curve is given in u,v; use pattern = \"points\" for a footprint");
            for (const auto& row : table->rows) (footprint ? xy : uv).emplace_back(row[0], row[1]);
        }
    }
    if (curve) {
        GivenCurve p;
        p.uv = std::move(uv);
        p.step = r.positive("step_mm", 0.0);
        if (ways == 1 && p.uv.size() == 1) r.wrong("uv", "holds one point; a curve needs at least two");
        return p;
    }
    GivenPoints p;
    p.uv = std::move(uv);
    p.xy = std::move(xy);
    p.drop_axis = r.direction("drop_axis").value_or(p.drop_axis);
    return p;
}

ordered_json json_of_given_path(const Pattern& pattern) {
    ordered_json j;
    if (const auto* c = std::get_if<GivenCurve>(&pattern)) {
        j = {{"pattern", GivenCurve::name}, {"uv", json_of(c->uv)}};
        if (c->step > 0.0) j["step_mm"] = c->step;
    } else if (const auto* p = std::get_if<GivenPoints>(&pattern)) {
        j = {{"pattern", GivenPoints::name}};
        if (!p->uv.empty())
            j["uv"] = json_of(p->uv);
        else
            j["xy"] = json_of(p->xy);
        j["drop_axis"] = {p->drop_axis.x(), p->drop_axis.y(), p->drop_axis.z()};
    }
    return j;
}

}  // namespace trunnion
