/*
 * A schema in C++ that throws THROWN in its second iteration. With UNGUARDED, its functions do not catch the exception.
 */
#include "jde.h"

#include <stdexcept>

struct thrower {
    const jde_host *host;
    int iterations;
};

static void *create(const jde_schema *, const jde_host *host, jde_context *context)
{
    if (!jde_host_fits(host)) {
        return nullptr;
    }
    return jde_guarded(host, context, static_cast<void *>(nullptr), [&]() -> void * { return new thrower{host, 0}; });
}

static void destroy(void *instance)
{
    delete static_cast<thrower *>(instance);
}

static int32_t iterate(void *instance, jde_context *context)
{
    thrower *self = static_cast<thrower *>(instance);
    auto work = [&]() -> int32_t {
        if (++self->iterations == 2) {
            throw THROWN;
        }
        return JDE_OK;
    };
#ifdef UNGUARDED
    (void)context;
    return work();
#else
    return jde_guarded(self->host, context, static_cast<int32_t>(JDE_PANICKED), work);
#endif
}

static const jde_schema schemas[] = {
    {static_cast<uint32_t>(sizeof(jde_schema)), JDE_MOTOR, "thrower", "Throws.", JDE_MS(10), 0u, nullptr, nullptr, 0u, 0u, create,
     destroy, nullptr, nullptr, iterate, nullptr, nullptr, nullptr},
};

#ifdef UNGUARDED
JDE_PLUGIN("thrower", "1", "Throws.", schemas);
#else
JDE_PLUGIN_GUARDED("thrower", "1", "Throws.", schemas);
#endif
