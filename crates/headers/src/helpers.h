/*
 * What follows is for authors in C and C++: macros that fill tables, and functions that use the host's.
 */

#if defined(__GNUC__)
#define JDE_VISIBLE __attribute__((visibility("default")))
#else
#define JDE_VISIBLE
#endif

/** How many elements an array has. */
#define JDE_COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))
/** Milliseconds in ns. */
#define JDE_MS(number) ((uint64_t)(number) * UINT64_C(1000000))
/** No least or greatest value. */
#define JDE_UNBOUNDED ((double)NAN)

/** Exports the plugin: its name, its version, one sentence, and its array of jde_schema. Once in a library. */
#define JDE_PLUGIN(name, version, doc, schemas)                                                             \
    extern JDE_VISIBLE const struct jde_plugin jde_plugin;                                                  \
    const struct jde_plugin jde_plugin = {JDE_MAGIC, JDE_ABI_MAJOR, JDE_ABI_MINOR,                          \
                                          (uint32_t)sizeof(struct jde_plugin), 0u, name, version, doc,      \
                                          schemas, JDE_COUNT(schemas), 0u}

/** A jde_port that reads a variable of another schema; `type` is a jde_type. */
#define JDE_PORT_IMPORT(name, doc, type, flags) \
    {(uint32_t)sizeof(jde_port), JDE_IMPORT, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u}
/** A jde_port that writes a variable. */
#define JDE_PORT_EXPORT(name, doc, type) \
    {(uint32_t)sizeof(jde_port), JDE_EXPORT, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, 0u, 0u}
/** A jde_port that the father writes; `initial` is a static const value of the type, `unit` that of a plain number. */
#define JDE_PORT_MODULATION(name, doc, unit, type, initial, min, max, flags) \
    {(uint32_t)sizeof(jde_port), JDE_MODULATION, name, doc, unit, &(type), &(initial), min, max, 0u, flags, 0u}
/** A jde_port of a driver that reaches an actuator; `neutral` is a static const value that stops it. */
#define JDE_PORT_COMMAND(name, doc, type, neutral, validity_ns)                                      \
    {(uint32_t)sizeof(jde_port), JDE_COMMAND, name, doc, "", &(type), &(neutral), JDE_UNBOUNDED, JDE_UNBOUNDED, \
     validity_ns, 0u, 0u}
/** A jde_port that writes a driver's command. */
#define JDE_PORT_ACTUATOR(name, doc, type, flags) \
    {(uint32_t)sizeof(jde_port), JDE_ACTUATOR, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, 0u, flags, 0u}
/** A jde_port that writes the modulation `name` of the child of this number. */
#define JDE_PORT_CHILD_MODULATION(child, name, doc, type, flags)                                             \
    {(uint32_t)sizeof(jde_port), JDE_CHILD_MODULATION, name, doc, "", &(type), NULL, JDE_UNBOUNDED, JDE_UNBOUNDED, \
     0u, flags, child}

/** A jde_child that competes in a group. */
#define JDE_CHILD_MOTOR(name, group, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_MOTOR, name, group, doc, flags, 0u}
/** A jde_child that helps. */
#define JDE_CHILD_PERCEPTIVE(name, doc, flags) \
    {(uint32_t)sizeof(jde_child), JDE_PERCEPTIVE, name, "", doc, flags, 0u}

/** Whether this header's functions may be used on a host: to be asked in jde_schema.create before anything else. */
static inline int jde_host_fits(const jde_host *host)
{
    return host != NULL && host->size >= sizeof(jde_host) && host->abi_major == JDE_ABI_MAJOR;
}

/** The value of an import, modulation or command of `bytes` bytes; NULL if there is none. `sample` may be NULL. */
static inline const void *jde_get(const jde_host *host, jde_context *context, uint32_t port, size_t bytes,
                                  jde_sample *sample)
{
    jde_sample own;
    jde_sample *seen = sample != NULL ? sample : &own;
    if (host->read(context, port, seen) != JDE_OK || seen->bytes != bytes) {
        return NULL;
    }
    return seen->data;
}

/** Writes `bytes` bytes to an export, actuator or child's modulation; answers as jde_host.publish does. */
static inline int32_t jde_put(const jde_host *host, jde_context *context, uint32_t port, const void *value,
                              size_t bytes)
{
    void *room = NULL;
    int32_t code = host->loan(context, port, &room);
    if (code != JDE_OK) {
        return code;
    }
    memcpy(room, value, bytes);
    return host->publish(context, port, 0u);
}

/** Says something to whoever listens. */
static inline void jde_say(const jde_host *host, jde_context *context, uint32_t level, const char *text)
{
    host->log(context, level, text, strlen(text));
}

/** Gives the reason for a failure: `return jde_failed(host, context, "the cable is loose");`. */
static inline int32_t jde_failed(const jde_host *host, jde_context *context, const char *reason)
{
    host->fail(context, reason, strlen(reason));
    return JDE_FAILED;
}
