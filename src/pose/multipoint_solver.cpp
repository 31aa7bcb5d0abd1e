#include "pose/multipoint_position.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace detail {

Result<MultipointPose> Position::drop(double x, double y, const Vec3& feed) {
    pose_.footprint = {x, y};
    if (!std::isfinite(x) || !std::isfinite(y))
        return fail(ErrorCode::invalid_input, fmt::format("NonFinite: footprint ({}, {}) is no point", x, y));
    o_ = x * s_.ex + y * s_.ey;
    if (auto done = first_contact(); !done) return fail_up(std::move(done));
    if (auto done = take_first(feed); !done) return fail_up(std::move(done));
    if (pose_.status == MultipointStatus::two_contacts)
        if (auto done = second_contact(); !done) return fail_up(std::move(done));
    if (!pose_.CL.allFinite() || !pose_.T.allFinite())
        return fail(ErrorCode::internal, fmt::format("NonFinite at footprint ({:.9g}, {:.9g}): the pose has no numbers", x, y));
    return pose_;
}

Result<MultipointPose> Position::at_contact(int face, const Vec2& uv, const Vec3& lean, double start) {
    const auto it = std::find_if(s_.fields.begin(), s_.fields.end(), [&](const Field& f) {
        return f.face() == face && f.u().contains(uv.x()) && f.v().contains(uv.y());
    });
    if (it == s_.fields.end())
        return fail(ErrorCode::invalid_input,
                    fmt::format("contact ({:.9g}, {:.9g}) is no point of face {} among the machined ones", uv.x(), uv.y(), face));
    P_field_ = static_cast<std::uint32_t>(it - s_.fields.begin());
    const auto n = it->surface().normal(uv.x(), uv.y());
    if (!n)
        return failed("DegenerateSurface", "contact",
                      fmt::format("the surface has no normal at ({:.9g}, {:.9g})", uv.x(), uv.y()));
    const Vec3 side = lean - lean.dot(*n) * *n;
    if (!(side.norm() > 1e-9))
        return fail(ErrorCode::invalid_input, "the direction in which the tool leans lies along the surface normal");
    const Vec3 m = side.normalized();
    pose_.P = it->at(uv.x(), uv.y()).S;
    pose_.normal = *n;
    pose_.P_uv = uv;
    pose_.P_face = face;
    pose_.P_kind = MultipointContact::interior;
    pose_.gap_first = kInfinity;
    pose_.k_min = pose_.k_max = kNaN;
    pose_.z_c = kNaN;
    pose_.Q = Vec3::Constant(kNaN);
    pose_.Q_uv = Vec2::Constant(kNaN);
    const double c = std::cos(start), s = std::sin(start);
    pose_.e_w = c * *n + s * m;
    pose_.e_v = s * *n - c * m;
    pose_.insert_centre = pose_.P + tool_.Ri * *n;
    pose_.footprint = {pose_.insert_centre.dot(s_.ex), pose_.insert_centre.dot(s_.ey)};
    insert_ = Insert::from(pose_.P, pose_.insert_centre, pose_.e_v, pose_.e_w);
    const Proof proof =
        prove_clear(s_.scene(), tool_, insert_.stand(tool_, 0.0), s_.options.certificate, s_.options.most_boxes, scratch_.stack);
    pose_.boxes += proof.boxes;
    if (!proof.clear)
        return failed(
            "GougeAtStart", "contact",
            fmt::format("already at {:.6g} deg from the normal the cutter gouges; start nearer the normal or lean another way",
                        degrees(start)));
    if (auto done = second_contact(); !done) return fail_up(std::move(done));
    return pose_;
}

}  // namespace detail

using namespace detail;

namespace {

Scratch& scratch() {
    thread_local Scratch mine;
    return mine;
}

}  // namespace

void MultipointPose::turn_to(double angle, double R_major, double R_minor) {
    const double c = std::cos(angle), s = std::sin(angle);
    tilt = angle;
    T = (c * e_w + s * e_v).normalized();
    CL = insert_centre + R_major * (c * e_v - s * e_w) - R_minor * T;
}

void MultipointSolver::Impl::prepare() {
    std::vector<Box3> boxes;
    for (std::size_t f = 0; f < fields.size(); ++f) fields[f].append_tiles(static_cast<std::uint32_t>(f), tiles);
    for (const Tile& t : tiles) {
        Box3 box;
        for (int k = 0; k < Tile::kSize; ++k) {
            const auto at = static_cast<std::size_t>(k);
            if (t.x[at] < Tile::kFar) box.add(Vec3(t.x[at], t.y[at], t.z[at]));
        }
        boxes.push_back(box);
    }
    tile_tree = BoxTree(boxes, 1);
    boxes.clear();
    for (std::size_t f = 0; f < fields.size(); ++f)
        for (std::size_t s = 0; s < fields[f].spans(); ++s) {
            roots.push_back({static_cast<std::uint32_t>(f), static_cast<std::uint32_t>(s), 0.0, 0.0, 1.0, 0});
            boxes.push_back(fields[f].span_box(s));
            whole.add(boxes.back());
        }
    span_tree = BoxTree(boxes, 1);
    for (std::size_t f = 0; f < fields.size(); ++f) rims.add(fields[f], static_cast<std::uint32_t>(f), spacing);
    rims.build();
}

double MultipointSolver::Impl::lowest(const Vec3& o) const {
    return (whole.centre() - o).dot(ez) - ez.cwiseAbs().dot(whole.half()) - 2.0 * (tool.Ro + tool.Ri);
}

Result<MultipointPose> MultipointSolver::drop(double x, double y, const Vec3& feed) const {
    return Position(*impl_, scratch()).drop(x, y, feed);
}

Result<MultipointPose> MultipointSolver::at_contact(int face, const Vec2& uv, const Vec3& lean, double start) const {
    return Position(*impl_, scratch()).at_contact(face, uv, lean, start);
}

std::optional<double> MultipointSolver::certify(const Vec3& tip, const Vec3& axis, double eps) const {
    const Proof proof = prove_clear(impl_->scene(), impl_->tool, {tip + impl_->tool.Ri * axis, axis}, eps,
                                    impl_->options.most_boxes, scratch().stack);
    return proof.clear ? std::optional<double>(proof.gouge) : std::nullopt;
}

Result<std::vector<Result<MultipointPose>>> MultipointSolver::drop_all(std::span<const Vec2> footprints,
                                                                       std::span<const Vec3> feeds,
                                                                       const Control& control) const {
    TRUNNION_REQUIRE(feeds.empty() || feeds.size() == footprints.size());
    std::vector<Result<MultipointPose>> poses(footprints.size(), fail(ErrorCode::internal, "not computed"));
    constexpr std::size_t kGrain = 16;
    auto done =
        parallel_for(footprints.size(), kGrain, control, "two-point positioning", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                poses[i] = drop(footprints[i].x(), footprints[i].y(), feeds.empty() ? Vec3(Vec3::Zero()) : feeds[i]);
        });
    if (!done) return fail_up(std::move(done));
    return poses;
}

}  // namespace trunnion
