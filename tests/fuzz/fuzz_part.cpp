// libFuzzer entry: the STL and OBJ readers must end in a part or an error for any bytes.
#include <cstdint>
#include <string_view>

#include "part/mesh_readers.hpp"
#include "part/mesh_tools.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view content(reinterpret_cast<const char*>(data), size);
    for (auto part : {trunnion::detail::read_stl(content), trunnion::detail::read_obj(content)}) {
        if (part)
            trunnion::detail::describe(*part, 0.01);
        else if (part.error().message.empty())
            __builtin_trap();
    }
    return 0;
}
