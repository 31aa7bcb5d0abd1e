// Stage 1: vertical rays, from seeds to a proved drop.
#include "pose/multipoint_position.hpp"

namespace trunnion::detail {

std::optional<RimPlace> Position::nearest_rim(const Seed& seed) const {
    const Field& field = s_.fields[seed.field];
    const Vec2 at(seed.u, seed.v), scale = scale_of(field.at(seed.u, seed.v));
    std::optional<RimPlace> nearest;
    double least = kInfinity;
    for (std::uint32_t k = 0; k < s_.rims.segments.size(); ++k) {
        const RimSegment& s = s_.rims.segments[k];
        if (s.field != seed.field) continue;
        const Vec2 d = (s.to - s.from).cwiseProduct(scale), p = (at - s.from).cwiseProduct(scale);
        const double t = std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 1.0), distance = (p - t * d).squaredNorm();
        if (distance < least) least = distance, nearest = RimPlace{k, t};
    }
    return nearest;
}

std::optional<Jet> Position::depth(const Field& field, double u, double v) {
    SurfacePoint p = field.at(u, v);
    p.S -= o_;
    const auto height = touch_height(tool_, s_.ex, s_.ey, s_.ez, p);
    if (!height) return std::nullopt;
    return -*height;
}

Spot Position::polish_drop(const Spot& seed) {
    const Field& field = s_.fields[seed.field];
    const auto f = [&](double u, double v) { return depth(field, u, v); };
    const double reach = 0.25 * (tool_.Ro + tool_.Ri);
    const Vec3 S = field.at(seed.u, seed.v).S;
    Minimum m = polish(f, field, seed.u, seed.v, o_ + (S - o_).dot(s_.ez) * s_.ez, reach);
    pose_.newton_steps += m.evaluations;
    if (!tool_.open && m.defined) {
        // Under the disc the height is that of the surface, with no curvature of the tool's: on nearly flat ground Newton stops
        // short of the rim, just beyond which the top lies. It starts there again, uphill from where it stopped.
        const SurfacePoint p = field.at(m.a, m.b);
        const Vec3 X = p.S - o_;
        const Vec2 x(X.dot(s_.ex), X.dot(s_.ey));
        const Vec2 scale = scale_of(p), g(-m.jet.a / scale.x(), -m.jet.b / scale.y());
        if (x.norm() < tool_.Ro && g.norm() > 0.0 && !(m.held_a && m.held_b)) {
            const Vec2 up = g.normalized();
            const Vec3 step = up.x() * p.Su / scale.x() + up.y() * p.Sv / scale.y();
            const Vec2 d(step.dot(s_.ex), step.dot(s_.ey));
            const double radius = tool_.Ro + tool_.Ri * std::min(0.5, g.norm()), along = x.dot(d), dd = d.squaredNorm();
            const double t = (-along + std::sqrt(along * along + dd * (radius * radius - x.squaredNorm()))) / dd;
            const Minimum again =
                minimise(f, m.a + t * up.x() / scale.x(), m.b + t * up.y() / scale.y(), {field.u(), field.v()}, scale, reach);
            pose_.newton_steps += again.evaluations;
            if (again.defined && again.jet.f < m.jet.f) m = again;
        }
    }
    Spot spot{seed.field, m.a, m.b, m.jet.f, field.at(m.a, m.b).S, m.jet, kind_at(field, m), settled(m)};
    if (!m.defined || !field.inside(m.a, m.b)) spot.value = kInfinity;
    return spot;
}

Spot Position::polish_drop_rim(const RimPlace& start) {
    const Field& field = s_.fields[s_.rims.segments[start.segment].field];
    return polish_rim([&](double u, double v) { return depth(field, u, v); }, start);
}

/// Tops along trimmed borders.
void Position::drop_rims(double best, double margin) {
    const double reach = tool_.Ro + tool_.Ri;
    const auto height = [&](std::uint32_t k) {
        SurfacePoint p{};
        p.S = s_.rims.segments[k].start - o_;
        p.Su = p.Sv = p.Suu = p.Suv = p.Svv = Vec3::Zero();
        const auto h = touch_height(tool_, s_.ex, s_.ey, s_.ez, p);
        return h ? h->f : -kInfinity;
    };
    s_.rims.tree.visit(
        [&](const BoxNode& node) {
            const Vec3 p = node.centre - o_;
            const double gx = std::max(0.0, std::abs(p.dot(s_.ex)) - s_.ex.cwiseAbs().dot(node.half)),
                         gy = std::max(0.0, std::abs(p.dot(s_.ey)) - s_.ey.cwiseAbs().dot(node.half));
            return gx * gx + gy * gy <= reach * reach;
        },
        [&](std::uint32_t k) {
            const double h = height(k);
            if (!(h > best - margin)) return;
            if (h < height(s_.rims.segments[k].next) || h <= height(s_.rims.segments[k].previous)) return;
            const Spot spot = polish_drop_rim({k, 0.0});
            if (std::isfinite(spot.value)) peaks_.push_back(spot);
        });
}

void Position::drop_seeds() {
    scratch_.seeds.clear();
    const double reach = tool_.Ro + tool_.Ri;
    double best = -kInfinity;
    // A sample misses the top by half a cell at most: by the greatest curvature of the height, 1 / Ri, over a quarter of the
    // cell's diagonal squared; at the wall of the tool by more, but there another sample of the same top serves.
    const double margin = std::min(2.0 * s_.spacing, s_.spacing * s_.spacing / std::max(tool_.Ri, 0.1 * s_.spacing));
    Block heights;
    const Vec3 ax = s_.ex.cwiseAbs(), ay = s_.ey.cwiseAbs();
    s_.tile_tree.visit(
        [&](const BoxNode& node) {
            const Vec3 p = node.centre - o_;
            const double gx = std::max(0.0, std::abs(p.dot(s_.ex)) - ax.dot(node.half)),
                         gy = std::max(0.0, std::abs(p.dot(s_.ey)) - ay.dot(node.half));
            return gx * gx + gy * gy <= reach * reach;
        },
        [&](std::uint32_t index) {
            const Tile& tile = s_.tiles[index];
            const Vec3 p = tile.centre - o_;
            if (p.dot(s_.ez) + tile.radius + tool_.Ri < best - margin) return;
            if (std::hypot(p.dot(s_.ex), p.dot(s_.ey)) > reach + tile.radius) return;
            scan_heights(tool_, tile, o_, s_.ex, s_.ey, s_.ez, heights);
            best = std::max(best, *std::max_element(heights.begin(), heights.end()));
            local_maxima(heights, best - margin, [&](int k) {
                const Field& field = s_.fields[tile.field];
                Spot seed;
                seed.field = tile.field;
                seed.u = field.lattice_u[static_cast<std::size_t>(tile.first_u + k / Tile::kSide - 1)];
                seed.v = field.lattice_v[static_cast<std::size_t>(tile.first_v + k % Tile::kSide - 1)];
                seed.value = -heights[static_cast<std::size_t>(k)];
                scratch_.seeds.push_back(seed);
            });
        });
    std::sort(scratch_.seeds.begin(), scratch_.seeds.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    if (scratch_.seeds.size() > kMostSeeds) scratch_.seeds.resize(kMostSeeds);
}

Result<void> Position::first_contact() {
    drop_seeds();
    peaks_.clear();
    for (std::size_t k = 0; k < scratch_.seeds.size(); ++k) {
        const Spot spot = polish_drop(scratch_.seeds[k]);
        if (std::isfinite(spot.value)) peaks_.push_back(spot);
    }
    if (!s_.rims.segments.empty()) {
        double best = -kInfinity;
        for (const Spot& p : peaks_) best = std::max(best, -p.value);
        drop_rims(best, s_.spacing);
    }
    // Proof, and repair where it finds the tool too deep. Without one sample under the tool it starts far below everything, where
    // whatever lies under the tool is found as a gouge.
    double height = -kInfinity;
    for (const Spot& p : peaks_) height = std::max(height, -p.value);
    for (int round = 0;; ++round) {
        ToolShape tool = tool_;
        ToolStand stand{o_ + height * s_.ez, s_.ez};
        if (!std::isfinite(height)) {
            stand.C = o_ + s_.lowest(o_) * s_.ez;
            tool.top = kInfinity;
        }
        const Proof proof = prove_clear(s_.scene(), tool, stand, s_.options.certificate, s_.options.most_boxes, scratch_.stack);
        pose_.boxes += proof.boxes;
        if (proof.clear) {
            if (!std::isfinite(height))
                return failed("NoSurfaceUnderTool", "stage 1",
                              "no machined surface lies under the cutter; leave this footprint out, or name the face under it in "
                              "part.faces");
            pose_.certified_gouge = proof.gouge;
            break;
        }
        Spot found;
        found.value = kInfinity;
        if (proof.gouged) {
            found = polish_drop(spot_of(*proof.gouged));
            if (const auto rim = nearest_rim(*proof.gouged)) {
                const Spot at_rim = polish_drop_rim(*rim);
                if (at_rim.value < found.value) found = at_rim;
            }
        }
        if (!proof.gouged || round >= kMostRepairs || !(-found.value > height))
            return failed("CertificateFailed", "stage 1",
                          fmt::format("after {} boxes the drop at height {:.9g} mm is proved only to {:.3g} mm", pose_.boxes,
                                      height, proof.gouged ? height + found.value : proof.left));
        peaks_.push_back(found);
        height = -found.value;
    }
    keep_distinct(peaks_);
    if (!peaks_.front().converged)
        return failed("CertificateFailed", "stage 1",
                      "the first contact is not determined: the surface is level to rounding along a ring");
    return {};
}

Result<void> Position::take_first(const Vec3& feed) {
    // Equal heights: the one whose e_v is most across the feed, then the smaller angle.
    std::size_t equal = 1;
    while (equal < peaks_.size() && peaks_[equal].value <= peaks_.front().value + kSameHeight) ++equal;
    const auto flat = [&](const Spot& p) { return Vec3(p.S - o_ - (p.S - o_).dot(s_.ez) * s_.ez); };
    if (equal > 1) {
        const auto rank = [&](const Spot& p) {
            const Vec3 r = flat(p);
            const double along_feed = r.norm() > 0.0 ? std::abs(r.normalized().dot(feed)) : 2.0;
            // Rounding must not decide: a millionth of a degree apart counts as equal.
            return std::pair(std::round(along_feed * 1e8), std::atan2(r.dot(s_.ey), r.dot(s_.ex)));
        };
        std::sort(peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(equal),
                  [&](const Spot& a, const Spot& b) { return rank(a) < rank(b); });
        pose_.ambiguous = true;
    }
    const Spot& first = peaks_.front();
    const Field& field = s_.fields[first.field];
    const Vec3 r = flat(first);
    const double rho = r.norm();
    pose_.z_c = -first.value + o_.dot(s_.ez);
    pose_.P = first.S;
    pose_.P_uv = {first.u, first.v};
    pose_.P_face = field.face();
    pose_.P_kind = first.kind;
    pose_.gap_first = kInfinity;
    for (std::size_t k = equal; k < peaks_.size(); ++k)
        pose_.gap_first = std::min(pose_.gap_first, peaks_[k].value - first.value);
    if (equal > 1) pose_.gap_first = 0.0;
    P_field_ = first.field;

    // Curvatures of the height in a tangent basis.
    pose_.k_min = pose_.k_max = kNaN;
    const SurfacePoint p = field.at(first.u, first.v);
    if (first.kind == MultipointContact::interior) {
        Eigen::Matrix2d G, H;
        G << p.Su.dot(p.Su), p.Su.dot(p.Sv), p.Su.dot(p.Sv), p.Sv.dot(p.Sv);
        H << first.jet.aa, first.jet.ab, first.jet.ab, first.jet.bb;
        const Eigen::Matrix2d inverse = G.llt().matrixL().toDenseMatrix().inverse(), k = inverse * H * inverse.transpose();
        const double half = 0.5 * (k(0, 0) + k(1, 1)), spread = std::hypot(0.5 * (k(0, 0) - k(1, 1)), 0.5 * (k(0, 1) + k(1, 0)));
        pose_.k_min = half - spread;
        pose_.k_max = half + spread;
    }
    const Vec3 C = o_ + -first.value * s_.ez;
    pose_.T = s_.ez;
    pose_.CL = C - tool_.Ri * s_.ez;
    pose_.e_w = s_.ez;
    pose_.Q = Vec3::Constant(kNaN);
    pose_.Q_uv = Vec2::Constant(kNaN);

    const bool on_disc = !tool_.open && rho < tool_.Ro;
    constexpr double kOnAxis = 1e-9;  // mm: nearer the axis its direction is rounding
    const bool on_axis = rho < kOnAxis;
    const Vec3 out = on_axis ? s_.ex : Vec3(r / rho);
    pose_.e_v = -out;
    pose_.insert_centre = C + (on_disc ? rho : tool_.Ro) * out;
    pose_.normal = tool_.Ri > 0.0 ? Vec3((pose_.insert_centre - pose_.P) / tool_.Ri) : s_.ez;
    if (first.kind == MultipointContact::interior) {
        // The contact's normal is the surface's, to rounding; the surface's is the better known of the two.
        const auto n = field.surface().normal(first.u, first.v);
        if (n) pose_.normal = n->dot(pose_.normal) < 0.0 ? Vec3(-*n) : *n;
    }
    pose_.normal.normalize();
    insert_ = Insert::from(pose_.P, pose_.insert_centre, pose_.e_v, pose_.e_w);
    if (tool_.Ro == 0.0) {
        pose_.status = MultipointStatus::ball_has_no_tilt;
        pose_.tilt_minus = -s_.options.max_tilt;
        pose_.tilt_plus = s_.options.max_tilt;
    } else if (equal >= 3) {
        pose_.status = MultipointStatus::circle_contact;
    } else if (equal == 2) {
        pose_.status = MultipointStatus::ambiguous_first_contact;
        pose_.Q = peaks_[1].S;
        pose_.Q_uv = {peaks_[1].u, peaks_[1].v};
        pose_.Q_kind = peaks_[1].kind;
    } else if (on_axis) {
        pose_.status = MultipointStatus::first_contact_on_axis;
    } else if (on_disc) {
        // A whole flat under the disc has no curvature anywhere.
        constexpr double kFlat = 1e-12;  // 1/mm
        pose_.status = std::abs(pose_.k_max) < kFlat ? MultipointStatus::circle_contact : MultipointStatus::disc_contact;
        pose_.P_kind = pose_.P_kind == MultipointContact::interior ? MultipointContact::disc : pose_.P_kind;
    } else {
        pose_.status = MultipointStatus::two_contacts;
    }
    return {};
}

}  // namespace trunnion::detail
