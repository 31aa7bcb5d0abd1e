// Strict reading of TOML tables: every key is known, every message has file, line and key (private to the sources).
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "trunnion/base/file.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

/// Collects the first error of a whole document, so that a reader is a plain list of its keys.
struct TomlErrors {
    std::string source;
    std::optional<Error> first;

    void add(toml::source_index line, std::string message) {
        if (first) return;
        // Line 0: the value did not come from the file but from a setting.
        const std::string at = line > 0 ? fmt::format("{}:{}", source, line) : source;
        first = Error{ErrorCode::invalid_input, at + ": " + std::move(message), {}};
    }
};

/// One table. Getters return the value, or the default after recording what is wrong. finish() refuses unknown keys.
class TomlReader {
public:
    TomlReader(const toml::table* table, std::string name, TomlErrors& errors)
        : table_(table), name_(std::move(name)), errors_(errors) {}

    bool has(std::string_view key) const { return table_ && table_->contains(key); }
    bool is_text(std::string_view key) const { return has(key) && table_->get(key)->is_string(); }
    const std::string& name() const { return name_; }

    double number(std::string_view key, double fallback) {
        const toml::node* node = find(key);
        if (!node) return fallback;
        const auto value = node->value<double>();
        if (!node->is_number() || !value || !std::isfinite(*value)) {
            wrong(key, "must be a finite number");
            return fallback;
        }
        return *value;
    }
    double positive(std::string_view key, double fallback) {
        const double value = number(key, fallback);
        if (has(key) && !(value > 0.0)) wrong(key, fmt::format("= {:.6g} must be greater than zero", value));
        return value;
    }
    double not_negative(std::string_view key, double fallback) {
        const double value = number(key, fallback);
        if (has(key) && !(value >= 0.0)) wrong(key, fmt::format("= {:.6g} must not be negative", value));
        return value;
    }
    int integer(std::string_view key, int fallback, int least, int most) {
        const toml::node* node = find(key);
        if (!node) return fallback;
        const auto value = node->value_exact<int64_t>();
        if (!value || *value < least || *value > most) {
            wrong(key, fmt::format("must be a whole number from {} to {}", least, most));
            return fallback;
        }
        return static_cast<int>(*value);
    }
    bool flag(std::string_view key, bool fallback) {
        const toml::node* node = find(key);
        if (!node) return fallback;
        const auto value = node->value_exact<bool>();
        if (!value) wrong(key, "must be true or false");
        return value.value_or(fallback);
    }
    std::string text(std::string_view key, std::string fallback) {
        const toml::node* node = find(key);
        if (!node) return fallback;
        const auto value = node->value_exact<std::string>();
        if (!value) wrong(key, "must be a text in quotes");
        return value.value_or(fallback);
    }
    /// One of the words given; anything else is an error that names the nearest.
    std::string word(std::string_view key, std::string fallback, const std::vector<std::string_view>& known) {
        const std::string value = text(key, std::move(fallback));
        if (std::find(known.begin(), known.end(), value) != known.end()) return value;
        const std::string_view near = nearest_word(value, known);
        wrong(key, near.empty() ? fmt::format("= \"{}\" is not known; use one of {}", value, fmt::join(known, ", "))
                                : fmt::format("= \"{}\" is not known; did you mean \"{}\"?", value, near));
        return value;
    }
    std::optional<std::vector<double>> numbers(std::string_view key, std::optional<std::size_t> count = {}) {
        const toml::node* node = find(key);
        if (!node) return {};
        auto values = flat(node->as_array());
        if (!values || (count && values->size() != *count)) {
            wrong(key, count ? fmt::format("must be {} finite numbers in brackets", *count)
                             : std::string("must be finite numbers in brackets"));
            return {};
        }
        return values;
    }
    std::optional<Vec3> vector(std::string_view key) {
        const auto v = numbers(key, 3);
        if (!v) return {};
        return Vec3((*v)[0], (*v)[1], (*v)[2]);
    }
    std::optional<Vec3> direction(std::string_view key) {
        const auto v = vector(key);
        if (!v) return {};
        const auto unit = UnitVector::from(*v);
        if (!unit) {
            wrong(key, "is a zero direction; give one such as [0, 0, 1]");
            return {};
        }
        return unit->vec();
    }
    std::vector<std::string> texts(std::string_view key) {
        const toml::node* node = find(key);
        if (!node) return {};
        std::vector<std::string> all;
        const toml::array* array = node->as_array();
        for (std::size_t i = 0; array && i < array->size(); ++i)
            if (const auto value = (*array)[i].value_exact<std::string>()) all.push_back(*value);
        if (!array || all.size() != array->size()) wrong(key, "must be texts in brackets, such as [\"vise.stl\"]");
        return all;
    }
    /// Nested arrays as they are, for control nets. nullptr if absent or not an array (recorded).
    const toml::array* array(std::string_view key) {
        const toml::node* node = find(key);
        if (!node) return nullptr;
        if (!node->is_array()) wrong(key, "must be an array in brackets");
        return node->as_array();
    }
    /// A sub-table; an absent one reads as empty.
    TomlReader table(std::string_view key) {
        const toml::node* node = find(key);
        if (node && !node->is_table()) wrong(key, "must be a table");
        return {node ? node->as_table() : nullptr, name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key), errors_};
    }
    /// An array of tables; a single table counts as one.
    std::vector<TomlReader> tables(std::string_view key) {
        std::vector<TomlReader> all;
        const toml::node* node = find(key);
        if (!node) return all;
        const std::string base = name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
        if (const toml::table* one = node->as_table()) {
            all.emplace_back(one, base, errors_);
        } else if (const toml::array* many = node->as_array()) {
            for (std::size_t i = 0; i < many->size(); ++i) {
                if (const toml::table* item = (*many)[i].as_table())
                    all.emplace_back(item, fmt::format("{}[{}]", base, i), errors_);
                else
                    wrong(key, "must hold tables in braces");
            }
        } else {
            wrong(key, "must be a table or an array of tables");
        }
        return all;
    }

    void wrong(std::string_view key, std::string_view what) {
        const toml::node* node = table_ ? table_->get(key) : nullptr;
        errors_.add(node ? node->source().begin.line : (table_ ? table_->source().begin.line : 0),
                    fmt::format("{}{}{} {}", name_, name_.empty() ? "" : ".", key, what));
    }

    /// Every key of the table must have been asked for by now.
    void finish() {
        if (!table_) return;
        for (const auto& [key, node] : *table_) {
            const std::string_view name = key.str();
            if (std::find(asked_.begin(), asked_.end(), name) != asked_.end()) continue;
            const std::string_view near = nearest_word(name, asked_);
            const std::string where = name_.empty() ? "" : fmt::format(" in [{}]", name_);
            errors_.add(key.source().begin.line,
                        near.empty() ? fmt::format("unknown key \"{}\"{}; known are {}", name, where, fmt::join(asked_, ", "))
                                     : fmt::format("unknown key \"{}\"{}; did you mean \"{}\"?", name, where, near));
        }
    }

    static std::optional<std::vector<double>> flat(const toml::array* array) {
        if (!array) return {};
        std::vector<double> values;
        for (const toml::node& item : *array) {
            const auto value = item.value<double>();
            if (!item.is_number() || !value || !std::isfinite(*value)) return {};
            values.push_back(*value);
        }
        return values;
    }

private:
    const toml::node* find(std::string_view key) {
        asked_.push_back(key);
        return table_ ? table_->get(key) : nullptr;
    }
    const toml::table* table_;
    std::string name_;
    TomlErrors& errors_;
    std::vector<std::string_view> asked_;  // string literals of the callers
};

}  // namespace trunnion
