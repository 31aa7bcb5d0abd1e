// Two-point positioning of a bull-nose cutter by vertical and circular rays: dropped along an axis until it touches, then turned
// about the tube through that contact until it touches again. Exact, with a proof.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {

/// How a position ended. The first eight are poses; the last four come as errors.
enum class MultipointStatus {
    two_contacts,
    merged_contacts,          ///< the second contact is the first one: the surfaces touch to second order, or T = n
    ambiguous_first_contact,  ///< two first contacts at one height: no tilt
    circle_contact,           ///< contact along a circle (plane, sphere): the second contact is one of many
    disc_contact,             ///< the bottom disc touches first: no tilt
    no_second_contact,        ///< the greatest tilt is reached with one contact
    ball_has_no_tilt,         ///< turning a ball about its contact changes nothing
    first_contact_on_axis,    ///< the contact lies under the axis: the tilt plane is free
};
/// "TwoContacts", "MergedContacts", ... as in plan.json.
std::string_view name_of(MultipointStatus status);

enum class MultipointContact { none, interior, edge, corner, disc, shank, merged, vertex, facet };
std::string_view name_of(MultipointContact kind);

struct MultipointOptions {
    Vec3 drop_axis = Vec3::UnitZ();    ///< T0, unit
    double max_tilt = radians(60.0);   ///< rad in (0, 90 deg]: limit of the tilt about the insert, either way
    double certificate = 1e-3;         ///< mm: proved depth of any gouge of the cutting part
    std::size_t most_boxes = 400'000;  ///< bounds per proof before it is given up
};

/// One position. Lengths mm, angles rad, WCS.
struct MultipointPose {
    MultipointStatus status = MultipointStatus::two_contacts;
    bool ambiguous = false;  ///< another first contact has the same height; the one whose tilt plane suits the feed was taken
    Vec2 footprint = Vec2::Zero();
    double z_c = 0.0;                               ///< height of the torus centre along T0 after the drop
    Vec3 P = Vec3::Zero(), normal = Vec3::UnitZ();  ///< first contact, and (O1 - P) / Ri there
    Vec2 P_uv = Vec2::Zero();
    int P_face = -1;
    MultipointContact P_kind = MultipointContact::none, Q_kind = MultipointContact::none;
    Vec3 Q = Vec3::Zero();  ///< second contact; NaN without one
    Vec2 Q_uv = Vec2::Zero();
    double tilt = 0.0;                         ///< taken, about the insert through P
    double tilt_minus = 0.0, tilt_plus = 0.0;  ///< every tilt between is clear (within the limits)
    Vec3 CL = Vec3::Zero(), T = Vec3::UnitZ();
    Vec3 insert_centre = Vec3::Zero(), e_v = Vec3::UnitX(), e_w = Vec3::UnitZ();  ///< O1 and the plane of the tilt (section 4)
    double k_min = 0.0, k_max = 0.0;           ///< 1/mm, of the drop height at P; NaN at an edge
    double gap_first = 0.0, gap_second = 0.0;  ///< mm and rad to the next best contact; infinity where there is none
    double certified_gouge = 0.0;              ///< mm, proved of the final pose
    std::size_t boxes = 0;
    int newton_steps = 0;

    double separation() const { return (Q - P).norm(); }
    /// The same contact with another tilt of [tilt_minus, tilt_plus]. Source: sheet, section 6.
    void turn_to(double tilt, double R_major, double R_minor);
};

/// Holds the surfaces prepared; immutable and thread-safe.
class MultipointSolver {
public:
    /// `faces` of `part` are what the cutter must touch and must not gouge. Error: invalid_input for a cutter that is no bull,
    /// ball or flat, for limits out of range, for no faces.
    static Result<MultipointSolver> build(const Part& part, const std::vector<int>& faces, const Cutter& cutter,
                                          const MultipointOptions& options);
    static Result<MultipointSolver> build(const Surface& surface, const Cutter& cutter, const MultipointOptions& options);

    /// Drops the cutter on the footprint (x, y), mm in the plane across the drop axis (its axes: x = any_perpendicular(T0), which
    /// is the WCS x for T0 = z, and y = T0 x x), and tilts it.
    /// `feed`: decides between equal first contacts; may be zero.
    /// Error: no_solution (NoSurfaceUnderTool, GougeAtStart, CertificateFailed), internal (NonFinite); all with x, y, stage and
    /// numbers. Accuracy: heights 1e-9 mm, tilts 1e-8 rad where the contact is well conditioned.
    /// Source: sheet multipoint-vcrf, sections 3 to 10; after Singh, Bedi, Mann, with the corrections listed there.
    Result<MultipointPose> drop(double x, double y, const Vec3& feed = Vec3::Zero()) const;

    /// No drop: the contact is given, and the plane of the tilt by the direction from the contact towards the tool axis across
    /// the normal (yaw). The tool starts at `start` (rad from the normal) and comes up until it touches again: the least safe
    /// inclination. Source: sheet, section 12. Error: as drop(), GougeAtStart if already the start gouges.
    Result<MultipointPose> at_contact(int face, const Vec2& uv, const Vec3& lean, double start = radians(60.0)) const;

    /// All footprints on all cores: the same bits for any number of threads. `feeds` may be empty.
    Result<std::vector<Result<MultipointPose>>> drop_all(std::span<const Vec2> footprints, std::span<const Vec3> feeds,
                                                         const Control& control) const;

    /// Signed distance of the cutting part at a pose to the faces is at least -depth: the proved depth, or empty if a point lies
    /// deeper than `eps`.
    std::optional<double> certify(const Vec3& tip, const Vec3& axis, double eps) const;

    double R_major() const;
    double R_minor() const;

    struct Impl;

private:
    explicit MultipointSolver(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    std::shared_ptr<const Impl> impl_;
};

}  // namespace trunnion
