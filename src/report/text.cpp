#include "report/text.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace trunnion::report {

namespace {

/// Length of the well-formed UTF-8 sequence at the start of `bytes` (Unicode, table 3-7), 0 if there is none.
std::size_t sequence_length(std::string_view bytes) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    const unsigned char first = byte(0);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xC2 && first <= 0xDF   ? 2
                               : first >= 0xE0 && first <= 0xEF ? 3
                               : first >= 0xF0 && first <= 0xF4 ? 4
                                                                : 0;
    if (length == 0 || bytes.size() < length) return 0;
    // The second byte's range excludes overlong forms, surrogates and what lies beyond U+10FFFF.
    const unsigned char low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
    const unsigned char high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
    if (byte(1) < low || byte(1) > high) return 0;
    for (std::size_t i = 2; i < length; ++i)
        if ((byte(i) & 0xC0) != 0x80) return 0;
    return length;
}

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

}  // namespace

std::string valid_utf8(std::string_view bytes) {
    std::string text;
    text.reserve(bytes.size());
    while (!bytes.empty()) {
        const std::size_t length = sequence_length(bytes);
        text += length > 0 ? bytes.substr(0, length) : kReplacement;
        bytes.remove_prefix(length > 0 ? length : 1);
    }
    return text;
}

std::string json_string(std::string_view text) {
    std::string json;
    json.reserve(text.size() + 2);
    json += '"';
    for (std::size_t i = 0; i < text.size();) {
        const char c = text[i];
        const std::size_t length = sequence_length(text.substr(i));
        if (c == '"' || c == '\\') {
            json += '\\';
            json += c;
        } else if (c == '\n') {
            json += "\\n";
        } else if (c == '\t') {
            json += "\\t";
        } else if (static_cast<unsigned char>(c) < 0x20) {
            json += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        } else if (length == 0) {
            json += kReplacement;
        } else {
            json += text.substr(i, length);
        }
        i += length > 0 ? length : 1;
    }
    json += '"';
    return json;
}

NumberText json_number(double x) {
    NumberText text{};
    const auto say = [&](std::string_view word) {
        std::memcpy(text.data, word.data(), word.size());
        text.size = word.size();
        return text;
    };
    if (std::isnan(x)) return say("null");
    if (std::isinf(x)) return say(x > 0 ? "\"inf\"" : "\"-inf\"");
    if (x == 0 && std::signbit(x)) return say("-0.0");  // "-0" is an integer to many readers, and loses its sign
    const auto end = std::to_chars(text.data, text.data + sizeof text.data, x).ptr;
    text.size = static_cast<std::size_t>(end - text.data);
    return text;
}

std::string json_for_html(std::string_view json) {
    std::string text;
    text.reserve(json.size());
    for (const char c : json) {
        if (c == '<')
            text += "\\u003c";  // '<' stands only inside JSON strings, where this means the same
        else
            text += c;
    }
    return text;
}

std::string html_text(std::string_view raw) {
    std::string text;
    for (const char c : valid_utf8(raw)) {
        switch (c) {
            case '&':
                text += "&amp;";
                break;
            case '<':
                text += "&lt;";
                break;
            case '>':
                text += "&gt;";
                break;
            case '"':
                text += "&quot;";
                break;
            case '\'':
                text += "&#39;";
                break;
            // HTML forbids the other control characters, as themselves and as references.
            default:
                text += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? std::string(kReplacement)
                                                                                       : std::string(1, c);
        }
    }
    return text;
}

std::string base64(std::span<const std::byte> bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text((bytes.size() + 2) / 3 * 4, '=');
    char* out = text.data();
    for (std::size_t i = 0; i < bytes.size(); i += 3, out += 4) {
        const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k <= left; ++k) out[k] = kDigits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

}  // namespace trunnion::report
