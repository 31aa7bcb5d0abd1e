// Stage 2: circular rays, from the first contact to a proved tilt.
#include "pose/multipoint_position.hpp"

namespace trunnion::detail {

std::optional<Jet> Position::turn_at(const Field& field, bool own, bool up, double u, double v) const {
    SurfacePoint p = own ? near_->at(u, v) : field.at(u, v);
    if (!own) p.S -= insert_.P;
    const double centre = centre_of(field);
    if (p.S.squaredNorm() < centre * centre) return std::nullopt;  // the valley's business
    return turn_until(tool_, insert_, p, up);
}

Spot Position::polish_turn_rim(const RimPlace& start, bool up) {
    const std::uint32_t at = s_.rims.segments[start.segment].field;
    return polish_rim([&](double u, double v) { return turn_at(s_.fields[at], at == P_field_, up, u, v); }, start);
}

/// Second contacts on trimmed borders.
void Position::turn_rims(bool up, double& least, double margin, std::vector<Spot>& spots) {
    const auto& all = s_.rims.segments;
    const double wall = length_of(2.0 * tool_.Ro + tool_.Ri, tool_.top);
    const auto turn = [&](std::uint32_t k) {
        const RimSegment& s = all[k];
        const auto t = turn_at(s_.fields[s.field], s.field == P_field_, up, s.from.x(), s.from.y());
        return t ? t->f : kInfinity;
    };
    std::vector<std::pair<double, std::uint32_t>> starts;
    s_.rims.tree.visit(
        [&](const BoxNode& node) {
            const Vec3 gap = ((insert_.O1 - node.centre).cwiseAbs() - node.half).cwiseMax(0.0);
            return gap.squaredNorm() <= wall * wall;
        },
        [&](std::uint32_t k) {
            const double t = turn(k);
            if (!(t < least + margin)) return;
            if (t > turn(all[k].next) || t >= turn(all[k].previous)) return;
            least = std::min(least, t);
            starts.emplace_back(t, k);
        });
    std::sort(starts.begin(), starts.end());
    for (std::size_t k = 0; k < std::min(kMostSeeds, starts.size()); ++k)
        if (starts[k].first <= least + margin) spots.push_back(polish_turn_rim({starts[k].second, 0.0}, up));
}

Spot Position::polish_turn(const Spot& seed, bool up, double reach) {
    const Field& field = s_.fields[seed.field];
    const bool own = seed.field == P_field_;
    const auto turn = [&](double u, double v) { return turn_at(field, own, up, u, v); };
    const Minimum m = polish(turn, field, seed.u, seed.v, insert_.P + tool_.Ro * insert_.ev, reach);
    pose_.newton_steps += m.evaluations;
    Spot spot{seed.field, m.a, m.b, m.jet.f, field.at(m.a, m.b).S, m.jet, kind_at(field, m), settled(m)};
    if (!m.defined || !field.inside(m.a, m.b)) spot.value = kInfinity;
    return spot;
}

/// A closed tool cannot turn past T = n, where P would pass under the disc; nor back past the tube's equator.
double Position::merged_limit() const {
    return tool_.open ? kInfinity : -0.5 * kPi - std::atan2(insert_.Pw, insert_.Pv);
}

/// Near an interior P the turn has a limit that depends on the direction, and a valley leads from the lowest one to the second
/// contact. Along it in polar coordinates, where the turn is a smooth function of both (section 5.1).
void Position::along_valley(bool up, std::vector<Spot>& spots) {
    const Field& field = s_.fields[P_field_];
    const SurfacePoint p = near_->at(pose_.P_uv.x(), pose_.P_uv.y());
    const Vec3 n = pose_.normal, t2 = n.cross(insert_.eu).normalized(), t1 = insert_.eu;
    Eigen::Matrix2d J;
    J << p.Su.dot(t1), p.Sv.dot(t1), p.Su.dot(t2), p.Sv.dot(t2);
    if (!(std::abs(J.determinant()) > 1e-12 * J.squaredNorm())) return;
    const Eigen::Matrix2d M = J.inverse();
    const auto curvature = [&](const Vec2& x, const Vec2& y) {
        const Vec2 a = M * x, b = M * y;
        return n.dot(p.Suu) * a.x() * b.x() + n.dot(p.Suv) * (a.x() * b.y() + a.y() * b.x()) + n.dot(p.Svv) * a.y() * b.y();
    };
    const Vec2 one(1.0, 0.0), two(0.0, 1.0);
    const double k11 = curvature(one, one), k12 = curvature(one, two), k22 = curvature(two, two);
    const double across = 1.0 - tool_.Ri * k22, lambda = 1.0 - tool_.Ri * k11 - tool_.Ri * tool_.Ri * k12 * k12 / across;
    const double theta0 = std::atan2(tool_.Ri * k12, across);
    if (up && across > 0.0 && lambda > 0.0) {
        const double v = tool_.Ro * (1.0 - 1.0 / lambda);
        if (std::abs(v) <= tool_.Ri) {
            Spot spot{P_field_, pose_.P_uv.x(), pose_.P_uv.y(), 0.0, pose_.P, Jet(), MultipointContact::merged};
            spot.value = -std::acos(v / tool_.Ri) - std::atan2(insert_.Pw, insert_.Pv);
            if (spot.value >= 0.0) spots.push_back(spot);
        }
    }
    const double centre = centre_of(field);
    const Polar about{pose_.P_uv, M};
    const auto polar = [&](double s, double theta) -> std::optional<Jet> {
        if (std::abs(s) < centre) s = s < 0.0 ? -centre : centre;
        const Vec2 uv = about.at(s, theta);
        if (!field.u().contains(uv.x()) || !field.v().contains(uv.y())) return std::nullopt;
        const auto turn = turn_until(tool_, insert_, near_->at(uv.x(), uv.y()), up);
        if (!turn) return std::nullopt;
        return about.pull_back(*turn, s, theta);
    };
    const double far = 2.5 * s_.spacing;
    const Interval angles{theta0 - 0.5 * kPi, theta0 + 0.5 * kPi};
    for (const double side : {-1.0, 1.0}) {
        double theta = theta0;
        Minimum best;
        double s_best = 0.0;
        best.jet.f = kInfinity;
        if (up && !tool_.open) {
            // A closed tool on convex ground stops at T = n before anything near P is met.
            const double limit = merged_limit();
            bool lower = false;
            for (const double part : {0.05, 0.4, 1.0}) {
                const auto turn = polar(side * part * far, theta0);
                lower = lower || (turn && turn->f < limit);
            }
            if (!lower) continue;
        }
        for (const double part : {0.15, 0.7}) {
            const double s = side * part * far;
            const auto start = polar(s, theta);
            if (!start) continue;
            const Minimum m = minimise([&](double a, double b) { return polar(a, b); }, s, theta, {{s, s}, angles},
                                       {1.0, std::abs(s)}, 0.5 * std::abs(s), 1e-2 * std::abs(s));
            pose_.newton_steps += m.evaluations;
            theta = m.b;
            if (m.jet.f < best.jet.f) best = m, s_best = s;
        }
        if (!std::isfinite(best.jet.f)) continue;
        const Minimum m = minimise([&](double a, double b) { return polar(a, b); }, s_best, best.b, {{-far, far}, angles},
                                   {1.0, std::max(0.05 * far, std::abs(s_best))}, 0.5 * far);
        pose_.newton_steps += m.evaluations;
        const Vec2 uv = pose_.P_uv + m.a * (M * Vec2(std::cos(m.b), std::sin(m.b)));
        Spot spot{P_field_,
                  std::clamp(uv.x(), field.u().lo, field.u().hi),
                  std::clamp(uv.y(), field.v().lo, field.v().hi),
                  m.jet.f,
                  Vec3::Zero(),
                  m.jet,
                  MultipointContact::interior,
                  settled(m)};
        spot.S = field.at(spot.u, spot.v).S;
        if (field.inside(spot.u, spot.v)) spots.push_back(spot);
        // The valley may run on beyond, or into the border of the face.
        const bool at_end = std::abs(m.a) >= 0.99 * far;
        const bool at_border =
            !polar(m.a + std::copysign(0.05 * far, m.a), m.b) || !polar(m.a - std::copysign(0.05 * far, m.a), m.b);
        if ((at_end || at_border) && std::abs(m.a) > 0.02 * far) spots.push_back(polish_turn(spot, up, 0.5 * far));
    }
}

/// Around a P on an edge or corner: along the edge the turn has a limit too, elsewhere none; a ring of starts serves.
void Position::near_first(bool up, std::vector<Spot>& spots) {
    const Field& field = s_.fields[P_field_];
    const Vec2 scale = scale_of(near_->at(pose_.P_uv.x(), pose_.P_uv.y()));
    std::vector<Spot> starts;
    for (const double s : {0.05, 0.3, 1.0, 2.0})
        for (int k = 0; k < 8; ++k) {
            const double angle = 0.25 * kPi * k, r = s * s_.spacing;
            Spot spot;
            spot.field = P_field_;
            spot.u = pose_.P_uv.x() + r * std::cos(angle) / scale.x();
            spot.v = pose_.P_uv.y() + r * std::sin(angle) / scale.y();
            if (!field.u().contains(spot.u) || !field.v().contains(spot.v) || !field.inside(spot.u, spot.v)) continue;
            const auto turn = turn_until(tool_, insert_, near_->at(spot.u, spot.v), up);
            if (!turn) continue;
            spot.value = turn->f;
            starts.push_back(spot);
        }
    std::sort(starts.begin(), starts.end(),
              [](const Spot& a, const Spot& b) { return std::tie(a.value, a.u, a.v) < std::tie(b.value, b.u, b.v); });
    constexpr std::size_t kBest = 3;
    for (std::size_t k = 0; k < std::min(kBest, starts.size()); ++k)
        spots.push_back(polish_turn(starts[k], up, 0.3 * s_.spacing));
}

std::vector<Spot> Position::turn_spots(bool up) {
    std::vector<Spot> spots;
    const double limit = s_.options.max_tilt;
    if (up) {  // the other way the limit near P is that of P itself, at the tube's equator
        if (pose_.P_kind == MultipointContact::interior)
            along_valley(up, spots);
        else
            near_first(up, spots);
    }
    double least = limit;
    for (const Spot& s : spots)
        if (std::isfinite(s.value)) least = std::min(least, s.value);
    if (up) least = std::min(least, merged_limit());

    scratch_.seeds.clear();
    const double D2 = tool_.Ro + tool_.Ri, torus = 2.0 * tool_.Ro + tool_.Ri, wall = std::hypot(tool_.Ro + D2, tool_.top);
    // With P exact the samples find the turn to 0.24 deg at 24 across the shadow (section 9, item 4); what is worse by twice that
    // is no candidate. What hides deeper between samples the proof finds.
    const double margin = std::min(0.3, 0.01 * s_.spacing);
    Block cosines;
    s_.tile_tree.visit(
        [&](const BoxNode& node) {
            const Vec3 gap = ((insert_.O1 - node.centre).cwiseAbs() - node.half).cwiseMax(0.0);
            return gap.squaredNorm() <= wall * wall;
        },
        [&](std::uint32_t index) {
            const Tile& tile = s_.tiles[index];
            const Vec3 c = tile.centre - insert_.O1;
            const double distance = c.norm() - tile.radius;
            const double reach = std::min(limit, least + margin);
            const double most = c.norm() + tile.radius, highest = c.dot(insert_.ew) + tile.half.dot(insert_.ew.cwiseAbs());
            if (distance > wall) return;
            // From below a wall is met only by what comes to lie above the torus centre on the way.
            const double quarter = std::min(0.5 * kPi, reach), sine = std::sin(quarter), cosine = std::cos(quarter);
            const bool walls = !up || highest >= -most * sine;
            if (distance > torus && !walls) return;
            // The other way everything is met at w >= 0 and v >= -Ri, after passing below: the way there, from the point's angle
            // below the horizontal, is at least a quarter turn less asin(Ri / R). What can be met lies at
            // -w <= R sin(reach - quarter turn + asin(Ri / R)) = Ri sin(reach) - sqrt(R^2 - Ri^2) cos(reach).
            if (!up) {
                const double nearest = std::max(distance, tool_.Ri);
                const double below = tool_.Ri * sine - std::sqrt(nearest * nearest - tool_.Ri * tool_.Ri) * cosine;
                if (highest < -std::max(0.0, below)) return;
            }
            // No point of the tile moves farther against the tool than its distance from the line times the turn.
            if (tool_distance(tool_, {insert_.O1 + tool_.Ro * insert_.ev, insert_.ew}, tile.centre) - tile.radius > most * reach)
                return;
            scan_turns(tool_, tile, insert_, up, walls, 2.0 * s_.spacing, cosines);
            local_maxima(cosines, std::cos(std::min(kPi, reach)), [&](int k) {
                const Field& field = s_.fields[tile.field];
                Spot seed;
                seed.field = tile.field;
                seed.u = field.lattice_u[static_cast<std::size_t>(tile.first_u + k / Tile::kSide - 1)];
                seed.v = field.lattice_v[static_cast<std::size_t>(tile.first_v + k % Tile::kSide - 1)];
                seed.value = std::acos(std::min(1.0, cosines[static_cast<std::size_t>(k)]));
                scratch_.seeds.push_back(seed);
                least = std::min(least, seed.value);
            });
        });
    std::sort(scratch_.seeds.begin(), scratch_.seeds.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    constexpr std::size_t kBest = 5;
    if (scratch_.seeds.size() > kBest) scratch_.seeds.resize(kBest);
    for (std::size_t k = 0; k < scratch_.seeds.size(); ++k) {
        if (scratch_.seeds[k].value > least + margin) break;
        spots.push_back(polish_turn(scratch_.seeds[k], up, 2.0 * s_.spacing));
        if (spots.back().converged) least = std::min(least, spots.back().value);
    }
    if (!s_.rims.segments.empty()) turn_rims(up, least, margin, spots);
    std::erase_if(spots, [](const Spot& s) { return !std::isfinite(s.value); });
    for (Spot& s : spots) s.value = std::max(0.0, s.value);
    keep_distinct(spots);
    return spots;
}

Result<void> Position::second_contact() {
    std::optional<Vec3> n;
    if (pose_.P_kind == MultipointContact::interior) n = pose_.normal;
    near_.emplace(s_.fields[P_field_], pose_.P_uv.x(), pose_.P_uv.y(), n);

    // The other way first: its limit is only reported.
    const double limit = s_.options.max_tilt;
    pose_.tilt_minus = -limit;
    for (const Spot& s : turn_spots(false)) pose_.tilt_minus = std::max(pose_.tilt_minus, -s.value);
    pose_.tilt_minus = std::min(0.0, std::max(pose_.tilt_minus, -(kPi + std::atan2(insert_.Pw, insert_.Pv))));

    std::vector<Spot> spots = turn_spots(true);
    const double merged = merged_limit();
    for (int round = 0;; ++round) {
        double turn = std::min(limit, merged);
        if (!spots.empty()) turn = std::min(turn, spots.front().value);
        turn = std::max(0.0, turn);
        const Proof proof = prove_clear(s_.scene(), tool_, insert_.stand(tool_, turn), s_.options.certificate,
                                        s_.options.most_boxes, scratch_.stack);
        pose_.boxes += proof.boxes;
        pose_.tilt = pose_.tilt_plus = turn;
        if (proof.clear) {
            pose_.certified_gouge = proof.gouge;
            break;
        }
        Spot found;
        found.value = kInfinity;
        if (proof.gouged) {
            found = polish_turn(spot_of(*proof.gouged), true, 2.0 * s_.spacing);
            if (const auto rim = nearest_rim(*proof.gouged)) {
                const Spot at_rim = polish_turn_rim(*rim, true);
                if (at_rim.value < found.value) found = at_rim;
            }
        }
        if (round >= kMostRepairs || !(found.value < turn))
            return failed(
                "CertificateFailed", "stage 2",
                fmt::format("after {} boxes the tilt of {:.9g} deg is proved only to {:.3g} mm", pose_.boxes, degrees(turn),
                            proof.gouged ? tool_distance(tool_, insert_.stand(tool_, turn),
                                                         s_.fields[proof.gouged->field].at(proof.gouged->u, proof.gouged->v).S)
                                         : proof.left));
        found.value = std::max(0.0, found.value);
        spots.push_back(found);
        keep_distinct(spots);
    }

    pose_.gap_second = kInfinity;
    const double turn = pose_.tilt;
    if (!spots.empty() && spots.front().value <= turn) {
        const Spot& second = spots.front();
        if (!second.converged)
            return failed("CertificateFailed", "stage 2",
                          fmt::format("the tilt is not determined near {:.9g} deg", degrees(turn)));
        pose_.Q = second.S;
        pose_.Q_uv = {second.u, second.v};
        pose_.Q_kind = second.kind;
        if (spots.size() > 1) pose_.gap_second = spots[1].value - second.value;
        pose_.status = MultipointStatus::two_contacts;
        double spread = 0.0;
        std::size_t equal = 0;
        for (const Spot& s : spots)
            if (s.value <= second.value + kSameTurn) ++equal, spread = std::max(spread, (s.S - second.S).norm());
        if (equal >= 3 && spread > 0.5 * tool_.Ro) pose_.status = MultipointStatus::circle_contact;
        if ((pose_.Q - pose_.P).norm() < std::max(kMergedDistance, 1.01 * centre_of(s_.fields[P_field_])) &&
            pose_.status == MultipointStatus::two_contacts) {
            pose_.status = MultipointStatus::merged_contacts;
            pose_.Q_kind = MultipointContact::merged;
        }
    } else if (merged <= limit && turn == std::max(0.0, merged)) {
        pose_.status = MultipointStatus::merged_contacts;
        pose_.Q = pose_.P;
        pose_.Q_uv = pose_.P_uv;
        pose_.Q_kind = MultipointContact::merged;
        if (!spots.empty()) pose_.gap_second = spots.front().value - turn;
    } else {
        pose_.status = MultipointStatus::no_second_contact;
    }
    pose_.turn_to(turn, tool_.Ro, tool_.Ri);
    return {};
}

}  // namespace trunnion::detail
