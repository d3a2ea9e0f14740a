/* A disk that fails, for tests: preloaded, it stands before the system's own calls for files whose name ends in `.mcap` and for
 * no others. DISK_BAD_SYNC=N has the Nth request to have the data on the disk fail, and as on Linux only that one is told;
 * DISK_ROOM=N has the disk full after N bytes. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_long syncs, written;

static long setting(const char *name)
{
    const char *value = getenv(name);
    return value ? atol(value) : -1;
}

static int is_recording(int fd)
{
    char link[64], name[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, name, sizeof name);
    return length > 5 && memcmp(name + length - 5, ".mcap", 5) == 0;
}

int fdatasync(int fd)
{
    if (is_recording(fd) && atomic_fetch_add(&syncs, 1) + 1 == setting("DISK_BAD_SYNC")) {
        errno = EIO;
        return -1;
    }
    int (*real)(int) = (int (*)(int))dlsym(RTLD_NEXT, "fdatasync");
    return real(fd);
}

ssize_t write(int fd, const void *bytes, size_t count)
{
    ssize_t (*real)(int, const void *, size_t) = (ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    long room = setting("DISK_ROOM");
    if (room >= 0 && is_recording(fd)) {
        long left = room - atomic_load(&written);
        if (left <= 0) {
            errno = ENOSPC;
            return -1;
        }
        count = count < (size_t)left ? count : (size_t)left;
        ssize_t done = real(fd, bytes, count);
        atomic_fetch_add(&written, done > 0 ? done : 0);
        return done;
    }
    return real(fd, bytes, count);
}
