/*
 * The context of a call: what a schema may ask the host while the host calls it.
 */
#ifndef JDE_CONTEXT_HPP
#define JDE_CONTEXT_HPP

#include "value.hpp"

#include <chrono>
#include <cstdarg>
#include <cstdio>

namespace jde {

/** A time since the application's start, or a duration. */
using Nanoseconds = std::chrono::nanoseconds;

/** The reason why a call fails. Any other exception but std::logic_error does the same. */
using Failure = std::runtime_error;

/**
 * An import has no value. An iteration or a check that it leaves ends there, without a fault, and a motor schema is not
 * READY (R19).
 */
class NoValue : public Failure {
public:
    using Failure::Failure;
};

/** The result of a command or a request. None of them is a fault. */
enum class Outcome {
    accepted,
    /** The schema has no authority at this instant (R7), or a guard refuses the command (R18). */
    refused,
    /** It contains a NaN or an infinity. */
    not_finite,
    /** It is outside the limits of the modulation. */
    out_of_range,
    /** The application leaves the optional port or child unbound. */
    unbound,
};

namespace detail {

/** Throws what a port or child of this name cannot do. */
[[noreturn]] inline void broken(const char *name, const char *call, std::int32_t code)
{
    if (code == JDE_REFUSED) {
        throw std::logic_error(std::string("`") + name + "` is refused to this call: it draws a panel, or it hung and was given up");
    }
    throw std::logic_error("the host answered " + std::to_string(code) + " to `" + call + "` of `" + name + "`, which it never may");
}

inline Outcome outcome(const char *name, const char *call, std::int32_t code)
{
    switch (code) {
    case JDE_OK: return Outcome::accepted;
    case JDE_REFUSED: return Outcome::refused;
    case JDE_NOT_FINITE: return Outcome::not_finite;
    case JDE_OUT_OF_RANGE: return Outcome::out_of_range;
    case JDE_UNBOUND: return Outcome::unbound;
    default: broken(name, call, code);
    }
}

} // namespace detail

#if defined(__GNUC__)
#define JDE_FORMAT(words, arguments) __attribute__((format(printf, words, arguments)))
#else
#define JDE_FORMAT(words, arguments)
#endif

/** Returns a text with numbers in it, in the format of printf. */
inline JDE_FORMAT(1, 0) std::string vformat(const char *format, std::va_list arguments)
{
    std::va_list again;
    va_copy(again, arguments);
    const int length = std::vsnprintf(nullptr, 0, format, again);
    va_end(again);
    std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, arguments);
    return text;
}

/** The same: `throw jde::Failure(jde::format("%s is gone", name))`. */
inline JDE_FORMAT(1, 2) std::string format(const char *format, ...)
{
    std::va_list arguments;
    va_start(arguments, format);
    std::string text = vformat(format, arguments);
    va_end(arguments);
    return text;
}

/* A function that writes a log message. */
#define JDE_LOG(name, level)                                     \
    JDE_FORMAT(2, 3) void name(const char *format, ...) const    \
    {                                                            \
        std::va_list arguments;                                  \
        va_start(arguments, format);                             \
        log(level, vformat(format, arguments));                  \
        va_end(arguments);                                       \
    }

/** The context of the present call. It is valid until the call returns, and on its thread only. No function blocks. */
class Context {
public:
    Context(const jde_host &host, jde_context *raw, const jde_port *ports) noexcept : host_(host), raw_(raw), ports_(ports) {}
    Context(const Context &) = delete;
    Context &operator=(const Context &) = delete;

    /** Time since the application's start. In lockstep it is constant during a call. */
    Nanoseconds now() const noexcept { return Nanoseconds(static_cast<std::int64_t>(host_.now(raw_))); }
    /** A seed for random generators, which depends only on the application's seed and the instance's name. */
    std::uint64_t seed() const noexcept { return host_.seed(raw_); }
    /** A number that all instances of one running application share. */
    std::uint64_t application() const noexcept { return host_.application(raw_); }
    /** The instance's name in the application. */
    const char *name() const noexcept { return host_.name(raw_); }
    /** Throws in lockstep, at another speed and in a replay: for what speaks to a device, in `awake`. */
    void require_real_time() const
    {
        if (JDE_HOST_HAS(&host_, real_time) && host_.real_time(raw_) == 0) {
            throw Failure("it speaks to a device, which can be neither hurried nor halted: run without --lockstep, "
                          "--speed and --break, and in no replay (--record FILE --when CONDITION records what leads to a moment)");
        }
    }

    /** Writes a log message of a level, JDE_TRACE to JDE_ERROR. */
    void log(std::uint32_t level, std::string_view text) const noexcept { host_.log(raw_, level, text.data(), text.size()); }
    /** Writes a log message in the format of printf. */
    JDE_LOG(trace, JDE_TRACE)
    JDE_LOG(debug, JDE_DEBUG)
    JDE_LOG(info, JDE_INFO)
    JDE_LOG(warn, JDE_WARN)
    JDE_LOG(error, JDE_ERROR)

    /** The host and its context, for what this class does not offer. */
    const jde_host &host() const noexcept { return host_; }
    jde_context *raw() const noexcept { return raw_; }
    /** The ports of the schema that is called. */
    const jde_port *ports() const noexcept { return ports_; }

private:
    const jde_host &host_;
    jde_context *raw_;
    const jde_port *ports_;
};

#undef JDE_LOG

} // namespace jde

#endif
