// RS-274 as LinuxCNC reads it: no exponents, no line above 255 characters, no nested comments.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "program/dialects.hpp"
#include "program/text.hpp"

namespace trunnion::detail {

namespace {

/// 5e-7 mm, and 9e-11 rad, which at 1 m from the pivot is 1e-7 mm.
constexpr int kLinearDecimals = 6, kRotaryDecimals = 8, kFeedDigits = 7;
constexpr std::size_t kCommentLength = 120;
/// G93 F word (1/min) of a motion without length: one millisecond.
constexpr double kInstantRate = 60000.0;
/// A linear axis whose growing word lifts the tool off the work.
constexpr double kAlongSpindle = 0.99;

using Words = std::array<Decimal, 5>;

class LinuxcncWriter {
public:
    LinuxcncWriter(const MachinePath& path, const ProgramOptions& options)
        : path_(path),
          machine_(path.machine()),
          options_(options),
          letters_{'X', 'Y', 'Z', machine_.rotary[0].letter, machine_.rotary[1].letter} {
        // Under tool-centre-point control X Y Z are the tip's coordinates in the WCS, whatever the machine's axes are called.
        for (int j = 0; j < 3 && !options.tcp; ++j) letters_[j] = machine_.linear[j].letter;
    }

    std::string run() {
        out_.reserve(1000 + path_.poses().size() * (options_.tcp ? 70 : 85));
        header();
        const auto& passes = path_.poses().passes;
        for (std::size_t k = 0; k < passes.size(); ++k) {
            out_ += fmt::format("(pass {}: {})\n", k, name_of(passes[k].kind));
            for (std::size_t i = passes[k].first; i < passes[k].first + passes[k].count; ++i)
                i == 0 ? approach() : block(i, passes[k].rapid);
        }
        if (!options_.tcp) out_ += "G94\n";
        if (options_.spindle_rpm > 0) out_ += "M5\n";
        // No G49: the tool length must not be switched while the rotary axes stand away from zero. The next program begins
        // by turning them to zero.
        out_ += "M2\n";
        return std::move(out_);
    }

private:
    void header() {
        const auto comment = [&](std::string_view text) { out_ += fmt::format("({})\n", comment_text(text, kCommentLength)); };
        comment(fmt::format("Trunnion {}: {}", TRUNNION_VERSION, options_.title.empty() ? "five-axis program" : options_.title));
        comment(fmt::format("machine {}, tool {} of length {:.4f} mm", machine_.name, options_.tool_number,
                            path_.options().tool_length));
        if (options_.tcp) {
            comment("tool-centre-point control: X Y Z are the tool tip in the work coordinates G54");
            comment("rapid links are G0, straight in these words; G1 where rotary axes turn, since joint speeds are not watched");
        } else {
            comment("no tool-centre-point control: machine positions of the gauge point, G54 must be zero");
            comment("rapid links are G0, which LinuxCNC moves straight in the axis positions, as the check assumed");
        }
        if (!path_.valid()) comment("NOT VALID: blocks marked INVALID were refused by the check");
        comment("start with the tool clear of the work");
        out_ += "G21 G17 G90 G94 G40 G80\n";
        out_ += options_.blend > 0 ? fmt::format("G64 P{:.4f}\n", std::max(options_.blend, 1e-4)) : "G61\n";
        // The pivot of the kinematics follows the tool length at once: with a rotary axis away from zero the joints would jump.
        out_ += fmt::format("G0 {}0 {}0\n", letters_[3], letters_[4]);
        out_ += "G49\n";
        out_ += fmt::format("T{} M6\n", options_.tool_number);
        if (options_.spindle_rpm > 0) out_ += fmt::format("S{:.0f} M3\n", options_.spindle_rpm);
        if (options_.tcp) out_ += fmt::format("G43 H{}\n", options_.tool_number);
        const int up = lifting_axis();
        if (up >= 0) {
            out_ += "G53 G0";
            append_word(out_, machine_.linear[up].letter, fixed(machine_.linear[up].limits.hi, kLinearDecimals));
            out_ += '\n';
        }
        if (!options_.tcp) out_ += "G93\n";
    }

    /// Index of the linear axis that lifts the tool, -1 if none does so alone.
    int lifting_axis() const {
        for (int j = 0; j < 3; ++j)
            if (machine_.linear[j].direction.dot(machine_.spindle) > kAlongSpindle) {
                // Under tool-centre-point control the word moves along the WCS, which must then be the same direction.
                return !options_.tcp ||
                               (machine_.linear[j].letter == 'Z' && j == 2 && machine_.linear[j].direction.z() > kAlongSpindle)
                           ? j
                           : -1;
            }
        return -1;
    }

    /// To the first pose: with machine positions the lifted axis comes down last.
    void approach() {
        words_ = words(0);
        out_ += "G0";
        const int up = options_.tcp ? -1 : lifting_axis();
        for (int j = 0; j < 5; ++j)
            if (j != up) append_word(out_, letters_[j], words_[j]);
        if (up >= 0) {
            out_ += "\nG0";
            append_word(out_, letters_[up], words_[up]);
        }
        rapid_ = true;
        finish(0);
    }

    Words words(std::size_t i) const {
        const JointPosition& joints = path_.joints()[i];
        Words words;
        for (int j = 0; j < 3; ++j) words[j] = fixed(options_.tcp ? path_.poses().cl[i][j] : joints[j], kLinearDecimals);
        for (int j = 3; j < 5; ++j) words[j] = fixed(degrees(joints[j]), kRotaryDecimals);
        return words;
    }

    void block(std::size_t i, bool rapid) {
        const Words now = words(i);
        const auto changed = [&](int j) { return now[j] != words_[j]; };
        const bool moves = changed(0) || changed(1) || changed(2), turns = changed(3) || changed(4);
        const std::size_t line = out_.size();
        if (options_.tcp && turns) rapid = false;
        if (rapid != rapid_) out_ += rapid ? " G0" : " G1";
        rapid_ = rapid;
        // A pose like the last one is a block all the same: a program has as many as the path has poses.
        for (int j = 0; j < 5; ++j)
            if (changed(j) || !(moves || turns)) append_word(out_, letters_[j], now[j]);
        if (!rapid) feed(i, moves, turns, now);
        words_ = now;
        out_.erase(line, 1);  // the blank before the first word
        finish(i);
    }

    void feed(std::size_t i, bool moves, bool turns, const Words& now) {
        const double seconds = path_.time()[i] - path_.time()[i - 1];
        if (!options_.tcp) {
            append_word(out_, 'F', rounded(seconds > 0 ? 60.0 / seconds : kInstantRate, kFeedDigits));
            return;
        }
        Decimal wanted = feed_;
        if (moves) {
            wanted = rounded(path_.feed()[i] * 60.0, kFeedDigits);
        } else if (turns && seconds > 0) {  // rotary axes alone: degrees per minute
            double square = 0.0;
            for (int j = 3; j < 5; ++j) {
                const double step = static_cast<double>(now[j].digits - words_[j].digits) / kPowersOfTen[kRotaryDecimals];
                square += step * step;
            }
            wanted = rounded(std::sqrt(square) * 60.0 / seconds, kFeedDigits);
        }
        if (wanted.digits <= 0) wanted = rounded(path_.options().feed * 60.0, kFeedDigits);
        if (wanted == feed_) return;
        append_word(out_, 'F', wanted);
        feed_ = wanted;
    }

    void finish(std::size_t i) {
        if (!path_.why()[i].empty()) out_ += fmt::format(" (INVALID: {})", comment_text(path_.why()[i], kCommentLength));
        out_ += '\n';
    }

    const MachinePath& path_;
    const Machine& machine_;
    const ProgramOptions& options_;
    std::array<char, 5> letters_;
    std::string out_;
    Words words_{};
    Decimal feed_{0, 0};
    bool rapid_ = true;
};

}  // namespace

std::string write_linuxcnc(const MachinePath& path, const ProgramOptions& options) {
    return LinuxcncWriter(path, options).run();
}

}  // namespace trunnion::detail
