// APT CLDATA (ISO 4343 words, as CAM systems write it). Statements that would move the tool in a way that is not read are
// refused; those that do not touch the path are passed over by name; anything else is unknown and an error.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "program/dialects.hpp"
#include "program/text.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion::detail {

namespace {

constexpr double kInch = 25.4;
/// Files of four decimals hold unit vectors to 1e-4; beyond this the three numbers are not meant as one.
constexpr double kAxisLengthSlack = 1e-3;
/// An arc becomes chords that leave it by this much (mm) at most.
constexpr double kArcChord = 5e-4;
/// Ends of an arc may miss its circle by this much (mm), and by this part of the radius: points have three decimals in many
/// files.
constexpr double kArcSlack = 0.01, kArcSlackOfRadius = 1e-3;

/// Free text up to the end of the line, slashes and commas included.
constexpr std::array<std::string_view, 7> kText{"PARTNO", "PPRINT", "TPRINT", "REMARK", "INSERT", "TITLE", "LETTER"};
/// Nothing of the tool path.
constexpr std::array<std::string_view, 38> kPassedOver{
    "CUTTER", "LOADTL", "LOAD",       "SELECT", "SELCTL", "TURRET", "TLDATA", "TOOL PATH", "TOOLNO", "SPINDL",
    "COOLNT", "TOLER",  "INTOL",      "OUTTOL", "MACHIN", "CLEARP", "DELAY",  "STOP",      "OPSTOP", "OPSKIP",
    "DISPLY", "PAINT",  "MODE",       "HEAD",   "SEQNO",  "CLAMP",  "LINTOL", "PLUNGE",    "RETRCT", "SYN",
    "PREFUN", "AUXFUN", "CATPROCESS", "AIR",    "REWIND", "PROBE",  "LEADER", "VERIFY"};
/// What they would do to the path is not known to this reader.
constexpr std::array<std::string_view, 16> kRefused{"ARCSLP", "CYCLE",  "CUTCOM", "TRANS",  "ORIGIN", "ROTATE",
                                                    "ROTABL", "ROTHED", "COPY",   "TRACUT", "INDEX",  "GODLTA",
                                                    "GOHOME", "GOTOS",  "THREAD", "INCLUD"};

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

class AptReader {
public:
    Result<ProgramText> run(std::string_view text) {
        program_.dialect = "apt";
        program_.blocks.reserve(text.size() / 80);
        int line = 0;
        bool continued = false, remark_continued = false;
        while (!text.empty()) {
            ++line;
            std::string_view part = trimmed(take_line(text));
            // Creo puts statements into comments ($$->); they are continued like others.
            const bool remark = remark_continued || part.starts_with("$$->");
            remark_continued = remark && part.ends_with('$');
            if (remark) continue;
            part = trimmed(part.substr(0, part.find("$$")));
            const bool more = !part.empty() && part.back() == '$';
            if (more) part = trimmed(part.substr(0, part.size() - 1));
            if (!continued) line_ = line;
            if (!continued && !more) {
                if (auto done = statement(part); !done) return fail_up(std::move(done));
                continue;
            }
            joined_ += part;
            continued = more;
            if (more) continue;
            if (auto done = statement(joined_); !done) return fail_up(std::move(done));
            joined_.clear();
        }
        if (continued) return wrong("the file ends in the middle of a statement that is continued ($)");
        if (circle_) return wrong("CIRCLE without the GOTO that ends its arc");
        if (!ended_) {
            line_ = line;
            return wrong("the file has no FINI and no END-OF-PATH: it is not complete");
        }
        return std::move(program_);
    }

private:
    tl::unexpected<Error> wrong(std::string_view what) const {
        return fail(ErrorCode::unreadable, fmt::format("line {}: {}", line_, what));
    }

    Result<void> statement(std::string_view text) {
        if (text.empty()) return {};
        if (finished_) return wrong("a statement after FINI");
        if (circle_ && text.starts_with("FINI")) return wrong("CIRCLE without the GOTO that ends its arc");
        const std::size_t slash = text.find('/');
        std::string_view arguments = slash == std::string_view::npos ? std::string_view() : text.substr(slash + 1);
        const std::string word = upper(trimmed(text.substr(0, slash)));
        if (word == "GOTO") return go_to(arguments);
        for (const std::string_view free : kText)
            if (word.starts_with(free)) return {};
        if (word == "FINI") {
            finished_ = ended_ = true;
            return {};
        }
        if (word == "END-OF-PATH" || word == "END") {
            ended_ = ended_ || word == "END-OF-PATH";
            return {};
        }
        if (word == "RAPID") {
            rapid_ = true;
            return {};
        }
        if (word == "FEDRAT") return feed_rate(arguments);
        if (word == "UNITS") return units(arguments);
        if (word == "MULTAX") return multax(arguments);
        if (word == "FROM") return from(arguments);
        if (word == "TLAXIS") {
            const auto values = numbers(arguments);
            if (!values) return tl::unexpected(values.error());
            if (values->size() != 3) return wrong("TLAXIS needs three numbers");
            return set_axis((*values)[0], (*values)[1], (*values)[2]);
        }
        if (word == "MSYS") return system(arguments);
        if (word == "CIRCLE") return circle(arguments);
        if (contains(kPassedOver, word)) return {};
        // Switched off they do nothing.
        if ((word == "CUTCOM" || word == "CYCLE" || word == "COPY" || word == "TRACUT") &&
            (upper(trimmed(arguments)) == "OFF" || upper(trimmed(arguments)) == "NOMORE"))
            return {};
        const std::string shown = comment_text(word, 24);
        if (contains(kRefused, word))
            return wrong(fmt::format("{} changes the path in a way that is not read; write the path as GOTO points", shown));
        static const std::vector<std::string_view> known = [] {
            std::vector<std::string_view> all(kPassedOver.begin(), kPassedOver.end());
            for (const std::string_view read : {"GOTO", "FROM", "RAPID", "FEDRAT", "UNITS", "MULTAX", "TLAXIS", "MSYS", "FINI",
                                                "END-OF-PATH", "PARTNO", "PPRINT"})
                all.push_back(read);
            return all;
        }();
        const std::string_view near = nearest_word(word, known);
        return wrong(near.empty() ? fmt::format("unknown statement \"{}\"", shown)
                                  : fmt::format("unknown statement \"{}\"; is \"{}\" meant?", shown, near));
    }

    struct Numbers {
        std::array<double, 12> value{};
        std::size_t count = 0;
        std::size_t size() const { return count; }
        double operator[](std::size_t i) const { return value[i]; }
    };
    /// Numbers separated by commas, nothing else.
    Result<Numbers> numbers(std::string_view text) const {
        Numbers found;
        while (true) {
            text = trimmed(text);
            if (found.count == found.value.size()) return wrong("too many numbers");
            const auto number = take_number(text, true);
            if (!number) return wrong(fmt::format("number {} cannot be read (\"{}\")", found.count + 1, comment_text(text, 20)));
            found.value[found.count++] = *number;
            text = trimmed(text);
            if (text.empty()) return found;
            if (text.front() != ',') return wrong(fmt::format("a comma is missing before \"{}\"", comment_text(text, 20)));
            text.remove_prefix(1);
        }
    }

    Result<void> set_axis(double i, double j, double k) {
        const double length = Vec3(i, j, k).norm();
        if (!(std::abs(length - 1.0) <= kAxisLengthSlack))
            return wrong(fmt::format("the tool axis ({:g}, {:g}, {:g}) has length {:.6g}, it must be 1", i, j, k, length));
        axis_ = Vec3(i, j, k) / length;
        return {};
    }

    /// Position and axis of GOTO and FROM.
    Result<Vec3> place(std::string_view arguments, std::string_view what) {
        const auto values = numbers(arguments);
        if (!values) return tl::unexpected(values.error());
        if (values->size() != 3 && values->size() != 6)
            return wrong(fmt::format("{} needs three numbers, or six with the tool axis; it has {}", what, values->size()));
        if (values->size() == 6) {
            if (single_axis_) return wrong(fmt::format("{} with a tool axis after MULTAX/OFF", what));
            if (auto done = set_axis((*values)[3], (*values)[4], (*values)[5]); !done) return tl::unexpected(done.error());
        }
        return Vec3((*values)[0], (*values)[1], (*values)[2]) * unit_;
    }
    Result<void> go_to(std::string_view arguments) {
        const auto position = place(arguments, "GOTO");
        if (!position) return tl::unexpected(position.error());
        if (circle_)
            if (auto done = arc_to(*position); !done) return done;
        add(*position);
        rapid_ = false;  // RAPID holds for one motion
        ended_ = false;
        return {};
    }
    void add(const Vec3& position) {
        ProgramBlock block;
        block.line = line_;
        block.rapid = rapid_;
        block.tip = {position, axis_};
        block.feed = rapid_ ? 0.0 : feed_;
        program_.blocks.push_back(block);
        last_ = position;
        last_axis_ = axis_;
    }

    struct Circle {
        Vec3 centre, axis;
        double radius;
    };
    /// CIRCLE/x,y,z,i,j,k,r,...: the way to the next GOTO is an arc of it, right-handed about (i, j, k).
    Result<void> circle(std::string_view arguments) {
        const auto v = numbers(arguments);
        if (!v) return tl::unexpected(v.error());
        if (v->size() < 7) return wrong(fmt::format("CIRCLE needs centre, axis and radius, seven numbers; it has {}", v->size()));
        const Vec3 axis((*v)[3], (*v)[4], (*v)[5]);
        if (!(std::abs(axis.norm() - 1.0) <= kAxisLengthSlack) || !((*v)[6] > 0))
            return wrong(fmt::format("CIRCLE has an axis of length {:.6g} and the radius {:g}", axis.norm(), (*v)[6]));
        if (circle_) return wrong("CIRCLE twice without a GOTO between");
        circle_ = Circle{Vec3((*v)[0], (*v)[1], (*v)[2]) * unit_, axis.normalized(), (*v)[6] * unit_};
        return {};
    }
    /// The chords before the last point.
    Result<void> arc_to(const Vec3& end) {
        const Circle c = *circle_;
        circle_.reset();
        if (!last_) return wrong("an arc (CIRCLE) before the first position");
        if (angle_between(*last_axis_, axis_) > kAxisLengthSlack)
            return wrong("an arc (CIRCLE) on which the tool axis turns is not read; write it as GOTO points");
        const auto across = [&](const Vec3& p) -> Vec3 { return (p - c.centre) - (p - c.centre).dot(c.axis) * c.axis; };
        const Vec3 from = across(*last_), to = across(end);
        const double slack = kArcSlack + kArcSlackOfRadius * c.radius;
        for (const Vec3& p : {from, to})
            if (std::abs(p.norm() - c.radius) > slack)
                return wrong(fmt::format("an end of the arc is {:.4f} mm from the centre of its CIRCLE, the radius is {:.4f}",
                                         p.norm(), c.radius));
        double angle = std::atan2(from.cross(to).dot(c.axis), from.dot(to));
        // Back where it began: once round.
        if (angle <= kArcSlack / c.radius) angle += 2 * kPi;
        const double step = 2 * std::acos(std::max(0.5, 1.0 - kArcChord / c.radius));
        const int pieces = static_cast<int>(std::min(1e5, std::ceil(angle / step)));
        const double rise = (end - *last_).dot(c.axis), radius = from.norm(), growth = to.norm() - radius;
        const Vec3 start = *last_, u = from / radius, v = c.axis.cross(u);
        const Vec3 foot = start - from;
        for (int k = 1; k < pieces; ++k) {
            const double t = static_cast<double>(k) / pieces;
            add(foot + t * rise * c.axis + (radius + t * growth) * (std::cos(t * angle) * u + std::sin(t * angle) * v));
        }
        return {};
    }
    /// Where the tool stands before the first motion: no motion itself.
    Result<void> from(std::string_view arguments) {
        const auto position = place(arguments, "FROM");
        if (!position) return tl::unexpected(position.error());
        last_ = *position;
        last_axis_ = axis_;
        return {};
    }

    Result<void> feed_rate(std::string_view arguments) {
        // The number and the unit come in either order; without a unit it is per minute in the unit of the file.
        double value = -1.0, unit = unit_;
        while (!arguments.empty()) {
            const std::size_t comma = arguments.find(',');
            std::string_view item = trimmed(arguments.substr(0, comma));
            arguments = comma == std::string_view::npos ? std::string_view() : arguments.substr(comma + 1);
            const std::string word = upper(item);
            if (word == "MMPM" || word == "MMPMIN") {
                unit = 1.0;
            } else if (word == "IPM") {
                unit = kInch;
            } else if (word == "PERMIN") {
                unit = unit_;
            } else if (word == "RAPID") {
                rapid_ = true;
                return {};
            } else {
                const auto number = take_number(item, true);
                if (!number || !item.empty() || value >= 0)
                    return wrong(fmt::format("\"{}\" in FEDRAT is not understood; a feed per minute is (MMPM, IPM, PERMIN)",
                                             comment_text(word, 20)));
                value = *number;
            }
        }
        if (!(value > 0)) return wrong("FEDRAT needs a number greater than zero");
        feed_ = value * unit / 60.0;
        return {};
    }

    Result<void> units(std::string_view arguments) {
        const std::string word = upper(trimmed(arguments));
        if (!program_.blocks.empty()) return wrong("UNITS after the first GOTO");
        if (word == "MM")
            unit_ = 1.0;
        else if (word == "INCHES" || word == "INCH" || word == "IN")
            unit_ = kInch;
        else if (word == "CM")
            unit_ = 10.0;
        else
            return wrong(fmt::format("UNITS/{} is not understood; MM, CM and INCHES are", comment_text(word, 20)));
        return {};
    }

    Result<void> multax(std::string_view arguments) {
        const std::string word = upper(trimmed(arguments));
        if (!word.empty() && word != "ON" && word != "OFF")
            return wrong(fmt::format("MULTAX/{} is not understood; ON and OFF are", comment_text(word, 20)));
        single_axis_ = word == "OFF";
        if (single_axis_) axis_ = Vec3::UnitZ();
        return {};
    }

    /// The coordinate system of the path: only the identity leaves the points as they are.
    Result<void> system(std::string_view arguments) {
        const auto values = numbers(arguments);
        if (!values) return tl::unexpected(values.error());
        constexpr std::array<double, 9> kIdentity{0, 0, 0, 1, 0, 0, 0, 1, 0};
        bool same = values->size() == kIdentity.size();
        for (std::size_t i = 0; i < kIdentity.size() && same; ++i)
            same = std::abs((*values)[i] - kIdentity[i]) < kAxisLengthSlack * 1e-3;
        if (!same)
            return wrong(
                "MSYS moves or turns the coordinate system, which is not read; write the path in the system of the part");
        return {};
    }

    ProgramText program_;
    std::string joined_;
    int line_ = 0;
    Vec3 axis_ = Vec3::UnitZ();
    std::optional<Vec3> last_, last_axis_;
    std::optional<Circle> circle_;
    double unit_ = 1.0, feed_ = 0.0;
    bool rapid_ = false, single_axis_ = false, ended_ = false, finished_ = false;
};

}  // namespace

Result<ProgramText> read_apt(std::string_view text) {
    return AptReader().run(text);
}

}  // namespace trunnion::detail
