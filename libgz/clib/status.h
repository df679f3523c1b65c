/* fstat and lstat, by their numbers where the kernel's struct is libc's: as symbols they would need glibc 2.33. */
#ifndef LIBGZ_STATUS_H
#define LIBGZ_STATUS_H

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__linux__) && (defined(__x86_64__) && !defined(__ILP32__) || defined(__aarch64__))
static inline int status_of(int descriptor, struct stat *about)
{
    return (int) syscall(SYS_fstat, descriptor, about);
}

static inline int status_of_path(const char *path, struct stat *about)
{
    return (int) syscall(SYS_newfstatat, AT_FDCWD, path, about, AT_SYMLINK_NOFOLLOW);
}
#else
static inline int status_of(int descriptor, struct stat *about)
{
    return fstat(descriptor, about);
}

static inline int status_of_path(const char *path, struct stat *about)
{
    return lstat(path, about);
}
#endif

#endif
