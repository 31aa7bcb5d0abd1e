// What a control wants to read, as data: a file per dialect, one writer for all of them.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"

namespace trunnion {

/// A line of a template: written where every condition holds. Conditions: tcp, vector, plane, spindle, lift, blend, invalid.
struct TemplateLine {
    struct Condition {
        std::string name;
        bool wanted = true;
    };
    std::vector<Condition> conditions;
    std::string text;  ///< with {placeholders}
};

/// Which reader understands the program.
enum class Syntax { apt, linuxcnc, fanuc, siemens, heidenhain };

/// The contents of a dialect file; docs/dialects.md describes every key.
struct Dialect {
    std::string name, title, ending;
    std::string source;  ///< file or "built-in"
    Syntax syntax = Syntax::linuxcnc;
    bool vector = false;        ///< the tool axis is written as a vector, else as rotary words
    bool without_tcp = false;   ///< machine positions with inverse-time feed can be written too
    bool needs_machine = true;  ///< axis words: only a machine gives them meaning (not CLDATA)
    std::array<std::string, 2> comment{"(", ")"};
    std::size_t comment_length = 120;
    bool comment_on_own_line = false;  ///< remarks on bad blocks stand before them, not behind

    enum class Number { plain, point, sign };  ///< 10, 10., +10
    Number number = Number::plain;
    int linear_decimals = 4, rotary_decimals = 4, vector_decimals = 7;
    int machine_decimals = 6;  ///< of linear and rotary words without tool-centre-point control, at least
    int feed_digits = 7;       ///< significant
    int feed_decimals = 12;    ///< at most

    std::string line_number;  ///< "N{} ", empty for none
    int first_number = 10, number_step = 10;

    std::string cut, rapid;  ///< opening word of a block; left out while unchanged unless `motion_always`
    bool motion_always = false, position_always = false;
    std::array<std::string, 3> position{"X", "Y", "Z"};  ///< prefix of each number
    std::array<std::string, 3> direction{};              ///< of the vector
    std::string rotary = "{}";                           ///< prefix of a rotary word; {} is its letter
    std::string separator = " ";                         ///< between words
    std::string tail;                                    ///< between words and feed, "R0"
    std::string feed = "F", rapid_feed;                  ///< prefix of the feed; what stands there on rapids
    std::string feed_line, rapid_line;                   ///< lines of their own before the block, instead
    enum class Links { rapid, turning_at_feed, at_feed };
    Links links = Links::rapid;  ///< which links are cutting moves at the rapid speed, where rapids are not straight

    std::vector<TemplateLine> header, footer;
    /// Of a program in one tilted plane; empty where the control has none. Angles by `plane_angles`.
    std::vector<TemplateLine> plane_header, plane_footer;
    enum class PlaneAngles { none, zxz, xyz_moving, xyz_fixed, offset };
    PlaneAngles plane_angles = PlaneAngles::none;
};

/// Error: invalid_input with file and line: unknown or missing key, unknown placeholder or condition.
Result<Dialect> dialect_from_toml(std::string_view text, std::string_view source);
Result<Dialect> load_dialect(const std::filesystem::path& file);
/// Built-in dialect by name. Error: invalid_input naming the nearest one.
Result<Dialect> built_in_dialect(std::string_view name);

}  // namespace trunnion
