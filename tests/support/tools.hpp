// Cutter descriptions for tests: one of every shape, and random valid ones of any size.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "support/aimed_random.hpp"
#include "trunnion/cutter/cutter.hpp"

namespace trunnion {

/// One valid cutter of every shape, all lengths times `scale`.
inline std::vector<std::pair<std::string, CutterSpec>> one_of_every_shape(double scale = 1.0) {
    const auto spec = [&](CutterShape shape, double diameter, double corner) {
        CutterSpec s;
        s.shape = shape;
        s.diameter = scale * diameter;
        s.corner_radius = scale * corner;
        return s;
    };
    std::vector<std::pair<std::string, CutterSpec>> all;
    all.emplace_back("ball", spec(CutterShape::ball, 10, 0));
    all.emplace_back("flat", spec(CutterShape::flat, 12, 0));
    all.emplace_back("bull", spec(CutterShape::bull, 25.4, 6));
    CutterSpec open = spec(CutterShape::bull, 25.4, 4);
    open.open_bottom = true;
    all.emplace_back("open bull", open);
    CutterSpec taper = spec(CutterShape::taper, 6, 1.5);
    taper.half_angle = radians(7);
    all.emplace_back("taper", taper);
    taper.corner_radius = scale * 3.0;
    all.emplace_back("taper ball", taper);
    taper.corner_radius = 0.0;
    all.emplace_back("taper flat", taper);
    CutterSpec barrel = spec(CutterShape::barrel, 16, 2);
    barrel.barrel_radius = scale * 40;
    barrel.flute = scale * 20;
    all.emplace_back("barrel", barrel);
    barrel.corner_radius = 0.0;
    all.emplace_back("barrel sharp", barrel);
    CutterSpec lens = spec(CutterShape::lens, 16, 1);
    lens.barrel_radius = scale * 30;
    all.emplace_back("lens", lens);
    lens.corner_radius = 0.0;
    all.emplace_back("lens sharp", lens);
    CutterSpec tangential = spec(CutterShape::tangential, 12, 2);
    tangential.barrel_radius = scale * 85;
    all.emplace_back("tangential", tangential);
    CutterSpec conical = spec(CutterShape::conical, 12, 2);
    conical.barrel_radius = scale * 250;
    conical.flute = scale * 18;
    all.emplace_back("conical", conical);
    CutterSpec apt = spec(CutterShape::apt, 20, 3);
    apt.apt_alpha = radians(12);
    apt.apt_beta = radians(4);
    apt.flute = scale * 30;
    all.emplace_back("apt drill point", apt);
    apt.apt_alpha = 0.0;
    apt.apt_beta = radians(-3);
    all.emplace_back("apt back taper", apt);
    return all;
}

inline Cutter make_cutter(const CutterSpec& spec) {
    auto cutter = Cutter::from(spec);
    if (!cutter) throw std::logic_error("test cutter: " + cutter.error().text());
    return *cutter;
}

/// The description with every default filled in, as the cutter understood it: what a twin needs.
inline CutterSpec filled_in(const CutterSpec& spec) {
    return make_cutter(spec).spec();
}

inline CutterSpec ball_spec(double diameter) {
    CutterSpec s;
    s.shape = CutterShape::ball;
    s.diameter = diameter;
    return s;
}
inline CutterSpec flat_spec(double diameter) {
    CutterSpec s = ball_spec(diameter);
    s.shape = CutterShape::flat;
    return s;
}
inline CutterSpec bull_spec(double diameter, double corner, bool open = false) {
    CutterSpec s = ball_spec(diameter);
    s.shape = CutterShape::bull;
    s.corner_radius = corner;
    s.open_bottom = open;
    return s;
}

/// A random valid cutter: any of the shapes above, any size, proportions changed where that keeps it valid.
inline CutterSpec random_spec(AimedRandom& random, double smallest = 1e-3, double largest = 1e4) {
    auto all = one_of_every_shape(random.log_uniform(smallest, largest));
    CutterSpec s = all[static_cast<std::size_t>(random.integer(0, static_cast<int>(all.size()) - 1))].second;
    if (s.shape == CutterShape::bull)
        s.corner_radius = 0.5 * s.diameter * (s.open_bottom ? random.uniform(0.05, 0.45) : random.uniform(0.0, 1.0));
    if (s.shape == CutterShape::taper) s.half_angle = random.uniform(0.0, radians(60));
    if (s.shape == CutterShape::lens) s.barrel_radius *= random.log_uniform(0.5, 50.0);
    return s;
}

}  // namespace trunnion
