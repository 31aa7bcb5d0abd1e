// One job under several orientation methods, side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"

namespace trunnion {

/// One method of a comparison. Figures are those of plan.json; NaN where there is no plan.
struct ComparedMethod {
    std::string name;   ///< as asked for
    std::string error;  ///< why there is no plan; empty where there is one
    bool valid = false;
    std::size_t poses = 0, invalid = 0;
    double turning_deg = 0.0;                              ///< Delta T over all cuts
    double rate_deg_per_mm = 0.0;                          ///< greatest |T'|
    double sharpness_greatest = 0.0, sharpness_rms = 0.0;  ///< of both rotary axes, deg per unit of xi squared
    double acceleration_deg_s2 = 0.0;                      ///< greatest of both rotary axes at the job's feed
    double time_s = 0.0;
    double strip_mm = 0.0;        ///< mean strip width
    double least_sine = 0.0;      ///< nearness to the machine's singularity
    std::string why;              ///< of the first pose that is not valid
    std::vector<double> s, rate;  ///< mm along the cuts and |T'| there, deg/mm, for the figure
};

struct Comparison {
    std::vector<ComparedMethod> methods;
    std::string table;  ///< for a terminal
    std::string json;   ///< one JSON object
    std::string svg;    ///< |T'| along the path, a lane for each method
};

/// Methods as `trunnion list methods` names them, rmf also as rmf-1, rmf-2, rmf-dual; keys may follow, as in
/// "rmf-dual?inclination_deg=auto;yaw_deg=auto" or "vector?axis=[0,0,1]". What is not said comes from the job where its method is
/// the same; sturz and rmf take the lean over from each other. Error: invalid_input for a method or key that is not known;
/// whatever the job itself meets; cancelled. A method that cannot do the job is a row that says why.
Result<Comparison> compare(const std::filesystem::path& job, const std::vector<std::string>& settings,
                           const std::vector<std::string>& methods, const Control& control);

/// "a,b?k=[1,2],c" -> three: commas inside brackets do not part.
std::vector<std::string> split_methods(const std::string& list);

}  // namespace trunnion
