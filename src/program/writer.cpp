// The one writer: blocks and templates as the dialect's file describes them.
#include "program/writer.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "program/plane.hpp"
#include "program/text.hpp"

namespace trunnion::detail {

namespace {

/// G93 F word (1/min) of a motion without length: one millisecond.
constexpr double kInstantRate = 60000.0;
/// A linear axis whose growing word lifts the tool off the work.
constexpr double kAlongSpindle = 0.99;
constexpr std::size_t kPartNameLength = 60;

class Writer {
public:
    Writer(const MachinePath& path, const Dialect& dialect, const ProgramOptions& options)
        : path_(path), machine_(path.machine()), dialect_(dialect), options_(options) {
        plane_ = options.plane;
        tcp_ = options.tcp && !plane_;
        vector_ = dialect.vector && !plane_;
        machine_words_ = !tcp_ && !vector_ && !plane_;
        const int least = machine_words_ ? dialect.machine_decimals : 0;
        linear_decimals_ = std::max(dialect.linear_decimals, least);
        rotary_decimals_ = std::max(dialect.rotary_decimals, least);
        for (int j = 0; j < 3; ++j) {
            prefix_[j] = dialect.position[j];
            // Machine positions go by the names of the machine's axes.
            if ((machine_words_ || machine_plane()) && !prefix_[j].empty())
                prefix_[j] = std::string(1, machine_.linear[j].letter);
        }
        for (int j = 0; j < 3 && vector_; ++j) turn_prefix_[j] = dialect.direction[j];
        for (int j = 0; j < 2 && !vector_; ++j) turn_prefix_[j] = rotary_prefix(j);
        turn_words_ = plane_ ? 0 : vector_ ? 3 : 2;
        line_ = dialect.first_number;
        place_plane();
    }

    std::string run() {
        out_.reserve(2000 + path_.poses().size() * (static_cast<std::size_t>(linear_decimals_ + rotary_decimals_) * 5 + 30));
        write(dialect_.header);
        if (plane_) write(dialect_.plane_header);
        const auto& passes = path_.poses().passes;
        for (std::size_t k = 0; k < passes.size(); ++k) {
            remark(fmt::format("pass {}: {}", k, name_of(passes[k].kind)));
            for (std::size_t i = passes[k].first; i < passes[k].first + passes[k].count; ++i)
                i == 0 && dialect_.feed_line.empty() ? approach() : block(i, passes[k].rapid);
        }
        if (plane_) write(dialect_.plane_footer);
        write(dialect_.footer);
        return std::move(out_);
    }

private:
    bool machine_plane() const { return plane_ && dialect_.plane_angles == Dialect::PlaneAngles::offset; }
    std::string rotary_prefix(int j) const {
        std::string prefix = dialect_.rotary;
        return prefix.replace(prefix.find("{}"), 2, 1, machine_.rotary[j].letter);
    }

    // ---- numbers and lines -------------------------------------------------------------------------------------------

    void number(std::string& out, Decimal value) const {
        if (dialect_.number == Dialect::Number::sign && value.digits >= 0) out += '+';
        append(out, value);
        if (dialect_.number == Dialect::Number::point && is_whole(value)) out += '.';
    }
    static bool is_whole(Decimal value) { return value.digits % static_cast<std::int64_t>(kPowersOfTen[value.decimals]) == 0; }
    std::string text_of(double value, int decimals) const {
        std::string text;
        number(text, fixed(value, decimals));
        return text;
    }
    void begin_line() {
        if (dialect_.line_number.empty()) return;
        const std::size_t at = dialect_.line_number.find("{}");
        out_.append(dialect_.line_number, 0, at);
        char digits[16];
        out_.append(digits, std::to_chars(digits, digits + sizeof digits, line_).ptr);
        if (at != std::string::npos) out_.append(dialect_.line_number, at + 2);
        line_ += dialect_.number_step;
    }
    static bool is_program_number(std::string_view line) {
        return line.size() > 1 && line[0] == 'O' && line[1] >= '0' && line[1] <= '9';
    }
    /// Comments and the program's brackets carry no number, except where the control numbers every line.
    bool numbered(std::string_view line) const {
        return dialect_.syntax == Syntax::heidenhain || !(line.empty() || line.front() == '%' || is_program_number(line) ||
                                                          line.starts_with(trimmed(dialect_.comment[0])));
    }
    void remark(std::string_view text) {
        if (numbered(dialect_.comment[0])) begin_line();
        out_ += dialect_.comment[0];
        out_ += text;
        out_ += dialect_.comment[1];
        out_ += '\n';
    }

    // ---- templates ---------------------------------------------------------------------------------------------------

    bool holds(const std::string& condition) const {
        if (condition == "tcp") return tcp_;
        if (condition == "vector") return vector_;
        if (condition == "plane") return plane_;
        if (condition == "spindle") return options_.spindle_rpm > 0;
        if (condition == "lift") return lifting_axis() >= 0;
        if (condition == "blend") return options_.blend > 0;
        if (condition == "cutter") return options_.tool_diameter > 0;
        return condition == "invalid" && !path_.valid();
    }
    std::string rotary_words(double first, double second) const {
        return rotary_prefix(0) + text_of(degrees(first), rotary_decimals_) + ' ' + rotary_prefix(1) +
               text_of(degrees(second), rotary_decimals_);
    }
    std::string value_of(std::string_view name) const {
        const auto safe = [&](std::string_view text) { return comment_text(text, dialect_.comment_length); };
        if (name == "title")
            return safe(
                fmt::format("Trunnion {}: {}", TRUNNION_VERSION, options_.title.empty() ? "five-axis program" : options_.title));
        if (name == "part") return options_.title.empty() ? "PART" : comment_text(options_.title, kPartNameLength);
        if (name == "version") return TRUNNION_VERSION;
        if (name == "machine") return comment_text(machine_.name, 40);
        if (name == "tool") return fmt::format("{}", options_.tool_number);
        if (name == "length") return fmt::format("{:.4f}", path_.options().tool_length);
        if (name == "length6") return fmt::format("{:.6f}", path_.options().tool_length);
        if (name == "rpm") return fmt::format("{:.0f}", options_.spindle_rpm);
        if (name == "rpm3") return fmt::format("{:.3f}", options_.spindle_rpm);
        if (name == "diameter") return fmt::format("{:.6f}", options_.tool_diameter);
        if (name == "corner") return fmt::format("{:.6f}", options_.tool_corner);
        if (name == "blend") return fmt::format("{:.4f}", std::max(options_.blend, 1e-4));
        if (name == "tolerance") return fmt::format("{:.4f}", std::max(options_.blend, 1e-3));
        if (name == "rotary_zero") return rotary_words(0, 0);
        const JointPosition& first = path_.joints().front();
        if (name == "rotary") return rotary_words(first[3], first[4]);
        if (name == "lift") {
            const LinearAxis& axis = machine_.linear[lifting_axis()];
            return axis.letter + text_of(axis.limits.hi, linear_decimals_);
        }
        if (name == "plane_offset") {
            std::string words;
            for (int j = 0; j < 3; ++j)
                words += (j > 0 ? " " : "") + std::string(1, machine_.linear[j].letter) + text_of(offset_[j], linear_decimals_);
            return words;
        }
        if (name == "plane_sign") return first[3 + tilting_axis()] < 0 ? "-" : "+";
        TRUNNION_REQUIRE(name.starts_with("plane_"));
        return text_of(degrees(plane_angles_[name.back() - '1']), rotary_decimals_ + 2);
    }
    void write(const std::vector<TemplateLine>& lines) {
        for (const TemplateLine& line : lines) {
            if (!std::all_of(line.conditions.begin(), line.conditions.end(),
                             [&](const auto& c) { return holds(c.name) == c.wanted; }))
                continue;
            if (numbered(line.text)) begin_line();
            std::string_view rest = line.text;
            for (std::size_t at; (at = rest.find('{')) != std::string_view::npos;) {
                const std::size_t end = rest.find('}', at);
                out_ += rest.substr(0, at);
                out_ += value_of(rest.substr(at + 1, end - at - 1));
                rest.remove_prefix(end + 1);
            }
            out_ += rest;
            out_ += '\n';
        }
    }
    /// Index of the linear axis that lifts the tool, -1 if none does so alone.
    int lifting_axis() const {
        for (int j = 0; j < 3; ++j)
            if (machine_.linear[j].direction.dot(machine_.spindle) > kAlongSpindle) {
                // Under tool-centre-point control the word moves along the WCS, which must then be the same direction.
                const bool along_word =
                    machine_.linear[j].letter == 'Z' && j == 2 && machine_.linear[j].direction.z() > kAlongSpindle;
                return machine_words_ || along_word ? j : -1;
            }
        return -1;
    }

    /// The rotary axis that tilts the tool: of two tables the one below, of two heads the one at the spindle, else the head.
    int tilting_axis() const {
        const Side first = machine_.rotary[0].side, second = machine_.rotary[1].side;
        if (first == second) return first == Side::table ? 0 : 1;
        return first == Side::head ? 0 : 1;
    }

    // ---- the plane ---------------------------------------------------------------------------------------------------

    void place_plane() {
        if (!plane_) return;
        const Vec3 T = path_.poses().axis.front();
        const double tilt = std::atan2(std::hypot(T.x(), T.y()), T.z());
        switch (dialect_.plane_angles) {
            case Dialect::PlaneAngles::zxz: {
                // T = Rz(I) Rx(J) e_z = (sin I sin J, -cos I sin J, cos J); K turns the plane's X back towards the part's.
                const double i = tilt > 0 ? std::atan2(T.x(), -T.y()) : 0.0;
                plane_angles_ = {i, tilt, -i};
                break;
            }
            case Dialect::PlaneAngles::xyz_moving:
                // T = Rx(A) Ry(B) e_z = (sin B, -sin A cos B, cos A cos B)
                plane_angles_ = {std::atan2(-T.y(), T.z()), std::atan2(T.x(), std::hypot(T.y(), T.z())), 0.0};
                break;
            case Dialect::PlaneAngles::xyz_fixed:
                // T = Ry(B) Rx(A) e_z = (sin B cos A, -sin A, cos B cos A)
                plane_angles_ = {std::atan2(-T.y(), std::hypot(T.x(), T.z())), std::atan2(T.x(), T.z()), 0.0};
                break;
            default: {
                // No plane: the linear axes from the origin of the part in the turned position.
                const JointPosition& q = path_.joints().front();
                const JointPosition origin = joints_at(machine_, Vec3::Zero(), q[3], q[4], path_.options().tool_length);
                for (int j = 0; j < 3; ++j)
                    offset_[j] = static_cast<double>(fixed(origin[j], linear_decimals_).digits) / kPowersOfTen[linear_decimals_];
                return;
            }
        }
        // What stands in the program is what the control will turn by.
        for (double& angle : plane_angles_) {
            const int decimals = rotary_decimals_ + 2;
            angle = radians(static_cast<double>(fixed(degrees(angle), decimals).digits) / kPowersOfTen[decimals]);
        }
        const auto [a, b, c] = plane_angles_;
        to_plane_ = (dialect_.plane_angles == Dialect::PlaneAngles::zxz          ? plane_zxz(a, b, c)
                     : dialect_.plane_angles == Dialect::PlaneAngles::xyz_moving ? plane_xyz_moving(a, b, c)
                                                                                 : plane_xyz_fixed(a, b, c))
                        .transpose();
    }

    // ---- blocks ------------------------------------------------------------------------------------------------------

    using Words = std::array<Decimal, 6>;  // position, then rotary words or vector

    Words words(std::size_t i) const {
        const JointPosition& joints = path_.joints()[i];
        Words words{};
        Vec3 position = path_.poses().cl[i];
        if (machine_words_ || machine_plane())
            for (int j = 0; j < 3; ++j) position[j] = joints[j] - offset_[j];
        else if (plane_)
            position = to_plane_ * position;
        for (int j = 0; j < 3; ++j) words[j] = fixed(position[j], linear_decimals_);
        if (vector_)
            for (int j = 0; j < 3; ++j) words[3 + j] = fixed(path_.poses().axis[i][j], dialect_.vector_decimals);
        else
            for (int j = 0; j < turn_words_; ++j) words[3 + j] = fixed(degrees(joints[3 + j]), rotary_decimals_);
        return words;
    }

    void open(bool rapid) {
        begin_line();
        fresh_ = true;
        if (rapid != rapid_ || dialect_.motion_always || !moved_) {
            const std::string& word = rapid ? dialect_.rapid : dialect_.cut;
            out_ += word;
            fresh_ = word.back() == '/';
        }
        rapid_ = rapid;
        moved_ = true;
    }
    void separate() {
        if (!fresh_) out_ += dialect_.separator;
        fresh_ = false;
    }
    void word(const std::string& prefix, Decimal value) {
        separate();
        out_ += prefix;
        number(out_, value);
    }

    /// To the first pose: with machine positions the lifted axis comes down last. Where rapids may not be straight, the way down
    /// is a single axis or a move at feed.
    void approach() {
        const Words now = words(0);
        const bool at_feed = dialect_.links == Dialect::Links::at_feed && !machine_words_ && !machine_plane();
        const int up = machine_words_ || machine_plane() ? lifting_axis() : -1;
        open(!at_feed);
        for (int j = 0; j < 3 + turn_words_; ++j)
            if (j != up) word(j < 3 ? prefix_[j] : turn_prefix_[j - 3], now[j]);
        if (up >= 0) {
            close_rapid();
            out_ += '\n';
            moved_ = false;  // said again, as a line of its own
            open(true);
            word(prefix_[up], now[up]);
        }
        if (at_feed)
            tail(rounded_feed(machine_.rapid * 60.0), true);
        else
            close_rapid();
        words_ = now;
        finish(0);
    }
    void close_rapid() {
        if (!dialect_.tail.empty()) out_ += ' ' + dialect_.tail;
        if (!dialect_.rapid_feed.empty()) out_ += ' ' + dialect_.rapid_feed;
    }

    void block(std::size_t i, bool rapid) {
        const Words now = words(i);
        const auto changed = [&](int j) { return now[j] != words_[j]; };
        const bool moves = changed(0) || changed(1) || changed(2);
        bool turns = false;
        for (int j = 3; j < 3 + turn_words_; ++j) turns = turns || changed(j);
        if (dialect_.links == Dialect::Links::at_feed || (dialect_.links == Dialect::Links::turning_at_feed && tcp_ && turns))
            rapid = false;
        if (!dialect_.feed_line.empty()) lines_before(i, rapid);
        open(rapid);
        // A pose like the last one is a block all the same: a program has as many as the path has poses.
        const bool all = dialect_.position_always, same = !(moves || turns);
        for (int j = 0; j < 3; ++j)
            if (all || same || changed(j)) word(prefix_[j], now[j]);
        for (int j = 3; j < 3 + turn_words_; ++j)
            if (all || same || (vector_ ? turns : changed(j))) word(turn_prefix_[j - 3], now[j]);
        if (rapid)
            close_rapid();
        else if (dialect_.feed_line.empty())
            feed(i, moves, turns, now);
        words_ = now;
        finish(i);
    }

    Decimal rounded_feed(double value) const {
        Decimal feed = rounded(value, dialect_.feed_digits);
        if (feed.decimals > dialect_.feed_decimals) feed = fixed(value, dialect_.feed_decimals);
        // What rounds to nothing is the slowest feed that can be said.
        if (value > 0 && feed.digits <= 0) feed.digits = 1;
        return feed;
    }
    void feed(std::size_t i, bool moves, bool turns, const Words& now) {
        const double seconds = path_.time()[i] - path_.time()[i - 1];
        if (machine_words_) {
            tail(rounded_feed(seconds > 0 ? 60.0 / seconds : kInstantRate), true);
            return;
        }
        Decimal wanted = feed_;
        if (moves) {
            wanted = rounded_feed(path_.feed()[i] * 60.0);
        } else if (turns && seconds > 0) {  // the tip rests: degrees per minute
            double square = 0.0;
            for (int j = 3; j < 5 && !vector_; ++j) {
                const double step = static_cast<double>(now[j].digits - words_[j].digits) / kPowersOfTen[rotary_decimals_];
                square += step * step;
            }
            const auto& axis = path_.poses().axis;
            wanted = rounded_feed((vector_ ? degrees(angle_between(axis[i - 1], axis[i])) : std::sqrt(square)) * 60.0 / seconds);
        }
        if (wanted.digits <= 0) wanted = rounded_feed(path_.options().feed * 60.0);
        tail(wanted, wanted != feed_);
        feed_ = wanted;
    }
    void tail(Decimal feed, bool write_feed) {
        if (!dialect_.tail.empty()) out_ += ' ' + dialect_.tail;
        if (!write_feed) return;
        out_ += ' ';
        out_ += dialect_.feed;
        append(out_, feed);
        if (dialect_.number == Dialect::Number::point && is_whole(feed)) out_ += '.';
        feed_ = feed;
    }
    void lines_before(std::size_t i, bool rapid) {
        if (rapid) {
            out_ += dialect_.rapid_line + '\n';
        } else if (path_.feed()[i] > 0) {
            const Decimal now = rounded_feed(path_.feed()[i] * 60.0);
            if (now != feed_) {
                const std::size_t at = dialect_.feed_line.find("{}");
                out_.append(dialect_.feed_line, 0, at);
                append(out_, now);
                out_.append(dialect_.feed_line, std::min(dialect_.feed_line.size(), at + 2));
                out_ += '\n';
                feed_ = now;
            }
        }
        if (!path_.why()[i].empty()) remark("INVALID: " + comment_text(path_.why()[i], dialect_.comment_length));
    }
    void finish(std::size_t i) {
        if (!path_.why()[i].empty() && !dialect_.comment_on_own_line)
            out_ += ' ' + dialect_.comment[0] + "INVALID: " + comment_text(path_.why()[i], dialect_.comment_length) +
                    dialect_.comment[1];
        out_ += '\n';
    }

    const MachinePath& path_;
    const Machine& machine_;
    const Dialect& dialect_;
    const ProgramOptions& options_;
    bool plane_ = false, tcp_ = true, vector_ = false, machine_words_ = false;
    int linear_decimals_ = 4, rotary_decimals_ = 4, turn_words_ = 2;
    std::array<std::string, 3> prefix_{}, turn_prefix_{};
    std::array<double, 3> plane_angles_{};
    Vec3 offset_ = Vec3::Zero();
    Mat3 to_plane_ = Mat3::Identity();
    std::string out_{};
    int line_ = 0;
    Words words_{};
    Decimal feed_{-1, 0};
    bool rapid_ = true, moved_ = false, fresh_ = true;
};

}  // namespace

std::string write_in(const Dialect& dialect, const MachinePath& path, const ProgramOptions& options) {
    return Writer(path, dialect, options).run();
}

}  // namespace trunnion::detail
