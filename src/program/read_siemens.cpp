// Part programs as a Siemens 840D reads them: straight five-axis moves under TRAORI, in a swivelled plane, or of the bare axes.
#include <algorithm>
#include <vector>

#include "program/dialects.hpp"
#include "program/motion_reader.hpp"
#include "program/plane.hpp"

namespace trunnion::detail {

namespace {

constexpr double kInch = 25.4;

class SiemensReader {
public:
    SiemensReader(const Machine& machine, double tool_length) : motion_(machine, tool_length, "siemens") {}

    Result<ProgramText> run(std::string_view text) {
        motion_.reserve(text.size() / 40);
        while (!text.empty()) {
            ++motion_.line;
            std::string_view line = take_line(text);
            line = trimmed(line.substr(0, line.find(';')));
            if (line.empty()) continue;
            if (ended_) return wrong("words after the end of the program");
            if (auto done = block(line); !done) return fail_up(std::move(done));
        }
        if (!ended_) return wrong("the program has no end (M30, M17, M2): the file is not complete");
        return motion_.finish();
    }

private:
    tl::unexpected<Error> wrong(std::string_view what) const { return motion_.wrong(what); }
    static bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || c == '_'; }
    static bool is_digit(char c) { return c >= '0' && c <= '9'; }

    Result<void> block(std::string_view line) {
        if (line.front() == '/')
            return wrong("an optional block (/) depends on a switch of the control; remove the slash or the block");
        Move m;
        bool own_feed = false, ends = false;
        while (!(line = trimmed(line)).empty()) {
            const char letter = upper(line.front());
            if (!is_letter(letter)) return wrong(fmt::format("\"{}\" is not a word", comment_text(line, 20)));
            // A word of one letter carries its number; longer ones are keywords, or addresses with an equals sign.
            std::size_t length = 1;
            while (length < line.size() && is_letter(upper(line[length]))) ++length;
            if (length > 1) {
                const std::string keyword = upper(line.substr(0, length));
                std::size_t end = length;
                while (end < line.size() && is_digit(line[end])) ++end;
                const std::string name = keyword + std::string(line.substr(length, end - length));
                line.remove_prefix(end);
                if (auto done = command(name, line, m); !done) return done;
                continue;
            }
            line.remove_prefix(1);
            char index = 0;
            if (line.size() > 1 && is_digit(line[0]) && trimmed(line.substr(1)).starts_with('=')) {
                index = line[0];
                line = trimmed(line.substr(1));
            }
            line = trimmed(line);
            if (line.starts_with('=')) line = trimmed(line.substr(1));
            const std::string_view at = line;
            const auto number = take_number(line, false);
            if (!number)
                return wrong(fmt::format("word {} has no number (\"{}\"); variables are not read", letter, comment_text(at, 20)));
            if (!line.empty() && std::string_view("+-*/=(").find(line.front()) != std::string_view::npos)
                return wrong(fmt::format("the expression after {} is not read", letter));
            if (auto done = word(letter, index, *number, m, own_feed, ends); !done) return done;
        }
        if (m.any()) {
            if (kind_ == Kind::none) return wrong("axis words without G0 or G1");
            m.rapid = kind_ == Kind::rapid;
            if (!m.rapid && inverse_time_ && !own_feed) return wrong("G1 in G93 needs an F of its own");
            m.inverse_time = inverse_time_;
            m.feed = inverse_time_ ? feed_ : feed_ * unit_;
            if (traori_ && !m.machine_coordinates) {
                if (vectors_ < 0)
                    return wrong("neither ORIAXES nor ORIVECT is stated: how the tool turns would depend on the machine's data");
                if (m.has_vector.any() && vectors_ == 0)
                    return wrong("a tool axis (A3 B3 C3) under ORIAXES: how the axes reach it is not known");
                // Rotary words name the axes of the machine only with ORIMKS or ORIAXES and no orientation angles of the tool.
                if (vectors_ == 0 && !machine_orientation_)
                    return wrong("rotary words under ORIWKS: write ORIMKS, they are the machine's axes");
            }
            for (int j = 0; j < 3; ++j) m.value[j] *= unit_;
            if (auto done = motion_.move(m); !done) return done;
        }
        ended_ = ended_ || ends;
        return {};
    }

    Result<void> word(char letter, char index, double value, Move& m, bool& own_feed, bool& ends) {
        if (index != 0) {
            if (index != '3' || letter < 'A' || letter > 'C') return wrong(fmt::format("word {}{} is not read", letter, index));
            const auto k = static_cast<std::size_t>(letter - 'A');
            if (m.has_vector[k]) return wrong(fmt::format("word {}3 stands twice in the block", letter));
            m.vector[static_cast<int>(k)] = value;
            m.has_vector.set(k);
            return {};
        }
        const int axis = motion_.axis_of(letter);
        if (axis >= 0) {
            if (m.has[axis]) return wrong(fmt::format("word {} stands twice in the block", letter));
            m.value[axis] = value;
            m.has.set(axis);
            return {};
        }
        if (letter == 'G') return code(value, m);
        if (letter == 'M') {
            const double known[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 30};
            if (std::find(std::begin(known), std::end(known), value) == std::end(known))
                return wrong(fmt::format("M{:g} is not a code that is read", value));
            ends = ends || value == 2 || value == 17 || value == 30;
            return {};
        }
        if (letter == 'F') {
            if (!(value > 0)) return wrong("F must be greater than zero");
            feed_ = value;
            own_feed = true;
            return {};
        }
        if (letter == 'N' || letter == 'S' || letter == 'T' || letter == 'D') return {};
        if (std::string_view("ABCUVWXYZ").find(letter) != std::string_view::npos)
            return wrong(fmt::format("word {} is not an axis of machine {}", letter, motion_.machine().name));
        return wrong(fmt::format("word {} is not read", letter));
    }

    Result<void> code(double value, Move& m) {
        if (value == 0) {
            kind_ = Kind::rapid;
        } else if (value == 1) {
            kind_ = Kind::feed;
        } else if (value == 53) {
            m.machine_coordinates = true;
        } else if (value == 70 || value == 700) {
            unit_ = kInch;
        } else if (value == 71 || value == 710) {
            unit_ = 1.0;
        } else if (value == 93) {
            inverse_time_ = true;
        } else if (value == 94) {
            if (inverse_time_) feed_ = 0.0;
            inverse_time_ = false;
        } else if (value == 91) {
            return wrong("G91: incremental positions are not read, use G90");
        } else if (value == 2 || value == 3) {
            return wrong("arcs are not read, only straight moves");
        } else {
            const double harmless[] = {17, 40, 54, 60, 64, 90, 601, 602, 603, 641, 642, 645};
            if (std::find(std::begin(harmless), std::end(harmless), value) == std::end(harmless))
                return wrong(fmt::format("G{:g} is not a code that is read", value));
        }
        return {};
    }

    Result<void> command(const std::string& name, std::string_view& rest, Move& m) {
        rest = trimmed(rest);
        if (name == "TRAORI") {
            if (rest.starts_with('(')) rest.remove_prefix(std::min(rest.size(), rest.find(')') + 1));
            traori_ = true;
            orient();
        } else if (name == "TRAFOOF") {
            traori_ = false;
            motion_.set_meaning(Meaning::machine);
        } else if (name == "ORIAXES" || name == "ORIVECT" || name == "ORIPLANE") {
            vectors_ = name == "ORIAXES" ? 0 : 1;
            if (traori_) orient();
        } else if (name == "ORIMKS" || name == "ORIWKS") {
            machine_orientation_ = name == "ORIMKS";
        } else if (name == "SUPA") {
            m.machine_coordinates = true;
        } else if (name == "CYCLE800") {
            return swivel(rest);
        } else if (name == "MSG" && rest.starts_with('(')) {
            rest = {};
        } else {
            return wrong(fmt::format("\"{}\" is not read", comment_text(name, 24)));
        }
        return {};
    }
    void orient() {
        motion_.set_meaning(vectors_ > 0 ? Meaning::tip_vector : Meaning::tip_axes);
        motion_.set_interpolation(vectors_ > 0 ? Interpolation::great_circle : Interpolation::rotary_axes);
    }

    /// CYCLE800(retract, "frame", new, mode, X0, Y0, Z0, A, B, C, X1, Y1, Z1, direction, ...); empty: back to the base plane.
    Result<void> swivel(std::string_view& rest) {
        const std::size_t close = rest.find(')');
        if (!rest.starts_with('(') || close == std::string_view::npos) return wrong("CYCLE800 without its brackets");
        std::string_view list = trimmed(rest.substr(1, close - 1));
        rest.remove_prefix(close + 1);
        if (list.empty()) {
            motion_.set_meaning(Meaning::machine);
            return {};
        }
        std::vector<double> values;
        while (true) {
            const std::size_t comma = list.find(',');
            std::string_view item = trimmed(list.substr(0, comma));
            double value = 0.0;
            if (!item.empty() && item.front() != '"') {
                const auto number = take_number(item, false);
                if (!number || !trimmed(item).empty())
                    return wrong(fmt::format("parameter {} of CYCLE800 cannot be read", values.size() + 1));
                value = *number;
            }
            values.push_back(value);
            if (comma == std::string_view::npos) break;
            list.remove_prefix(comma + 1);
        }
        if (values.size() < 14) return wrong(fmt::format("CYCLE800 needs 14 parameters, it has {}", values.size()));
        if (values[3] != 57)
            return wrong(fmt::format("CYCLE800 in mode {:g} is not read, only 57 (axis by axis, X Y Z)", values[3]));
        for (const std::size_t k : {4, 5, 6, 10, 11, 12})
            if (values[k] != 0) return wrong("CYCLE800 that moves the origin is not read");
        motion_.set_meaning(Meaning::plane, plane_xyz_moving(radians(values[7]), radians(values[8]), radians(values[9])));
        return {};
    }

    enum class Kind { none, rapid, feed };
    MotionReader motion_;
    Kind kind_ = Kind::none;
    double unit_ = 1.0, feed_ = 0.0;
    int vectors_ = -1;  // 1: the tool turns on a great circle, 0: the axes run evenly, -1: not stated
    bool inverse_time_ = false, ended_ = false, traori_ = false, machine_orientation_ = false;
};

}  // namespace

Result<ProgramText> read_siemens(std::string_view text, const Machine& machine, double tool_length) {
    return SiemensReader(machine, tool_length).run(text);
}

}  // namespace trunnion::detail
