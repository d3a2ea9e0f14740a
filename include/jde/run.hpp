/*
 * Programs that run applications, in C++17: the functions of jde_run.h as classes. docs/embedding.md explains them.
 *
 * A function throws jde::Error, whose text is that of jde_error(). All functions may be called from any thread, as those of
 * jde_run.h; only to move or destroy an object is for one thread alone.
 */
#ifndef JDE_RUN_HPP
#define JDE_RUN_HPP

#include "../jde_run.h"
#include "types.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace jde {

/** What libjde refuses, in words. */
class Error : public std::runtime_error {
public:
    explicit Error(std::int32_t status) : std::runtime_error(jde_error()), status_(status) {}

    /** The status of jde_run.h: JDE_BAD_ARGUMENT, JDE_REFUSED, JDE_FAILED ... */
    std::int32_t status() const noexcept { return status_; }

private:
    std::int32_t status_;
};

/** How to load an application; jde_load_options explains the members. */
struct LoadOptions {
    std::vector<std::string> values;
    std::vector<std::string> mocks;
    /** Empty for the one that the library finds. */
    std::string executable;
};

/** How to start an application; jde_start_options explains the members. */
struct StartOptions {
    bool lockstep = false;
    std::optional<std::uint64_t> seed;
    /** s; 0 for none. */
    double limit = 0.0;
    double speed = 1.0;
    bool records = true;
    std::string name = "program";
};

/** A record of a run. */
struct Record {
    /** JDE_RECORD_DECISION, JDE_RECORD_STATE or JDE_RECORD_EVENT. */
    std::uint32_t kind;
    std::string json;
    /** How many records were dropped before this one. */
    std::uint64_t dropped;
};

namespace detail {

inline void require(std::int32_t status)
{
    if (status != JDE_OK) {
        throw Error(status);
    }
}

/** Returns whether a call did what it was to do, and did not meet one of the expected reasons. */
template <typename... Expected>
bool done(std::int32_t status, Expected... expected)
{
    if (((status == expected) || ...)) {
        return false;
    }
    require(status);
    return true;
}

/** Returns the text of a call, or none for JDE_NO_VALUE. */
template <typename Call>
std::optional<std::string> text(Call call)
{
    char *given = nullptr;
    if (!done(call(&given), JDE_NO_VALUE)) {
        return std::nullopt;
    }
    const std::unique_ptr<char, decltype(&jde_free_text)> owned(given, &jde_free_text);
    return std::string(given);
}

} // namespace detail

/** A started application. Its destructor brings the application to rest, and blocks until it is. */
class Run {
public:
    explicit Run(jde_run *handle) noexcept : handle_(handle) {}
    Run(Run &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Run &operator=(Run &&other) noexcept
    {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Run()
    {
        if (handle_ != nullptr) {
            jde_run_close(handle_);
        }
    }

    /** Runs the next instant in lockstep. Returns whether the application goes on. */
    bool step() { return detail::done(jde_run_step(handle_), JDE_ENDED, JDE_NOT_REACHED); }

    /** Lets time pass, or waits in real time, until a time, s. Returns whether it was reached: not if the application ends. */
    bool until(double time) { return detail::done(jde_run_until(handle_, time), JDE_ENDED); }

    /** The same until a condition is true, or a time, s, is reached. Returns whether it is true. */
    bool until(const std::string &condition, double time = INFINITY)
    {
        const std::int32_t status = jde_run_until_condition(handle_, condition.c_str(), time);
        return detail::done(status, JDE_ENDED, JDE_NOT_REACHED);
    }

    /** The time, s. */
    double time() const
    {
        double time = 0.0;
        detail::require(jde_run_time(handle_, &time));
        return time;
    }

    /** How the application ended; none while it runs. */
    std::optional<std::string> outcome() const
    {
        return detail::text([this](char **text) { return jde_run_outcome(handle_, text); });
    }

    /** Brings the application to rest. Its variables and records can still be read. */
    void end() { detail::require(jde_run_end(handle_)); }

    /** Reads the newest value of a variable into `value`. Returns false without one. */
    template <typename T>
    bool read(const std::string &name, T &value, jde_sample *sample = nullptr) const
    {
        static_assert(is_value<T>, "a variable is read as a value: a standard type, or one of JDE_VALUE");
        return detail::done(jde_run_read(handle_, name.c_str(), &Value<T>::type(), &value, sample), JDE_NO_VALUE);
    }

    /** Returns the newest value of a variable, on the stack. */
    template <typename T>
    std::optional<T> read(const std::string &name) const
    {
        std::optional<T> value(std::in_place);
        if (!read(name, *value)) {
            value.reset();
        }
        return value;
    }

    /** Returns a number by its path: "pioneer.odometry.pose.x". */
    std::optional<double> number(const std::string &path) const
    {
        double number = 0.0;
        const bool found = detail::done(jde_run_read_number(handle_, path.c_str(), &number), JDE_NO_VALUE);
        return found ? std::optional(number) : std::nullopt;
    }

    /** Returns a variable or a part of it as a text. */
    std::optional<std::string> text(const std::string &path) const
    {
        return detail::text([&](char **text) { return jde_run_read_text(handle_, path.c_str(), text); });
    }

    /** The description of the type of a variable. */
    const jde_type &type(const std::string &name) const
    {
        const jde_type *type = nullptr;
        detail::require(jde_run_type(handle_, name.c_str(), &type));
        return *type;
    }

    /** Writes a modulation, a period or what a mock writes: a number, or true or false. */
    template <typename T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
    void write(const std::string &name, T number)
    {
        if constexpr (std::is_floating_point_v<T>) {
            detail::require(jde_run_write_number(handle_, name.c_str(), static_cast<double>(number)));
        } else if constexpr (std::is_same_v<T, bool>) {
            write(name, number ? "true" : "false");
        } else {
            write(name, std::to_string(number));
        }
    }

    /** The same from a text, as an application file states it: "30 cm/s". */
    void write(const std::string &name, const std::string &value)
    {
        detail::require(jde_run_write_text(handle_, name.c_str(), value.c_str()));
    }
    void write(const std::string &name, const char *value) { write(name, std::string(value)); }

    /** The same from a value: a standard type, or one of JDE_VALUE. */
    template <typename T, typename = std::enable_if_t<is_value<T>>>
    void write(const std::string &name, const T &value)
    {
        detail::require(jde_run_write(handle_, name.c_str(), &Value<T>::type(), &value));
    }

    /** The actions of an operator; jde_run.h explains them. */
    void play(const std::string &schema) { detail::require(jde_run_play(handle_, schema.c_str())); }
    void stop(const std::string &schema) { detail::require(jde_run_stop(handle_, schema.c_str())); }
    void force(const std::string &schema) { detail::require(jde_run_force(handle_, schema.c_str())); }
    void release(const std::string &schema) { detail::require(jde_run_release(handle_, schema.c_str())); }
    void stop_all() { detail::require(jde_run_stop_all(handle_)); }
    void release_all() { detail::require(jde_run_release_all(handle_)); }
    void lease(double seconds) { detail::require(jde_run_lease(handle_, seconds)); }
    void edit(const std::string &driver, const std::string &edits)
    {
        detail::require(jde_run_edit(handle_, driver.c_str(), edits.c_str()));
    }

    /** The winner of a group, such as "roots"; none if nobody wins. */
    std::optional<std::string> winner(const std::string &group) const
    {
        return detail::text([&](char **text) { return jde_run_winner(handle_, group.c_str(), text); });
    }

    /** The state of a schema: JDE_SLEPT, JDE_CHECKING, JDE_READY or JDE_WINNER. */
    std::uint32_t state(const std::string &schema) const
    {
        std::uint32_t state = JDE_SLEPT;
        detail::require(jde_run_state(handle_, schema.c_str(), &state));
        return state;
    }

    /** The state of every schema and group, as JSON. */
    std::string snapshot() const
    {
        return detail::text([this](char **text) { return jde_run_snapshot(handle_, text); }).value();
    }

    /** Removes and returns the oldest record that waits; none if there is none. */
    std::optional<Record> next_record()
    {
        Record record{};
        auto json = detail::text(
            [&](char **text) { return jde_run_next_record(handle_, &record.kind, text, &record.dropped); });
        if (!json) {
            return std::nullopt;
        }
        record.json = *std::move(json);
        return record;
    }

    /** The handle, for jde_run.h. */
    jde_run *handle() const noexcept { return handle_; }

private:
    jde_run *handle_;
};

/** An application that was loaded and checked. */
class Application {
public:
    explicit Application(const std::string &file, const LoadOptions &options = {})
    {
        const auto texts = [](const std::vector<std::string> &all) {
            std::vector<const char *> texts;
            for (const std::string &one : all) {
                texts.push_back(one.c_str());
            }
            return texts;
        };
        const auto values = texts(options.values), mocks = texts(options.mocks);
        jde_load_options given{};
        given.size = sizeof given;
        given.values = values.data();
        given.value_count = static_cast<std::uint32_t>(values.size());
        given.mocks = mocks.data();
        given.mock_count = static_cast<std::uint32_t>(mocks.size());
        given.executable = options.executable.empty() ? nullptr : options.executable.c_str();
        detail::require(jde_application_load(file.c_str(), &given, &handle_));
    }
    Application(Application &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Application &operator=(Application &&other) noexcept
    {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Application()
    {
        if (handle_ != nullptr) {
            jde_application_close(handle_);
        }
    }

    /** What is absent at present, such as a device that is not plugged in; empty if nothing is. */
    std::string warnings() const
    {
        return detail::text([this](char **text) { return jde_application_warnings(handle_, text); }).value();
    }

    /** Starts the application at time 0, any number of times. The run needs this object no more. */
    Run start(const StartOptions &options = {}) const
    {
        jde_start_options given{};
        given.size = sizeof given;
        given.flags = (options.lockstep ? JDE_LOCKSTEP : 0u) | (options.seed ? JDE_WITH_SEED : 0u) |
                      (options.records ? 0u : JDE_WITHOUT_RECORDS);
        given.seed = options.seed.value_or(0);
        given.limit = options.limit;
        given.speed = options.speed;
        given.name = options.name.c_str();
        jde_run *run = nullptr;
        detail::require(jde_application_start(handle_, &given, &run));
        return Run(run);
    }

private:
    jde_application *handle_ = nullptr;
};

} // namespace jde

#endif
