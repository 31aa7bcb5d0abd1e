// NC programs and CLDATA: writers, and readers that prove what was written.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trunnion/machine/machine_path.hpp"
#include "trunnion/program/dialect.hpp"

namespace trunnion {

struct ProgramOptions {
    std::string dialect = "linuxcnc";  ///< see dialect_names(); or the path of a dialect file of your own, ending in .toml
    bool tcp = true;                   ///< tool-centre-point control; false: joint positions with inverse-time feed
    bool plane = false;                ///< one tilted plane (3+2) instead: all poses must have the same axis
    bool allow_invalid = false;        ///< post invalid poses too, each block marked with a comment
    std::string title{};               ///< first comment, made safe for the control
    int tool_number = 1;
    double tool_diameter = 0.0;  ///< mm, for the header and CLDATA's CUTTER
    double tool_corner = 0.0;    ///< mm
    double spindle_rpm = 0.0;    ///< 0 = none written
    double blend = 0.001;        ///< mm, how far the control may round a corner (G64 P); 0 = exact path (G61)
};

/// The built-in dialects: "apt", "fanuc", "fanuc-vector", "heidenhain", ...
std::vector<std::string> dialect_names();
/// "cls", "nc", "h", "mpf", "ngc"; "txt" for an unknown dialect.
std::string file_ending(std::string_view dialect);
/// A built-in dialect by name, or a dialect file. Error: invalid_input with the nearest name, or the file's mistake; not_found.
Result<Dialect> find_dialect(std::string_view name_or_file);

/// Text of the program, from the description of the dialect (docs/dialects.md).
/// A program under tool-centre-point control holds tips in the WCS (G54) with rotary words or tool axes, one without it machine
/// positions (G54 must be zero) and G93; a plane program holds tips in the coordinates of the tilted plane. Rapid links are
/// G0 where the control moves straight on rapids, else G1 at the rapid speed.
/// Error: invalid_input if the path has invalid poses and allow_invalid is false (says how many and the first), if the
/// dialect is unknown or cannot do what is asked, if TCP is asked of a machine without it, or if the tool axis of a plane
/// program is not the same everywhere (says which pose).
Result<std::string> write_program(const MachinePath& path, const ProgramOptions& options);

/// How the control goes from block to block.
enum class Interpolation {
    all_axes,     ///< all five axes run evenly
    rotary_axes,  ///< the tip on a straight line, the rotary axes evenly
    great_circle  ///< the tip on a straight line, the tool axis on a great circle
};

/// One motion block of a program read back.
struct ProgramBlock {
    int line = 0;  ///< 1-based line of the file
    bool rapid = false;
    TipPose tip{};           ///< WCS, through the forward kinematics where the program holds axis words
    JointPosition joints{};  ///< axis positions (rad for rotary) where the dialect has rotary words
    bool has_joints = false;
    double feed = 0.0;     ///< mm/s of the tip; 0 on rapids and where the tip rests
    double seconds = 0.0;  ///< duration where the block itself states it: G93, or rotary axes alone in G94
};

struct ProgramText {
    std::string dialect{};  ///< as asked for; of a guess, the plainest dialect of the family
    bool tcp = true;        ///< tips stand in the program, not machine positions
    Interpolation interpolation = Interpolation::great_circle;
    std::vector<ProgramBlock> blocks{};
};

/// Reads a program of the dialect ("" = guess from the content). Machine and tool length are needed for axis words.
/// "linuxcnc": tool-centre-point control if the tool length is switched on (G43) before the first complete position, else
/// machine positions. Moves before all five axes have been named (approach, retract in G53) are no blocks.
/// "apt": one block per GOTO; millimetres unless UNITS/INCHES. "fanuc", "makino", "mitsubishi": G43.4, G43.5, G68.2.
/// "siemens": TRAORI with ORIAXES or ORIVECT, CYCLE800. "heidenhain", "mikron": TCPM, M128, LN, PLANE SPATIAL. What would move
/// the tool in a way that is not read (arcs, cycles, transformations, offsets, variables) is refused, not skipped.
/// Error: unreadable with the line: unknown word or code, number that cannot be read, missing end, truncated file.
Result<ProgramText> read_program(std::string_view text, std::string_view dialect, const Machine* machine, double tool_length);

/// Greatest differences between a program read back and the path it was written from.
struct ReadBack {
    double tip = 0.0;                                 ///< mm
    double axis = 0.0;                                ///< rad
    double joints_linear = 0.0, joints_rotary = 0.0;  ///< mm, rad; 0 where the dialect holds none
    double motion_tip = 0.0, motion_axis = 0.0;       ///< mm, rad: off the checked motion in the middle of a motion
    std::size_t blocks = 0;
};
/// Invalid poses that were posted all the same are compared by their joints alone. Where tips stand in the program, the
/// linear joints follow from tip and rotary words and are measured, not judged. Half way along each motion the tool is put where
/// the control's own interpolation has it, and must be inside what was checked. Error: unreadable if the number of blocks differs
/// or a difference exceeds 1e-4 mm or 1e-4 deg: says which block.
Result<ReadBack> compare_with_path(const ProgramText& program, const MachinePath& path);

}  // namespace trunnion
