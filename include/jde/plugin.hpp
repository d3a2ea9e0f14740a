/*
 * The tables that the host reads, and the functions in them. No exception leaves any of these functions.
 */
#ifndef JDE_PLUGIN_HPP
#define JDE_PLUGIN_HPP

#include "panel.hpp"

namespace jde {
namespace detail {

/** Reads what a schema declares. */
struct Access {
    static constexpr std::size_t port_count(const Ports &ports) noexcept { return ports.port_count_; }
    static constexpr std::size_t child_count(const Ports &ports) noexcept { return ports.child_count_; }
    template <typename T>
    static constexpr std::uint32_t number(const Export<T> &port) noexcept { return port.number_; }
    static void adopt(Ports &ports, const jde_port *table) noexcept { ports.table_ = table; }
    template <std::size_t N>
    static constexpr std::array<jde_port, N> ports(const Ports &ports) noexcept
    {
        std::array<jde_port, N> tables{};
        const Port *port = ports.last_port_;
        for (std::size_t left = N; left > 0; left--, port = port->previous_) {
            tables[left - 1] = port->table_;
        }
        return tables;
    }
    template <std::size_t N>
    static constexpr std::array<jde_child, N> children(const Ports &ports) noexcept
    {
        std::array<jde_child, N> tables{};
        const Child *child = ports.last_child_;
        for (std::size_t left = N; left > 0; left--, child = child->previous_) {
            tables[left - 1] = child->table_;
        }
        return tables;
    }
    template <typename T>
    static T state_type(const Export<T> &);
};

/** An instance, and the host that it belongs to. */
template <typename S>
struct Instance {
    const jde_host &host;
    S schema{};
};

/** Runs a call, and reports an exception to the host with its text. */
template <typename Body>
std::int32_t guarded(const jde_host &host, jde_context *cx, Body body) noexcept
{
    const auto fail = [&](const char *reason) { host.fail(cx, reason, std::strlen(reason)); };
    try {
        body();
        return JDE_OK;
    } catch (const std::logic_error &mistake) {
        fail(mistake.what());
        return JDE_PANICKED;
    } catch (const NoValue &missing) {
        fail(missing.what());
        return JDE_NO_VALUE;
    } catch (const std::exception &failure) {
        fail(failure.what());
        return JDE_FAILED;
    } catch (...) {
        fail("it threw something that is not a std::exception");
        return JDE_PANICKED;
    }
}

/** Copies a reason. One that is too long is cut before a character. */
template <std::size_t N>
void cut(char (&room)[N], const std::string &reason) noexcept
{
    std::size_t length = reason.size() < N ? reason.size() : N - 1;
    while (length > 0 && length < reason.size() && (reason[length] & 0xC0) == 0x80) {
        length--;
    }
    std::memcpy(room, reason.data(), length);
    room[length] = '\0';
}

/** The state and the command of a guard, from its function. */
template <typename Function>
struct Judged;
template <typename St, typename Cm>
struct Judged<Judgement (*)(const St &, Nanoseconds, const Cm &)> {
    using State = St;
    using Command = Cm;
};

/** Whether a guard limits commands. */
template <typename S, typename = void>
struct Limits : std::false_type {};
template <typename S>
struct Limits<S, std::void_t<decltype(&S::limit)>> : std::true_type {};

/* Tables have internal linkage: see value.hpp. */
namespace {

/** The tables and functions of a type of schema. */
template <typename S>
struct Tables {
    using Declared = typename S::Declared;

    static constexpr Declared prototype{};
    static constexpr auto ports = Access::ports<Access::port_count(prototype)>(prototype);
    static constexpr auto children = Access::children<Access::child_count(prototype)>(prototype);

    static void *create(const jde_schema *, const jde_host *host, jde_context *cx) noexcept
    {
        if (!jde_host_fits(host) || cx == nullptr) {
            return nullptr;
        }
        Instance<S> *made = nullptr;
        guarded(*host, cx, [&] {
            made = new Instance<S>{*host};
            Access::adopt(made->schema, ports.data());
        });
        return made;
    }

    static void destroy(void *instance) noexcept
    {
        try {
            delete static_cast<Instance<S> *>(instance);
        } catch (...) {
            /* No call remains that could report the text. */
        }
    }

    /** Calls a function of an instance. */
    template <typename Body>
    static std::int32_t call(void *instance, jde_context *raw, Body body) noexcept
    {
        if (instance == nullptr || raw == nullptr) {
            return JDE_BAD_ARGUMENT;
        }
        auto &self = *static_cast<Instance<S> *>(instance);
        return guarded(self.host, raw, [&] {
            Context cx(self.host, raw, ports.data());
            body(self.schema, cx);
        });
    }

    static std::int32_t awake(void *instance, jde_context *cx) noexcept
    {
        return call(instance, cx, [](S &schema, Context &context) { schema.awake(context); });
    }

    static std::int32_t check(void *instance, jde_context *cx, jde_precondition *out) noexcept
    {
        if (out == nullptr) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](S &schema, Context &context) {
            const Precondition result = schema.check(context);
            if (!std::isfinite(result.urgency)) {
                throw Failure(format("its check offered an urgency of %g; it must be finite", result.urgency));
            }
            out->ready = result.ready ? 1 : 0;
            out->urgency = result.urgency;
        });
    }

    static std::int32_t iterate(void *instance, jde_context *cx) noexcept
    {
        return call(instance, cx, [](S &schema, Context &context) { schema.iterate(context); });
    }

    static std::int32_t arbitrate(void *instance, jde_context *cx, const jde_level *level, jde_verdict *out) noexcept
    {
        if (level == nullptr || out == nullptr) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](S &schema, Context &context) {
            const Verdict verdict = schema.arbitrate(context, Level(*level));
            out->child = verdict.child;
            cut(out->reason, verdict.reason);
        });
    }

    static void sleep(void *instance, jde_context *cx) noexcept
    {
        call(instance, cx, [](S &schema, Context &context) { schema.sleep(context); });
    }

    static std::int32_t draw(void *instance, jde_context *cx, const jde_pen *raw) noexcept
    {
        if (raw == nullptr || raw->size < sizeof *raw) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](const S &schema, Context &context) {
            Pen pen(*raw);
            schema.draw(context, pen);
        });
    }

    static std::int32_t touch(void *instance, jde_context *cx, const jde_gesture *gesture) noexcept
    {
        if (gesture == nullptr || gesture->size < sizeof *gesture) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](S &schema, Context &context) { schema.touched(context, Gesture(*gesture)); });
    }

    static std::int32_t save(void *instance, jde_context *cx, const jde_saver *saver) noexcept
    {
        if (saver == nullptr || saver->size < sizeof *saver) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](const S &schema, Context &context) {
            Saving saving;
            schema.save(context, saving);
            if (jde_save(saver, saving.bytes().data(), saving.bytes().size()) != JDE_OK) {
                throw Failure(format("it saves %zu bytes, more than are kept", saving.bytes().size()));
            }
        });
    }

    static std::int32_t restore(void *instance, jde_context *cx, std::uint32_t version, const void *bytes, std::uint64_t length) noexcept
    {
        if (bytes == nullptr && length > 0) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](S &schema, Context &context) {
            Saved saved(version, {static_cast<const char *>(bytes), static_cast<std::size_t>(length)});
            schema.restore(context, saved);
        });
    }

    static std::int32_t inspect(void *instance, jde_context *cx, const jde_problems *raw) noexcept
    {
        if (raw == nullptr || raw->size < sizeof *raw) {
            return JDE_BAD_ARGUMENT;
        }
        return call(instance, cx, [&](S &schema, Context &context) {
            Problems problems(*raw);
            schema.inspect(context, problems);
        });
    }

    static std::int32_t judge(const void *state, std::uint64_t age, const void *command, jde_judgement *out) noexcept
    {
        using Types = Judged<decltype(&S::judge)>;
        if (state == nullptr || command == nullptr || out == nullptr) {
            return JDE_BAD_ARGUMENT;
        }
        Judgement judgement = {false, {}};
        std::int32_t code = JDE_PANICKED;
        try {
            const auto &by = *static_cast<const typename Types::State *>(state);
            const auto &judged = *static_cast<const typename Types::Command *>(command);
            const Nanoseconds time(static_cast<std::int64_t>(age));
            judgement = S::judge(by, time, judged);
            if constexpr (Limits<S>::value) {
                if (!judgement.accepted) {
                    const std::optional<typename Types::Command> lesser = S::limit(by, time, judged);
                    if (lesser.has_value() && S::judge(by, time, *lesser).accepted) {
                        return jde_limit(out, &*lesser, sizeof *lesser, judgement.reason.c_str());
                    }
                }
            }
            code = JDE_OK;
        } catch (const std::exception &failure) {
            judgement.reason = failure.what();
        } catch (...) {
            judgement.reason = "it threw something that is not a std::exception";
        }
        out->accepted = judgement.accepted ? 1 : 0;
        cut(out->reason, judgement.reason);
        return code;
    }

    /** The table of an ability; null if the schema does not have it. */
    static const void *ability(const char *id) noexcept
    {
        const std::string_view name = id != nullptr ? id : "";
        if constexpr (std::is_base_of_v<Panel, S>) {
            static constexpr jde_panel table = {sizeof(jde_panel), 0, draw, touch};
            if (name == JDE_ABILITY_PANEL) {
                return &table;
            }
        }
        if constexpr (std::is_base_of_v<Memory, S>) {
            static constexpr jde_state table = {sizeof(jde_state), S::version(), save, restore};
            if (name == JDE_ABILITY_STATE) {
                return &table;
            }
        }
        if constexpr (std::is_base_of_v<Inspect, S>) {
            static constexpr jde_inspect table = {sizeof(jde_inspect), 0, inspect};
            if (name == JDE_ABILITY_INSPECT) {
                return &table;
            }
        }
        if constexpr (std::is_base_of_v<Guard, S>) {
            static_assert(S::kind() == JDE_PERCEPTIVE, "a guard is a perceptive schema");
            using Types = Judged<decltype(&S::judge)>;
            static_assert(std::is_same_v<decltype(Access::state_type(prototype.*S::state())), typename Types::State>,
                          "the export that `state` names has the type of the first argument of `judge`");
            static constexpr jde_guard table = {sizeof(jde_guard), Access::number(prototype.*S::state()),
                                                &type_of<typename Types::Command>(), judge};
            if (name == JDE_ABILITY_GUARD) {
                return &table;
            }
        }
        return nullptr;
    }

    static constexpr jde_schema schema() noexcept
    {
        static_assert(!std::is_abstract_v<S>, "the schema does not say what it does: override `iterate` and what its abilities require");
        static_assert(std::is_default_constructible_v<S>, "the host makes an instance without arguments");
        constexpr About about = S::about();
        static_assert(about.period.count() > 0 && about.budget.count() >= 0, "the period is at least 1 ns, and the budget is not negative");
        constexpr bool arbitrates = std::is_base_of_v<Arbitrate, S>;
        static_assert(S::kind() == JDE_MOTOR || !arbitrates, "only a motor schema can arbitrate among children");
        jde_schema table = {sizeof(jde_schema), S::kind(), about.name, about.doc, static_cast<std::uint64_t>(about.period.count()),
                            static_cast<std::uint64_t>(about.budget.count()), ports.data(), children.data(),
                            static_cast<std::uint32_t>(ports.size()), static_cast<std::uint32_t>(children.size()), create, destroy,
                            awake, nullptr, iterate, nullptr, sleep, ability};
        if constexpr (S::kind() == JDE_MOTOR) {
            table.check = check;
        }
        if constexpr (arbitrates) {
            table.arbitrate = arbitrate;
        }
        return table;
    }
};

/** The tables of all schemas of a plugin. */
template <typename... Schemas>
struct Exported {
    static constexpr jde_schema tables[] = {Tables<Schemas>::schema()...};
};

} // namespace
} // namespace detail
} // namespace jde

/** Exports a plugin: its name, its version, one sentence about it, and its schemas. Once in a library, outside all namespaces. */
#define JDE_EXPORT_PLUGIN(name, version, doc, ...)                   \
    using jde_exported = jde::detail::Exported<__VA_ARGS__>;         \
    JDE_PLUGIN_GUARDED(name, version, doc, jde_exported::tables)

#endif
