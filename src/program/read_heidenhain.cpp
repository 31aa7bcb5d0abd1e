// Conversational programs as a Heidenhain control reads them: straight five-axis moves under TCPM or M128, or in a plane.
#include <algorithm>

#include "program/dialects.hpp"
#include "program/motion_reader.hpp"
#include "program/plane.hpp"

namespace trunnion::detail {

namespace {

constexpr double kInch = 25.4;

class HeidenhainReader {
public:
    HeidenhainReader(const Machine& machine, double tool_length) : motion_(machine, tool_length, "heidenhain") {}

    Result<ProgramText> run(std::string_view text) {
        motion_.reserve(text.size() / 40);
        while (!text.empty()) {
            ++motion_.line;
            std::string_view line = trimmed(take_line(text));
            if (line.empty()) continue;
            if (ended_) return wrong("a block after END PGM");
            if (auto done = block_number(line); !done) return fail_up(std::move(done));
            line = trimmed(line.substr(0, line.find(';')));
            if (line.empty()) continue;
            if (auto done = block(line); !done) return fail_up(std::move(done));
        }
        if (!ended_) return wrong("END PGM is missing: the file is not complete");
        return motion_.finish();
    }

private:
    tl::unexpected<Error> wrong(std::string_view what) const { return motion_.wrong(what); }

    /// The control counts its blocks one by one; a gap is a block that got lost.
    Result<void> block_number(std::string_view& line) {
        long number = -1;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
        if (error != std::errc())
            return wrong(fmt::format("a block begins with its number, not with \"{}\"", comment_text(line, 20)));
        if (next_ >= 0 && number != next_)
            return wrong(fmt::format("block {} follows block {}: a block is missing", number, next_ - 1));
        next_ = number + 1;
        line = trimmed(line.substr(static_cast<std::size_t>(end - line.data())));
        return {};
    }
    static bool take(std::string_view& text, std::string_view word) {
        if (!text.starts_with(word)) return false;
        const std::string_view rest = text.substr(word.size());
        if (!rest.empty() && rest.front() != ' ') return false;
        text = trimmed(rest);
        return true;
    }

    Result<void> block(std::string_view line) {
        const std::string all = upper(line);
        std::string_view rest = all;
        if (take(rest, "BEGIN PGM")) {
            if (began_) return wrong("BEGIN PGM a second time");
            began_ = true;
            name_ = rest;
            if (rest.ends_with(" INCH"))
                unit_ = kInch;
            else if (!rest.ends_with(" MM"))
                return wrong("BEGIN PGM says neither MM nor INCH");
            return {};
        }
        if (!began_) return wrong("the program does not begin with BEGIN PGM");
        if (take(rest, "END PGM")) {
            if (!stopped_) return wrong("END PGM without M30 or M2 before it");
            if (rest != name_)
                return wrong(fmt::format("END PGM {} closes BEGIN PGM {}: the line is cut or of another program",
                                         comment_text(rest, 24), comment_text(name_, 24)));
            ended_ = true;
            return {};
        }
        if (stopped_) return wrong("a block after the end of the program (M30)");
        if (take(rest, "LN")) return straight(rest, true);
        if (take(rest, "L")) return straight(rest, false);
        if (take(rest, "FUNCTION TCPM")) {
            std::array<std::string_view, 4> words{"F TCP", "AXIS POS", "PATHCTRL AXIS", "PATHCTRL VECTOR"};
            if (!take(rest, words[0]) || !take(rest, words[1]))
                return wrong("FUNCTION TCPM is read as F TCP AXIS POS PATHCTRL AXIS or VECTOR");
            if (take(rest, words[2]))
                motion_.set_meaning(Meaning::tip_axes), motion_.set_interpolation(Interpolation::rotary_axes);
            else if (take(rest, words[3]))
                motion_.set_meaning(Meaning::tip_vector), motion_.set_interpolation(Interpolation::great_circle);
            else
                return wrong("FUNCTION TCPM does not say PATHCTRL AXIS or PATHCTRL VECTOR");
            if (!rest.empty()) return wrong(fmt::format("\"{}\" after FUNCTION TCPM is not read", comment_text(rest, 24)));
            controlled_ = true;
            return {};
        }
        if (take(rest, "FUNCTION RESET TCPM")) return switch_off();
        if (take(rest, "PLANE SPATIAL")) return plane(rest);
        if (take(rest, "PLANE RESET")) return switch_off();
        for (const std::string_view word : {"TOOL CALL", "TOOL DEF", "BLK FORM", "CYCL DEF 32", "CYCL DEF 247", "STOP"})
            if (rest.starts_with(word)) return {};
        if (rest.front() == 'M') return machine_codes(rest);
        return wrong(fmt::format("\"{}\" is not read", comment_text(all, 24)));
    }

    Result<void> switch_off() {
        controlled_ = false;
        motion_.set_meaning(Meaning::machine);
        return {};
    }
    Result<void> machine_codes(std::string_view& rest) {
        while (!rest.empty() && rest.front() == 'M') {
            rest.remove_prefix(1);
            const auto number = take_number(rest, false);
            if (!number || !(rest.empty() || rest.front() == ' ')) return wrong("an M without its number");
            rest = trimmed(rest);
            if (*number == 128) {
                motion_.set_meaning(Meaning::tip_axes);
                motion_.set_interpolation(Interpolation::rotary_axes);
                controlled_ = true;
            } else if (*number == 129) {
                if (auto done = switch_off(); !done) return done;
            } else if (*number == 91) {
                machine_coordinates_ = true;
            } else if (*number == 30 || *number == 2) {
                stopped_ = true;
            } else if (const double known[] = {0, 3, 4, 5, 6, 7, 8, 9, 13, 14, 126, 127};
                       std::find(std::begin(known), std::end(known), *number) == std::end(known)) {
                return wrong(fmt::format("M{:g} is not a code that is read", *number));
            }
        }
        if (!rest.empty()) return wrong(fmt::format("\"{}\" is not read", comment_text(rest, 24)));
        return {};
    }

    Result<void> plane(std::string_view rest) {
        double angle[3] = {};
        const std::string_view names[] = {"SPA", "SPB", "SPC"};
        for (int k = 0; k < 3; ++k) {
            if (!rest.starts_with(names[k])) return wrong(fmt::format("PLANE SPATIAL without {}", names[k]));
            rest.remove_prefix(3);
            const auto number = take_number(rest, false);
            if (!number) return wrong(fmt::format("{} has no number", names[k]));
            angle[k] = radians(*number);
            rest = trimmed(rest);
        }
        if (rest != "STAY" && rest != "STAY SEQ+" && rest != "STAY SEQ-")
            return wrong("PLANE SPATIAL is read with STAY, after the rotary axes were placed by a block of their own");
        motion_.set_meaning(Meaning::plane, plane_xyz_fixed(angle[0], angle[1], angle[2]));
        controlled_ = true;
        return {};
    }

    /// L X+1 ... A+2 ... R0 F100 M.. and LN X Y Z [NX NY NZ] TX TY TZ R0 F.
    Result<void> straight(std::string_view rest, bool vector) {
        Move m;
        machine_coordinates_ = false;
        bool fast = false;
        while (!rest.empty()) {
            const char letter = rest.front();
            if (take(rest, "R0")) continue;
            if (take(rest, "FMAX")) {
                fast = true;
                continue;
            }
            if (letter == 'M') {
                // M128 in a block acts at its beginning, M129 at its end; blocks with M129 that move are not written by anyone.
                if (auto done = machine_codes(rest); !done) return done;
                continue;
            }
            const bool component = (letter == 'T' || letter == 'N') && rest.size() > 1 && rest[1] >= 'X' && rest[1] <= 'Z';
            const std::string name(rest.substr(0, component ? 2 : 1));
            if (component && !vector) return wrong(fmt::format("{} in a block L; it belongs to LN", name));
            rest.remove_prefix(name.size());
            const std::string_view at = rest;
            const auto number = take_number(rest, false);
            if (!number || !(rest.empty() || rest.front() == ' ' || rest.front() == ','))
                return wrong(fmt::format("word {} has no number (\"{}\")", name, comment_text(at, 20)));
            if (!rest.empty() && rest.front() == ',')
                return wrong(fmt::format("the decimal comma after {} is not read, write a point", name));
            rest = trimmed(rest);
            if (name == "F") {
                if (!(*number > 0)) return wrong("F must be greater than zero");
                feed_ = *number;
                continue;
            }
            if (component) {
                if (name[0] == 'N') continue;  // the surface's normal, for radius compensation, which is off (R0)
                const auto k = static_cast<std::size_t>(name[1] - 'X');
                if (m.has_vector[k]) return wrong(fmt::format("word {} stands twice in the block", name));
                m.vector[static_cast<int>(k)] = *number;
                m.has_vector.set(k);
                continue;
            }
            const int axis = motion_.axis_of(letter);
            if (axis < 0)
                return wrong(std::string_view("ABCUVWXYZ").find(letter) != std::string_view::npos
                                 ? fmt::format("word {} is not an axis of machine {}", letter, motion_.machine().name)
                                 : fmt::format("word {} is not read", letter));
            if (m.has[axis]) return wrong(fmt::format("word {} stands twice in the block", letter));
            m.value[axis] = axis < 3 ? *number * unit_ : *number;
            m.has.set(static_cast<std::size_t>(axis));
        }
        if (vector && motion_.meaning() != Meaning::tip_vector)
            return wrong("LN with a tool axis needs FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR");
        if (vector && !(m.has[0] && m.has[1] && m.has[2] && m.has_vector.all()))
            return wrong("LN needs all of X Y Z and TX TY TZ");
        if (!m.any()) return {};
        if (!controlled_ && !machine_coordinates_ && (m.has[0] || m.has[1] || m.has[2]))
            return wrong("a move of X Y Z without FUNCTION TCPM, M128 or PLANE is not read");
        m.machine_coordinates = machine_coordinates_;
        m.rapid = fast;
        m.feed = feed_ * unit_;
        return motion_.move(m);
    }

    MotionReader motion_;
    std::string name_{};  // with the unit
    long next_ = -1;
    double unit_ = 1.0, feed_ = 0.0;
    bool began_ = false, stopped_ = false, ended_ = false, controlled_ = false, machine_coordinates_ = false;
};

}  // namespace

Result<ProgramText> read_heidenhain(std::string_view text, const Machine& machine, double tool_length) {
    return HeidenhainReader(machine, tool_length).run(text);
}

}  // namespace trunnion::detail
