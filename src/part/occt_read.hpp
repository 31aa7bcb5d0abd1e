// The door to Open CASCADE: no type of it passes here.
#pragma once

#include <filesystem>

#include "trunnion/part/part.hpp"

namespace trunnion::detail {

enum class CadFormat { step, iges, brep };

/// Faces, trims and mesh of a CAD file; boxes, areas and mesh problems are filled by `describe` afterwards.
/// Error: unreadable, unsupported (tessellation only). No exception escapes.
Result<Part> read_cad(const std::filesystem::path& file, CadFormat format, const LoadOptions& options, const Control& control);

}  // namespace trunnion::detail
