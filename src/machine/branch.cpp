#include "machine/branch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion::detail {

namespace {

constexpr double kTurn = 2 * kPi;
/// Cost (s) of a motion that was not checked. More than any rotary travel, so that the fewest of them are taken.
constexpr double kUncheckedCost = 1e6;
/// On a link a little less: of equally many, those on links are taken.
constexpr double kUncheckedLinkCost = 0.999e6;
/// Beyond this turn per motion an axis does not follow the tool axis: that takes at most half a turn.
constexpr double kRewindAngle = 1.5 * kPi;
constexpr int kCountedTurns = 16;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// The states of one pose: solution x turns of each axis. An open axis has one state, its turn follows from the pose before.
struct Lattice {
    std::array<bool, 2> open{};
    std::array<int, 2> first{}, count{1, 1};

    int slots() const { return 2 * count[0] * count[1]; }
    int solution(int slot) const { return slot / (count[0] * count[1]); }
    int turn(int slot, int axis) const { return axis == 0 ? slot / count[1] % count[0] : slot % count[1]; }
    double word(int slot, int axis, double principal_word) const {
        return principal_word + kTurn * (first[axis] + turn(slot, axis));
    }
};

class BranchSearch {
public:
    BranchSearch(const Chain& chain, const CheckedPath& checked, std::span<const PoseChoices> poses,
                 std::span<const std::uint8_t> link, Lattice lattice)
        : chain_(chain),
          checked_(checked),
          axes_(checked.poses().axis),
          poses_(poses),
          link_(link),
          lattice_(lattice),
          slots_(lattice.slots()) {
        for (int j : {0, 1}) weight_[j] = 1.0 / limits(j).velocity;
        cos_range_ = {std::cos(chain.tilt_range().hi), std::cos(chain.tilt_range().lo)};
    }

    /// Poses before `start` are left for the caller.
    Result<Branch> run(std::size_t start, const Control& control) {
        const std::size_t n = poses_.size();
        std::vector<std::uint16_t> came_from(n * slots_);
        std::vector<State> now(slots_), next(slots_);
        std::vector<std::uint8_t> permitted(slots_);
        for (int slot = 0; slot < slots_; ++slot) now[slot] = entry(start, slot);
        for (std::size_t i = start + 1; i < n; ++i) {
            if (i % 4096 == 0 && control.cancelled()) return fail_cancelled("branch choice");
            std::uint16_t* origin = came_from.data() + i * slots_;
            if (!poses_[i].rotary.reachable) {
                for (int slot = 0; slot < slots_; ++slot) origin[slot] = static_cast<std::uint16_t>(slot);
                continue;
            }
            bool forced = true;
            for (int slot = 0; slot < slots_; ++slot) {
                permitted[slot] = allowed(i, slot);
                forced = forced && !permitted[slot];
            }
            for (int slot = 0; slot < slots_; ++slot) {
                next[slot].cost = kNever;
                if (!forced && !permitted[slot]) continue;
                for (int before = 0; before < slots_; ++before) {
                    if (now[before].cost == kNever || (poses_[i].rotary.free && !same_outer_state(before, slot))) continue;
                    const RotaryWords words = words_after(i, slot, now[before].words);
                    double cost = now[before].cost;
                    for (int j : {0, 1}) cost += weight_[j] * std::abs(words[j] - now[before].words[j]);
                    if (cost >= next[slot].cost) continue;
                    if (unchecked(i, before, now[before].words, slot, words))
                        cost += link_[i] ? kUncheckedLinkCost : kUncheckedCost;
                    if (cost >= next[slot].cost) continue;
                    next[slot] = {cost, words};
                    origin[slot] = static_cast<std::uint16_t>(before);
                }
            }
            std::swap(now, next);
        }
        return replay(start, now, came_from);
    }

private:
    struct State {
        double cost = kNever;
        RotaryWords words{};
    };
    const AxisLimits& limits(int axis) const { return chain_.machine().rotary[axis].limits; }
    double principal_word(std::size_t i, int slot, int axis) const {
        return poses_[i].rotary.words[lattice_.solution(slot)][axis];
    }

    bool allowed(std::size_t i, int slot) const {
        if (!(poses_[i].inside >> lattice_.solution(slot) & 1)) return false;
        for (int j : {0, 1}) {
            if (lattice_.open[j] || (poses_[i].rotary.free && j == chain_.outer())) continue;
            const double word = lattice_.word(slot, j, principal_word(i, slot, j));
            if (word < limits(j).lo - kTravelSlack || word > limits(j).hi + kTravelSlack) return false;
        }
        return true;
    }
    bool any_allowed(std::size_t i) const {
        for (int slot = 0; slot < slots_; ++slot)
            if (allowed(i, slot)) return true;
        return false;
    }
    /// At the pole the outer word and with it the state are carried, only the inner axis may change its turn.
    bool same_outer_state(int before, int slot) const {
        return lattice_.solution(before) == lattice_.solution(slot) &&
               lattice_.turn(before, chain_.outer()) == lattice_.turn(slot, chain_.outer());
    }
    State entry(std::size_t start, int slot) const {
        State state;
        if (any_allowed(start) && !allowed(start, slot)) return state;
        state.words = words_after(start, slot, {0.0, 0.0});
        state.cost = weight_[0] * std::abs(state.words[0]) + weight_[1] * std::abs(state.words[1]);
        return state;
    }
    RotaryWords words_after(std::size_t i, int slot, const RotaryWords& before) const {
        RotaryWords words;
        for (int j : {0, 1}) {
            const double word = principal_word(i, slot, j);
            if (poses_[i].rotary.free && j == chain_.outer())
                words[j] = before[j];
            else if (lattice_.open[j])
                words[j] = word + kTurn * nearest_whole((before[j] - word) / kTurn);
            else
                words[j] = lattice_.word(slot, j, word);
        }
        return words;
    }
    /// Does the motion towards pose i stray from the great circle? Judged at its middle, cheap answers first.
    bool unchecked(std::size_t i, int before, const RotaryWords& from, int slot, const RotaryWords& to) const {
        const PoseChoices &here = poses_[i], &last = poses_[i - 1];
        if (!last.rotary.reachable) return false;
        if (std::abs(to[0] - from[0]) > kRewindAngle || std::abs(to[1] - from[1]) > kRewindAngle) return true;
        const double slack = checked_.axis_slack(i);
        const RotaryMotion motion{from,     to,       axes_[i - 1],
                                  axes_[i], here.arc, std::max(last.rotary.sin_tilt, here.rotary.sin_tilt)};
        if (bend_bound(chain_, motion) / 8 <= slack) return false;
        // Solutions change hands only at the ends of the cone of reachable tilts, which the great circle must come near. Two
        // tilts differ at least by as much as their cosines.
        const auto [least, most] = std::minmax(last.rotary.cos_tilt, here.rotary.cos_tilt);
        if (lattice_.solution(before) != lattice_.solution(slot) && cos_range_.hi - most > here.arc + slack &&
            least - cos_range_.lo > here.arc + slack)
            return true;
        const Turned middle(chain_.machine(), 0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]));
        return angle_between(middle.axis(), slerp(axes_[i - 1], axes_[i], 0.5)) > slack;
    }
    Branch replay(std::size_t start, const std::vector<State>& last, const std::vector<std::uint16_t>& came_from) const {
        const std::size_t n = poses_.size();
        std::vector<std::uint16_t> slot(n);
        const auto best =
            std::min_element(last.begin(), last.end(), [](const State& a, const State& b) { return a.cost < b.cost; });
        slot[n - 1] = static_cast<std::uint16_t>(best - last.begin());
        for (std::size_t i = n - 1; i > start; --i) slot[i - 1] = came_from[i * slots_ + slot[i]];
        Branch branch{std::vector<RotaryWords>(n), std::vector<std::uint8_t>(n)};
        RotaryWords words = words_after(start, slot[start], {0.0, 0.0});
        for (std::size_t i = start; i < n; ++i) {
            if (i > start && poses_[i].rotary.reachable) words = words_after(i, slot[i], words);
            branch.words[i] = words;
            branch.label[i] = static_cast<std::uint8_t>(lattice_.solution(slot[i]));
        }
        return branch;
    }

    const Chain& chain_;
    const CheckedPath& checked_;
    std::span<const Vec3> axes_;
    std::span<const PoseChoices> poses_;
    std::span<const std::uint8_t> link_;
    Lattice lattice_;
    int slots_;
    std::array<double, 2> weight_{};
    Interval cos_range_;  // of the reachable tilts
};

/// Whole turns that may be added to words in [least, most] so that all of them stay inside the travel.
Interval whole_turns(const AxisLimits& limits, double least, double most) {
    return {std::ceil((limits.lo - kTravelSlack - least) / kTurn), std::floor((limits.hi + kTravelSlack - most) / kTurn)};
}

/// The turn nearest to `word` that keeps `principal_word` inside the travel; the word itself where none does.
double word_near(const AxisLimits& limits, double principal_word, double word) {
    const Interval turns = whole_turns(limits, principal_word, principal_word);
    const double nearest = nearest_whole((word - principal_word) / kTurn);
    return principal_word + kTurn * (turns.lo <= turns.hi ? std::clamp(nearest, turns.lo, turns.hi) : nearest);
}

/// Poses before the first that determines the outer word: they take its words, so that nothing turns on the way there.
void lead_in(const Chain& chain, std::span<const PoseChoices> poses, std::size_t start, Branch& branch) {
    const bool determined = start < poses.size();
    RotaryWords words{};
    const auto& limits = [&](int axis) -> const AxisLimits& { return chain.machine().rotary[axis].limits; };
    if (determined)
        words = branch.words[start];
    else
        words[chain.outer()] = std::clamp(0.0, limits(chain.outer()).lo, limits(chain.outer()).hi);
    const std::uint8_t label = determined ? branch.label[start] : 0;
    for (std::size_t i = std::min(start, poses.size()); i-- > 0;) {
        const int inner = chain.inner();
        if (poses[i].rotary.reachable) words[inner] = word_near(limits(inner), poses[i].rotary.words[label][inner], words[inner]);
        branch.words[i] = words;
        branch.label[i] = label;
    }
}

/// Moves the turn that a carried outer word postponed to the motion after the pole to where it disturbs least.
void settle_poles(const Chain& chain, std::span<const PoseChoices> poses, std::span<const std::uint8_t> link, Branch& branch) {
    const int outer = chain.outer();
    const std::size_t n = poses.size();
    for (std::size_t first = 1; first < n; ++first) {
        if (!poses[first].rotary.free || poses[first - 1].rotary.free || !poses[first - 1].rotary.reachable) continue;
        std::size_t end = first;
        while (end < n && poses[end].rotary.free) ++end;
        if (end == n || !poses[end].rotary.reachable) continue;
        // Turn on the way to pose `at`: standing at the pole if the run has a motion of its own, on a link if it has one, else
        // where the tool leans least.
        std::size_t at = end - 1;
        if (at == first) {
            if (poses[end].rotary.sin_tilt < poses[first - 1].rotary.sin_tilt) continue;  // on leaving: as carried
        } else {
            for (std::size_t i = first + 1; i < end; ++i)
                if (link[i]) at = i;
        }
        for (std::size_t i = at; i < end; ++i) branch.words[i][outer] = branch.words[end][outer];
        first = end;
    }
}

}  // namespace

Result<Branch> choose_branch(const Chain& chain, const CheckedPath& checked, std::span<const PoseChoices> poses,
                             std::span<const std::uint8_t> link, const Control& control) {
    const std::size_t n = poses.size();
    std::size_t start = 0;
    while (start < n && (!poses[start].rotary.reachable || poses[start].rotary.free)) ++start;
    Branch branch;
    if (start == n) {
        branch.words.resize(n);
        branch.label.resize(n);
    } else {
        Lattice lattice;
        for (int j : {0, 1}) {
            const AxisLimits& limits = chain.machine().rotary[j].limits;
            lattice.open[j] = limits.hi - limits.lo >= 2 * kTurn;
            if (lattice.open[j]) continue;
            lattice.first[j] = static_cast<int>(std::ceil((limits.lo - kPi) / kTurn));
            lattice.count[j] = static_cast<int>(std::floor((limits.hi + kPi) / kTurn)) - lattice.first[j] + 1;
        }
        while (true) {
            auto found = BranchSearch(chain, checked, poses, link, lattice).run(start, control);
            if (!found) return found;
            branch = std::move(*found);
            // Shift the endless axes into their travel; count the turns of one that does not fit, and search again.
            bool fits = true;
            for (int j : {0, 1}) {
                if (!lattice.open[j]) continue;
                const AxisLimits& limits = chain.machine().rotary[j].limits;
                double least = kNever, most = -kNever;
                for (std::size_t i = start; i < n; ++i) {
                    least = std::min(least, branch.words[i][j]);
                    most = std::max(most, branch.words[i][j]);
                }
                const Interval turns = whole_turns(limits, least, most);
                const int counted = static_cast<int>(std::min(1e6, (limits.hi - limits.lo) / kTurn));
                if (turns.lo <= turns.hi) {
                    const double shift = kTurn * std::clamp(0.0, turns.lo, turns.hi);
                    for (std::size_t i = start; i < n && shift != 0; ++i) branch.words[i][j] += shift;
                } else if (counted <= kCountedTurns) {
                    fits = false;
                    lattice.open[j] = false;
                    lattice.first[j] = static_cast<int>(std::ceil((limits.lo - kPi) / kTurn));
                    lattice.count[j] = static_cast<int>(std::floor((limits.hi + kPi) / kTurn)) - lattice.first[j] + 1;
                }
            }
            if (fits) break;
        }
    }
    lead_in(chain, poses, start, branch);
    settle_poles(chain, poses, link, branch);
    return branch;
}

}  // namespace trunnion::detail
