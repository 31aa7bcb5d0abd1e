// Rotational cutters with shank and holder, and where they touch: closed-form contact geometry.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trunnion/cutter/profile.hpp"

namespace trunnion {

enum class CutterShape { ball, flat, bull, taper, barrel, lens, tangential, conical, apt };
std::string_view name_of(CutterShape shape);
std::vector<std::string_view> cutter_shape_names();
Result<CutterShape> cutter_shape(std::string_view name);

/// How a user describes a cutter. Lengths mm, angles rad; 0 = not given.
struct CutterSpec {
    CutterShape shape = CutterShape::ball;
    double diameter = 0.0;
    double corner_radius = 0.0;  ///< bull, taper, barrels: corner or tip radius; apt: r
    double flute = 0.0;          ///< cutting height; 0: 1.5 diameters, or what the shape needs. tangential: derived
    double half_angle = 0.0;     ///< taper: half cone angle
    double barrel_radius = 0.0;  ///< barrel, lens, tangential, conical: the large radius
    double apt_e = -1.0, apt_f = -1.0, apt_alpha = 0.0, apt_beta = 0.0;  ///< apt: e, f (negative: derived), alpha, beta
    bool open_bottom = false;                                            ///< insert cutter with a hollow centre (bull only)
    struct Cone {
        double bottom = 0.0, top = 0.0, length = 0.0;  ///< diameters and length
    };
    std::vector<Cone> shank;   ///< 0 or 1 (a cylinder has bottom == top)
    std::vector<Cone> holder;  ///< stacked upwards
};

enum class PieceKind { cutter, shank, holder };

struct ToolPiece {
    PieceKind kind = PieceKind::cutter;
    std::string name;  ///< "cutter", "shank", "holder 1", ...
    Profile profile;
};

/// Where a cutter touches, in its own half-plane.
struct ToolContact {
    double radius = 0.0, height = 0.0;
};

/// The whole tool. Immutable.
class Cutter {
public:
    /// Error: invalid_input naming the value at fault: corner radius above half the diameter, shapes that do not close...
    static Result<Cutter> from(const CutterSpec& spec);

    const CutterSpec& spec() const { return spec_; }
    const std::vector<ToolPiece>& pieces() const { return pieces_; }
    double length() const { return length_; }                 ///< tip to the top of the last piece: the gauge length
    double tip_corner_radius() const { return tip_corner_; }  ///< R_minor of the tip's torus; 0 for a sharp edge
    double tip_major_radius() const { return tip_major_; }    ///< R_major of the tip's torus

    /// Contact of the cutting part for an angle alpha in [0, pi] between axis and outward surface normal.
    /// alpha = 0: the tip for a closed bottom (the disc touches; its centre is taken). On a flat flank: its lowest point.
    /// `inner`: on the inner half of an open torus. Error: no_solution where no point of the cutting profile has that
    /// normal, or where an open bottom stands square on the surface (its whole ring touches; no point of it is the contact).
    Result<ToolContact> contact(double alpha, bool inner = false) const;

    /// Principal curvatures (1/mm, positive) of the tool surface at that contact: along the meridian and along the
    /// parallel. Infinite across a sharp edge.
    struct Curvature {
        double meridian = 0.0, parallel = 0.0;
    };
    Result<Curvature> curvature(double alpha) const;

private:
    Cutter() = default;
    CutterSpec spec_;
    std::vector<ToolPiece> pieces_;
    double length_ = 0.0, tip_corner_ = 0.0, tip_major_ = 0.0;
};

/// Below this sine of the angle between axis and normal the direction of the contact from the axis is lost to rounding
/// (off by ulp / sine); the tool then stands on its bottom disc and the contact is taken at the tip.
inline constexpr double kParallelSine = 1e-9;

/// Tool tip for a contact. Source: conventions sheet, "Cutter", generalised: CL = CC + rho p - h T with (rho, h) the profile
/// point whose outward normal is -n; on a torus this is CC + r n + R_major p - r T.
Result<Vec3> tool_tip(const Cutter& cutter, const Vec3& cc, const Vec3& normal, const Vec3& axis, bool inner = false);

}  // namespace trunnion
