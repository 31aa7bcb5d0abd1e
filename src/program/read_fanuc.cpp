// Word-address programs as Fanuc and the controls built after it (Makino, Mitsubishi) read them: five-axis programs of straight
// moves. Everything else is refused.
#include <algorithm>
#include <vector>

#include "program/dialects.hpp"
#include "program/motion_reader.hpp"
#include "program/plane.hpp"

namespace trunnion::detail {

namespace {

constexpr double kInch = 25.4;

/// Codes in tenths that leave the path as it is.
constexpr int kHarmless[] = {50, 51, 170, 400, 540, 610, 640, 800, 900};

std::string_view hint(int code) {
    switch (code) {
        case 20:
        case 30:
            return "; arcs are not read, only straight moves";
        case 280:
            return "; it depends on the reference point, write G53";
        case 910:
            return "; incremental positions are not read, use G90";
        case 410:
        case 420:
            return "; radius compensation is not read";
        default:
            return "";
    }
}

class FanucReader {
public:
    FanucReader(const Machine& machine, double tool_length) : motion_(machine, tool_length, "fanuc") {}

    Result<ProgramText> run(std::string_view text) {
        motion_.reserve(text.size() / 40);
        bool bracketed = false, closed = false;
        while (!text.empty()) {
            ++motion_.line;
            const std::string_view line = trimmed(take_line(text));
            if (line.empty()) continue;
            if (closed) return wrong("text after the closing %");
            if (line == "%") {
                if (bracketed && !ended_) return wrong("a % before the end of the program (M30)");
                closed = bracketed;
                bracketed = true;
                continue;
            }
            if (auto done = take_apart(line); !done) return fail_up(std::move(done));
            if (auto done = execute(); !done) return fail_up(std::move(done));
        }
        if (!ended_) return wrong("the program has no end (M30, M2): the file is not complete");
        if (bracketed && !closed) return wrong("the closing % is missing: the file is not complete");
        return motion_.finish();
    }

private:
    tl::unexpected<Error> wrong(std::string_view what) const { return motion_.wrong(what); }

    /// A number without a point is one of the smallest increments on these controls.
    struct Word {
        double value = 0.0;
        bool point = false;
    };

    Result<void> take_apart(std::string_view line) {
        has_.reset();
        g_.clear();
        m_.clear();
        while (!(line = trimmed(line)).empty()) {
            const char letter = upper(line.front());
            if (letter == '(') {
                const std::size_t end = line.find_first_of("()", 1);
                if (end == std::string_view::npos) return wrong("a comment is not closed");
                if (line[end] == '(') return wrong("a comment inside a comment");
                line.remove_prefix(end + 1);
                continue;
            }
            if (letter == '/')
                return wrong("an optional block (/) depends on a switch of the control; remove the slash or the block");
            if (letter == '#' || letter == '[') return wrong("variables and macro expressions are not read");
            if (letter < 'A' || letter > 'Z') return wrong(fmt::format("\"{}\" is not a word", comment_text(line, 20)));
            line = trimmed(line.substr(1));
            if (!line.empty() && (line.front() == '#' || line.front() == '['))
                return wrong("variables and macro expressions are not read");
            const std::string_view at = line;
            const auto number = take_number(line, false);
            if (!number) return wrong(fmt::format("word {} has no number (\"{}\")", letter, comment_text(at, 20)));
            if (letter == 'G' || letter == 'M') {
                const double tenths = *number * 10;
                const int code = tenths >= 0 && tenths < 100000 ? static_cast<int>(std::lround(tenths)) : -1;
                if (code < 0 || std::abs(tenths - code) > 1e-6)
                    return wrong(fmt::format("{}{:g} is not a code", letter, *number));
                (letter == 'G' ? g_ : m_).push_back(code);
                continue;
            }
            const auto k = static_cast<std::size_t>(letter - 'A');
            if (has_[k]) return wrong(fmt::format("word {} stands twice in the block", letter));
            has_.set(k);
            words_[k] = {*number, at.substr(0, at.size() - line.size()).find('.') != std::string_view::npos};
        }
        return {};
    }

    bool has(char letter) const { return has_[static_cast<std::size_t>(letter - 'A')]; }
    const Word& word(char letter) const { return words_[static_cast<std::size_t>(letter - 'A')]; }
    bool code(int tenths) const { return std::find(g_.begin(), g_.end(), tenths) != g_.end(); }

    Result<void> execute() {
        if (has_.none() && g_.empty() && m_.empty()) return {};
        if (ended_) return wrong("words after the end of the program");
        bool tilt = false, machine_coordinates = false;
        std::string allowed = "NFSTOD";
        for (const int g : g_) {
            switch (g) {
                case 0:
                    motion_kind_ = Motion::rapid;
                    break;
                case 10:
                    motion_kind_ = Motion::feed;
                    break;
                case 200:
                    unit_ = kInch;
                    break;
                case 210:
                    unit_ = 1.0;
                    break;
                case 430:
                    allowed += 'H';
                    length_ = true;
                    break;
                case 434:
                case 435:
                    if (!has('H')) return wrong(fmt::format("G{:g} without H, the number of the tool length", g / 10.0));
                    if (plane_) return wrong("tool-centre-point control inside a tilted plane is not read");
                    allowed += 'H';
                    motion_.set_meaning(g == 434 ? Meaning::tip_axes : Meaning::tip_vector);
                    motion_.set_interpolation(g == 434 ? Interpolation::rotary_axes : Interpolation::great_circle);
                    break;
                case 490:
                    length_ = false;
                    if (motion_.meaning() != Meaning::plane) motion_.set_meaning(Meaning::machine);
                    break;
                case 530:
                    machine_coordinates = true;
                    break;
                case 531:
                    if (!plane_) return wrong("G53.1 without a plane (G68.2)");
                    break;
                case 682:
                    tilt = true;
                    allowed += "IJK";
                    break;
                case 690:
                    plane_ = false;
                    motion_.set_meaning(Meaning::machine);
                    break;
                case 930:
                    inverse_time_ = true;
                    break;
                case 940:
                    if (inverse_time_) feed_ = 0.0;
                    inverse_time_ = false;
                    break;
                case 50:
                case 51:
                    allowed += "PQ";
                    break;
                default:
                    if (std::find(std::begin(kHarmless), std::end(kHarmless), g) == std::end(kHarmless))
                        return wrong(fmt::format("G{:g} is not a code that is read{}", g / 10.0, hint(g)));
            }
        }
        if (motion_.meaning() == Meaning::tip_vector) allowed += "IJK";
        for (char letter = 'A'; letter <= 'Z'; ++letter) {
            if (!has(letter) || allowed.find(letter) != std::string::npos || motion_.axis_of(letter) >= 0) continue;
            if (std::string_view("ABCUVWXYZ").find(letter) != std::string_view::npos)
                return wrong(fmt::format("word {} is not an axis of machine {}", letter, motion_.machine().name));
            return wrong(fmt::format("word {} has no meaning here", letter));
        }
        for (const int m : m_) {
            static constexpr std::array kKnown{0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 300};
            if (std::find(kKnown.begin(), kKnown.end(), m) == kKnown.end())
                return wrong(fmt::format("M{:g} is not a code that is read", m / 10.0));
        }
        if (has('F')) {
            if (!(word('F').value > 0)) return wrong("F must be greater than zero");
            feed_ = word('F').value;
        }
        if (tilt) {
            if (auto done = tilt_plane(); !done) return done;
        } else if (auto done = move(machine_coordinates); !done) {
            return done;
        }
        for (const int m : m_) ended_ = ended_ || m == 20 || m == 300;
        return {};
    }

    Result<void> tilt_plane() {
        for (const char letter : {'X', 'Y', 'Z'})
            if (has(letter) && word(letter).value != 0.0)
                return wrong("a plane whose origin is moved is not read; write G68.2 X0. Y0. Z0.");
        const auto angle = [&](char letter) { return has(letter) ? radians(word(letter).value) : 0.0; };
        plane_ = true;
        motion_.set_meaning(Meaning::plane, plane_zxz(angle('I'), angle('J'), angle('K')));
        length_ = false;
        return {};
    }

    Result<void> move(bool machine_coordinates) {
        Move m;
        for (char letter = 'A'; letter <= 'Z'; ++letter) {
            if (!has(letter)) continue;
            const int axis = motion_.axis_of(letter);
            const bool component = letter >= 'I' && letter <= 'K' && motion_.meaning() == Meaning::tip_vector;
            if (axis < 0 && !component) continue;
            const Word& w = word(letter);
            if (!w.point && w.value != 0.0)
                return wrong(
                    fmt::format("{}{:g} has no decimal point: the control may count it in thousandths", letter, w.value));
            if (component) {
                m.vector[letter - 'I'] = w.value;
                m.has_vector.set(static_cast<std::size_t>(letter - 'I'));
            } else {
                m.value[axis] = axis < 3 ? w.value * unit_ : w.value;
                m.has.set(static_cast<std::size_t>(axis));
            }
        }
        if (!m.any()) return {};
        if (motion_kind_ == Motion::none) return wrong("axis words without G0 or G1");
        m.rapid = motion_kind_ == Motion::rapid;
        if (!m.rapid && inverse_time_ && !has('F')) return wrong("G1 in G93 needs an F of its own");
        if (motion_.meaning() == Meaning::plane && !length_ && m.has[0] && !machine_coordinates)
            return wrong("a move in the plane before the tool length (G43) is switched on");
        m.machine_coordinates = machine_coordinates;
        m.inverse_time = inverse_time_;
        m.feed = inverse_time_ ? feed_ : feed_ * unit_;
        return motion_.move(m);
    }

    enum class Motion { none, rapid, feed };
    MotionReader motion_;
    std::bitset<26> has_;
    std::array<Word, 26> words_{};
    std::vector<int> g_, m_;  // in tenths: G43.4 is 434
    Motion motion_kind_ = Motion::none;
    double unit_ = 1.0, feed_ = 0.0;
    bool inverse_time_ = false, ended_ = false, plane_ = false, length_ = false;
};

}  // namespace

Result<ProgramText> read_fanuc(std::string_view text, const Machine& machine, double tool_length) {
    return FanucReader(machine, tool_length).run(text);
}

}  // namespace trunnion::detail
