// RS-274 as LinuxCNC reads it: the words that five-axis programs of straight moves use. Everything else is refused.
#include <algorithm>
#include <array>
#include <bitset>

#include <fmt/format.h>

#include "program/dialects.hpp"
#include "program/text.hpp"

namespace trunnion::detail {

namespace {

constexpr std::size_t kLongestLine = 255;  // LinuxCNC's own limit
constexpr double kInch = 25.4;

/// One line taken apart.
struct Line {
    std::array<double, 26> value{};
    std::bitset<26> has;
    std::vector<int> g, m;  // G codes in tenths: G61.1 is 611

    bool word(char letter) const { return has[static_cast<std::size_t>(letter - 'A')]; }
    double operator[](char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
    void clear() {
        has.reset();
        g.clear();
        m.clear();
    }
};

/// Modal group of a G code in tenths, -1 for codes that are not read. Two codes of a group in one line exclude each other.
int group_of(int code) {
    switch (code) {
        case 0:
        case 10:
        case 800:
            return 1;
        case 170:
            return 2;
        case 900:
            return 3;
        case 930:
        case 940:
            return 5;
        case 200:
        case 210:
            return 6;
        case 400:
            return 7;
        case 430:
        case 490:
            return 8;
        case 540:
        case 550:
            return 12;
        case 100:
            return 0;
        case 610:
        case 611:
        case 640:
            return 13;
        case 40:
        case 530:
            return 0;
        default:
            return -1;
    }
}

std::string_view hint(int code) {
    switch (code) {
        case 20:
        case 30:
            return "; arcs are not read, only straight moves";
        case 910:
            return "; incremental positions are not read, use G90";
        case 920:
        case 921:
        case 922:
        case 923:
            return "; offsets set by the program are not read";
        case 434:
        case 435:
            return "; LinuxCNC has no such code, its kinematics are always on";
        default:
            return "";
    }
}

class LinuxcncReader {
public:
    LinuxcncReader(const Machine& machine, double tool_length) : machine_(machine), tool_length_(tool_length) {
        program_.dialect = "linuxcnc";
        axis_of_.fill(-1);
        for (int j = 0; j < 3; ++j) axis_of_[machine.linear[j].letter - 'A'] = j;
        for (int j = 0; j < 2; ++j) axis_of_[machine.rotary[j].letter - 'A'] = 3 + j;
    }

    Result<ProgramText> run(std::string_view text) {
        program_.blocks.reserve(text.size() / 48);
        bool bracketed = false, began = false;
        while (!text.empty()) {
            ++line_;
            const std::string_view raw = trimmed(take_line(text));
            if (raw.size() > kLongestLine)
                return wrong(fmt::format("the line has {} characters, LinuxCNC reads {}", raw.size(), kLongestLine));
            if (raw == "%") {
                if (ended_) continue;
                ended_ = bracketed;
                if (began && !bracketed)
                    return wrong("a % in the middle of the program; it stands before the first line and after the last");
                bracketed = true;
                continue;
            }
            if (auto done = take_apart(raw); !done) return fail_up(std::move(done));
            const bool empty = words_.has.none() && words_.g.empty() && words_.m.empty();
            if (empty) continue;
            if (ended_) return wrong("words after the end of the program");
            began = true;
            if (auto done = execute(); !done) return fail_up(std::move(done));
        }
        if (!ended_) return wrong("the program has no end (M2, M30 or a closing %): the file is not complete");
        if (program_.blocks.empty())
            return wrong(fmt::format("the program never states a position of all five axes X Y Z {} {}",
                                     machine_.rotary[0].letter, machine_.rotary[1].letter));
        return std::move(program_);
    }

private:
    tl::unexpected<Error> wrong(std::string_view what) const {
        return fail(ErrorCode::unreadable, fmt::format("line {}: {}", line_, what));
    }

    /// Words of a line. Blanks do not count, not even inside numbers; comments are ( ) and everything after a semicolon.
    Result<void> take_apart(std::string_view raw) {
        words_.clear();
        code_.clear();
        for (std::size_t i = 0; i < raw.size(); ++i) {
            const char c = raw[i];
            if (c == ';') break;
            if (c == ')') return wrong("a ) without its (");
            if (c == '(') {
                const std::size_t end = raw.find_first_of("()", i + 1);
                if (end == std::string_view::npos) return wrong("a comment is not closed");
                if (raw[end] == '(') return wrong("a comment inside a comment");
                i = end;
                continue;
            }
            if (c == ' ' || c == '\t') continue;
            code_ += upper(c);
        }
        std::string_view rest = code_;
        if (!rest.empty() && rest.front() == '/')
            return wrong("an optional block (/) depends on a switch of the control; remove the slash or the block");
        while (!rest.empty()) {
            const char letter = rest.front();
            if (letter == '#' || letter == '[' || letter == 'O') return wrong("parameters, expressions and O words are not read");
            if (letter < 'A' || letter > 'Z') return wrong(fmt::format("\"{}\" is not a word", printable(rest)));
            rest.remove_prefix(1);
            if (!rest.empty() && (rest.front() == '#' || rest.front() == '['))
                return wrong("parameters and expressions are not read");
            const std::string_view at = rest;
            const auto number = take_number(rest, false);
            if (!number) return wrong(fmt::format("word {} has no number (\"{}\")", letter, printable(at)));
            if (letter == 'G' || letter == 'M') {
                if (auto done = add_code(letter, *number); !done) return done;
                continue;
            }
            if (words_.word(letter)) return wrong(fmt::format("word {} stands twice in the line", letter));
            words_.has.set(static_cast<std::size_t>(letter - 'A'));
            words_.value[static_cast<std::size_t>(letter - 'A')] = *number;
        }
        return {};
    }

    static std::string printable(std::string_view text) { return comment_text(text, 20); }

    Result<void> add_code(char letter, double number) {
        const double tenths = number * 10;
        const int code = tenths >= 0 && tenths < 10000 ? static_cast<int>(std::lround(tenths)) : -1;
        // Words like G1.04 are no codes.
        if (code < 0 || std::abs(tenths - code) > 1e-6) return wrong(fmt::format("{}{:g} is not a code", letter, number));
        if (letter == 'M') {
            static constexpr std::array kKnown{0, 10, 20, 300, 30, 40, 50, 60, 70, 80, 90};
            if (std::find(kKnown.begin(), kKnown.end(), code) == kKnown.end())
                return wrong(fmt::format("M{:g} is not a code that is read", number));
            words_.m.push_back(code);
            return {};
        }
        const int group = group_of(code);
        if (group < 0) return wrong(fmt::format("G{:g} is not a code that is read{}", number, hint(code)));
        for (const int other : words_.g)
            if (group_of(other) == group)
                return wrong(fmt::format("G{:g} and G{:g} exclude each other in one line", other / 10.0, number));
        words_.g.push_back(code);
        return {};
    }

    bool code(int tenths) const { return std::find(words_.g.begin(), words_.g.end(), tenths) != words_.g.end(); }

    Result<void> execute() {
        // Modes first, as in the order of execution of the standard.
        if (code(100)) return set_offset();
        if (code(540) || code(550)) {
            if (second_offset_ != code(550)) known_.reset();
            second_offset_ = code(550);
        }
        if (code(930)) inverse_time_ = true;
        if (code(940)) {
            if (inverse_time_) feed_ = 0.0;
            inverse_time_ = false;
        }
        if (code(200)) unit_ = kInch;
        if (code(210)) unit_ = 1.0;
        if (code(430) || code(490)) {
            if (code(430) && !words_.word('H') && !tool_) return wrong("G43 without H before any tool was named");
            if (code(430) != tcp_) known_.reset();  // the words mean other positions from here on
            tcp_ = code(430);
        }
        if (words_.word('T')) tool_ = true;
        if (code(0)) motion_ = Motion::rapid;
        if (code(10)) motion_ = Motion::feed;
        if (code(800)) motion_ = Motion::none;
        if (auto done = check_letters(); !done) return done;
        if (words_.word('F')) {
            if (!(words_['F'] > 0)) return wrong("F must be greater than zero");
            feed_ = words_['F'];
        }
        if (has_axis_words()) {
            if (auto done = move(); !done) return done;
        }
        for (const int m : words_.m)
            if (m == 20 || m == 300) ended_ = true;
        return {};
    }

    /// G10 L2 P2 X Y Z: where the work coordinates G55 begin.
    Result<void> set_offset() {
        if (!(words_.word('L') && words_['L'] == 2 && words_.word('P') && words_['P'] == 2))
            return wrong("G10 is read as G10 L2 P2 only, the offset of G55");
        for (int j = 3; j < 5; ++j)
            if (words_.word(machine_.rotary[j - 3].letter)) return wrong("an offset of a rotary axis is not read");
        for (std::size_t k = 0; k < 26; ++k) {
            if (!words_.has[k] || k == 'L' - 'A' || k == 'P' - 'A' || k == 'N' - 'A') continue;
            if (axis_of_[k] < 0) return wrong(fmt::format("word {} has no meaning in G10", static_cast<char>('A' + k)));
            offset_[axis_of_[k]] = words_.value[k] * unit_;
        }
        return {};
    }

    Result<void> check_letters() const {
        for (char letter = 'A'; letter <= 'Z'; ++letter) {
            if (!words_.word(letter)) continue;
            const bool known = axis_of_[letter - 'A'] >= 0 || letter == 'F' || letter == 'S' || letter == 'T' || letter == 'N' ||
                               (letter == 'H' && code(430)) || (letter == 'P' && (code(40) || code(640))) ||
                               (letter == 'Q' && code(640));
            if (known) continue;
            if (std::string_view("ABCUVWXYZ").find(letter) != std::string_view::npos)
                return wrong(fmt::format("word {} is not an axis of machine {} (X Y Z {} {})", letter, machine_.name,
                                         machine_.rotary[0].letter, machine_.rotary[1].letter));
            return wrong(fmt::format("word {} has no meaning here", letter));
        }
        return {};
    }

    bool has_axis_words() const {
        for (std::size_t k = 0; k < 26; ++k)
            if (words_.has[k] && axis_of_[k] >= 0) return true;
        return false;
    }

    Result<void> move() {
        if (motion_ == Motion::none) return wrong("axis words without G0 or G1");
        const bool rapid = motion_ == Motion::rapid;
        if (!rapid && inverse_time_ && !words_.word('F')) return wrong("G1 in G93 needs an F of its own");
        if (!rapid && !(feed_ > 0)) return wrong("G1 without a feed");
        const std::array<double, 5> last = position_;
        const bool knew_last = known_.all();
        for (std::size_t k = 0; k < 26; ++k) {
            const int axis = axis_of_[k];
            if (axis < 0 || !words_.has[k]) continue;
            position_[axis] = axis < 3 ? words_.value[k] * unit_ : words_.value[k];
            // Machine coordinates: where that is in the work depends on offsets that the program does not hold.
            known_.set(axis, !code(530));
        }
        if (!known_.all()) return {};

        ProgramBlock block;
        block.line = line_;
        block.rapid = rapid;
        block.has_joints = true;
        const double first = radians(position_[3]), second = radians(position_[4]);
        Vec3 linear(position_[0], position_[1], position_[2]);
        if (second_offset_) linear += offset_;
        if (second_offset_ && tcp_) return wrong("G55 under tool-centre-point control is not read");
        if (program_.blocks.empty()) {
            program_.tcp = tcp_;
            program_.interpolation = tcp_ ? Interpolation::rotary_axes : Interpolation::all_axes;
        }
        if (tcp_ != program_.tcp)
            return wrong("a move after the tool length was switched (G43, G49) in the middle of the program");
        block.joints = tcp_ ? joints_at(machine_, linear, first, second, tool_length_)
                            : JointPosition{linear.x(), linear.y(), linear.z(), first, second};
        block.tip = forward(machine_, block.joints, tool_length_);
        if (!rapid && knew_last && !program_.blocks.empty()) set_feed(block, last);
        program_.blocks.push_back(block);
        return {};
    }

    /// G93: F is 1/min. G94: F is along X Y Z, or degrees per minute where only rotary axes move.
    void set_feed(ProgramBlock& block, const std::array<double, 5>& last) const {
        double moved = 0.0, turned = 0.0;
        for (int j = 0; j < 3; ++j) moved += (position_[j] - last[j]) * (position_[j] - last[j]);
        for (int j = 3; j < 5; ++j) turned += (position_[j] - last[j]) * (position_[j] - last[j]);
        const double tip = (block.tip.cl - program_.blocks.back().tip.cl).norm();
        if (inverse_time_) {
            block.seconds = 60.0 / feed_;
        } else if (moved == 0.0) {
            block.seconds = std::sqrt(turned) * 60.0 / feed_;
        } else if (tcp_) {
            block.feed = feed_ * unit_ / 60.0;
            return;
        } else {
            block.seconds = std::sqrt(moved) * 60.0 / (feed_ * unit_);
        }
        if (block.seconds > 0) block.feed = tip / block.seconds;
    }

    enum class Motion { none, rapid, feed };
    const Machine& machine_;
    double tool_length_;
    std::array<int, 26> axis_of_{};
    ProgramText program_;
    Line words_;
    std::string code_;
    int line_ = 0;
    std::array<double, 5> position_{};  // words: mm, degrees
    std::bitset<5> known_;
    Motion motion_ = Motion::none;
    double unit_ = 1.0, feed_ = 0.0;
    Vec3 offset_ = Vec3::Zero();
    bool second_offset_ = false;
    bool inverse_time_ = false, tcp_ = false, tool_ = false, ended_ = false;
};

}  // namespace

Result<ProgramText> read_linuxcnc(std::string_view text, const Machine& machine, double tool_length) {
    return LinuxcncReader(machine, tool_length).run(text);
}

}  // namespace trunnion::detail
