// Numbers and comments as text, and back. No locale, no streams.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace trunnion::detail {

/// A number as it will be printed: value = digits / 10^decimals. Two words are the same word if these are equal.
struct Decimal {
    std::int64_t digits = 0;
    int decimals = 0;
    bool operator==(const Decimal&) const = default;
};

inline constexpr double kPowersOfTen[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};
/// Greatest value (mm, deg) a program may hold; with 10 decimals it still fits 64 bits.
inline constexpr double kGreatestWord = 1e8;

inline Decimal fixed(double value, int decimals) {
    return {std::llround(value * kPowersOfTen[decimals]), decimals};
}

/// At least `significant` digits, for values whose size is not known beforehand (feeds).
inline Decimal rounded(double value, int significant) {
    const int before_point = value > 0 ? static_cast<int>(std::floor(std::log10(value))) + 1 : 1;
    return fixed(value, std::min(12, std::max(0, significant - before_point)));
}

/// Without exponent and without trailing zeros: -0.5, 12, 12.25.
inline void append(std::string& out, Decimal number) {
    char buffer[40];
    std::uint64_t magnitude =
        number.digits < 0 ? 0 - static_cast<std::uint64_t>(number.digits) : static_cast<std::uint64_t>(number.digits);
    if (number.digits < 0) out += '-';
    int decimals = number.decimals;
    while (decimals > 0 && magnitude % 10 == 0) {
        magnitude /= 10;
        --decimals;
    }
    char* end = buffer + sizeof buffer;
    char* p = end;
    for (int k = 0; k < decimals; ++k) {
        *--p = static_cast<char>('0' + magnitude % 10);
        magnitude /= 10;
    }
    if (decimals > 0) *--p = '.';
    do {
        *--p = static_cast<char>('0' + magnitude % 10);
        magnitude /= 10;
    } while (magnitude > 0);
    out.append(p, end);
}
inline void append_word(std::string& out, char letter, Decimal number) {
    out += ' ';
    out += letter;
    append(out, number);
}

/// Reads a number at the beginning of `text` and takes it away. No "inf", "nan" or hexadecimal; exponents on request.
inline std::optional<double> take_number(std::string_view& text, bool exponent) {
    std::string_view rest = text;
    if (!rest.empty() && rest.front() == '+') rest.remove_prefix(1);
    const std::size_t digit = !rest.empty() && rest.front() == '-' && rest.size() == text.size() ? 1 : 0;
    if (rest.size() <= digit || !((rest[digit] >= '0' && rest[digit] <= '9') || rest[digit] == '.')) return {};
    double value = 0.0;
    const auto format = exponent ? std::chars_format::general : std::chars_format::fixed;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value, format);
    if (error != std::errc() || !std::isfinite(value)) return {};
    text = rest.substr(static_cast<std::size_t>(end - rest.data()));
    return value;
}

/// Printable ASCII only, without the characters that end or nest a comment in any dialect, cut to `longest`.
inline std::string comment_text(std::string_view text, std::size_t longest) {
    std::string safe;
    for (const char c : text.substr(0, longest)) {
        if (c == '(' || c == '[')
            safe += '<';
        else if (c == ')' || c == ']')
            safe += '>';
        else if (c < ' ' || c > '~' || c == ';' || c == '$' || c == '%' || c == '#')
            safe += ' ';
        else
            safe += c;
    }
    return safe;
}

inline std::string_view trimmed(std::string_view text) {
    const auto space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && space(text.front())) text.remove_prefix(1);
    while (!text.empty() && space(text.back())) text.remove_suffix(1);
    return text;
}

/// Takes the next line (without its end) off `text`.
inline std::string_view take_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return line;
}

inline char upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}
inline std::string upper(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = upper(c);
    return result;
}

}  // namespace trunnion::detail
