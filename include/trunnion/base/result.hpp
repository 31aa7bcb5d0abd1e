// Errors as values: every foreseeable failure is a Result, with the place where it happened.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

namespace trunnion {

/// The reason of a failure; the command line derives its exit code from it.
enum class ErrorCode {
    invalid_input,  ///< a value the user gave is wrong
    not_found,      ///< a file or name does not exist
    unreadable,     ///< a file exists but its content cannot be used
    unsupported,    ///< understood, but this build cannot do it
    no_solution,    ///< the question is well posed and has no answer
    io,             ///< reading or writing failed (permissions, disc full)
    cancelled,      ///< the user interrupted
    internal,       ///< a bug
};

/// One sentence with the offending values and their units, and where it happened.
struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string message;
    std::vector<std::string> context{};  ///< innermost first: "contact 118", "pass 4", "impeller.step face 12"

    /// Adds a place on the way up: `return std::move(error).in("face 12")`.
    Error in(std::string where) && {
        context.push_back(std::move(where));
        return std::move(*this);
    }
    /// "outermost: ...: innermost: message"
    std::string text() const {
        std::string all;
        for (auto place = context.rbegin(); place != context.rend(); ++place) all += *place + ": ";
        return all + message;
    }
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
    return tl::unexpected<Error>(Error{code, std::move(message), {}});
}

/// Hands an error up with one more place: `return fail_in(result, "face 3")`.
template <class T>
tl::unexpected<Error> fail_in(Result<T>&& failed, std::string where) {
    return tl::unexpected<Error>(std::move(failed.error()).in(std::move(where)));
}
template <class T>
tl::unexpected<Error> fail_up(Result<T>&& failed) {
    return tl::unexpected<Error>(std::move(failed.error()));
}

namespace detail {
[[noreturn]] inline void require_failed(const char* condition, const char* file, int line) {
    throw std::logic_error(std::string(file) + ":" + std::to_string(line) + ": required: " + condition);
}
}  // namespace detail

}  // namespace trunnion

/// A caller's bug, not a user's mistake: throws std::logic_error.
#define TRUNNION_REQUIRE(condition)                                                           \
    do {                                                                                      \
        if (!(condition)) ::trunnion::detail::require_failed(#condition, __FILE__, __LINE__); \
    } while (false)
