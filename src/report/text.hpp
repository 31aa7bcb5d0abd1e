// Text made safe for where it goes: JSON, HTML, base64.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion::report {

/// The same text where it is UTF-8; every byte that belongs to no well-formed sequence becomes U+FFFD.
std::string valid_utf8(std::string_view bytes);

/// A JSON string with its quotes, valid UTF-8 for any input bytes.
std::string json_string(std::string_view text);

/// Shortest decimal text that reads back to the same double, "null" for NaN, "\"inf\"" and "\"-inf\"" for the
/// infinities (JSON has no number for them). Returned in a fixed buffer: this runs tens of millions of times per file.
struct NumberText {
    char data[32];
    std::size_t size;
    operator std::string_view() const { return {data, size}; }
};
NumberText json_number(double x);

/// JSON that may stand inside <script type="application/json">: no '<' is left that could end the element.
std::string json_for_html(std::string_view json);

/// Text for element content and quoted attributes.
std::string html_text(std::string_view text);

std::string base64(std::span<const std::byte> bytes);
template <class T>
std::string base64_of(const std::vector<T>& values) {
    return base64(std::as_bytes(std::span(values)));
}

}  // namespace trunnion::report
