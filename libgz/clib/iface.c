/* gz_iface_*: one memory-mapped file of any struct, with its lock. */

#include <errno.h>
#include <fcntl.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "error.h"
#include "gazebo.h"
#include "host.h"
#include "status.h"

const struct gz_host *gz_host = NULL;

/* The struct that gz_iface_alloc allocates: the public part has no field for the number of mapped bytes. */
typedef struct {
    gz_iface_t part;
    size_t mapped;
} whole_iface_t;

gz_iface_t *gz_iface_alloc(void)
{
    whole_iface_t *whole = calloc(1, sizeof *whole);

    if (whole == NULL)
        return NULL;
    whole->part.mmap_fd = -1;
    return &whole->part;
}

void gz_iface_free(gz_iface_t *self)
{
    if (self == NULL)
        return;
    free(self->filename);
    free(self);
}

static int set_filename(gz_iface_t *self, const char *directory, const char *type, const char *id)
{
    char path[GZ_PATH_SIZE];

    if (id == NULL) {
        GZ_ERROR("interface [%s] id is NULL", type);
        return -1;
    }
    if (strchr(id, '.') != NULL) {
        GZ_ERROR("invalid id [%s] (must not contain '.')", id);
        return -1;
    }
    snprintf(path, sizeof path, "%s/%s.%s", directory ? directory : "", type, id);
    free(self->filename);
    self->filename = strdup(path);
    return 0;
}

/* Unmap the memory and close the file. Returns -1, for callers that do so after an error. */
static int release(gz_iface_t *self)
{
    if (self->mmap != NULL)
        munmap(self->mmap, ((whole_iface_t *) self)->mapped);
    self->mmap = NULL;
    if (self->mmap_fd >= 0)
        close(self->mmap_fd);
    self->mmap_fd = -1;
    return -1;
}

static int map_file(gz_iface_t *self, size_t size)
{
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, self->mmap_fd, 0);

    if (memory == MAP_FAILED)
        return -1;
    self->mmap = memory;
    ((whole_iface_t *) self)->mapped = size;
    return 0;
}

int gz_iface_create(gz_iface_t *self, gz_server_t *server, const char *type, const char *id, size_t size)
{
    gz_data_t *head;

    self->server = server;
    if (IS_HOSTED(server))
        return gz_host->create(self, type, id, size);
    if (set_filename(self, server->filename, type, id) != 0)
        return -1;
    self->mmap_fd = open(self->filename, O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (self->mmap_fd < 0) {
        GZ_ERROR("error creating mmap file: %s", strerror(errno));
        return -1;
    }
    if (ftruncate(self->mmap_fd, (off_t) size) < 0) {
        GZ_ERROR("error setting size of mmap file: %s", strerror(errno));
        return release(self);
    }
    if (map_file(self, size) != 0) {
        GZ_ERROR("error mapping mmap file: %s", strerror(errno));
        return release(self);
    }
    head = self->mmap;
    head->version = LIBGAZEBO_VERSION;
    head->size = size;
    GZ_MESSAGE(GZ_FILES, "creating %s %03X %lu", self->filename, head->version, (unsigned long) size);
    return 0;
}

int gz_iface_destroy(gz_iface_t *self)
{
    if (IS_HOSTED(self->server))
        return gz_host->destroy(self);
    GZ_MESSAGE(GZ_FILES, "deleting %s", self->filename);
    release(self);
    if (unlink(self->filename) != 0) {
        GZ_ERROR("error deleting mmap file: %s", strerror(errno));
        return -1;
    }
    return 0;
}

/* Print an error if a file is laid out for programs of another ABI. Every struct begins with an int and a size_t: where
 * size_t has 4 bytes, it follows at once, and otherwise after 4 bytes of zeros. Returns whether it is. */
static int is_foreign(const gz_iface_t *self)
{
    int32_t words[3] = {0, 0, 0};
    int narrow;

    if (pread(self->mmap_fd, words, sizeof words, 0) != (ssize_t) sizeof words || words[0] == 0)
        return 0;
    narrow = words[1] != 0;
    if (narrow == (sizeof(size_t) == 4) || (!narrow && words[2] == 0))
        return 0;
    GZ_ERROR("%s has the layout of %s programs, and this program is one of %s; %s", self->filename,
             narrow ? "i386" : "x86_64", narrow ? "x86_64" : "i386",
             narrow ? "start the server without --abi i386" : "start the server with --abi i386");
    return 1;
}

/* Whether a server's directory is that of this process's user, or of root, or, if this is root, of USER. In a directory
 * like /tmp anybody can make one of this name, with links to files that the user's programs would then write into. */
static int is_trusted(const char *directory)
{
    const char *name = getenv("USER");
    const struct passwd *user;
    struct stat about;

    if (status_of_path(directory, &about) != 0)
        return 1; /* opening a file in it reports why */
    if (!S_ISDIR(about.st_mode)) {
        GZ_ERROR("%s is no directory", directory);
        return 0;
    }
    if (about.st_uid == geteuid() || about.st_uid == 0)
        return 1;
    user = geteuid() == 0 && name != NULL ? getpwnam(name) : NULL;
    if (user != NULL && user->pw_uid == about.st_uid)
        return 1;
    GZ_ERROR("%s belongs to another user (uid %d)", directory, (int) about.st_uid);
    return 0;
}

int gz_iface_open(gz_iface_t *self, gz_client_t *client, const char *type, const char *id, size_t size)
{
    struct stat about;
    size_t announced;

    self->client = client;
    if (!is_trusted(client->filename) || set_filename(self, client->filename, type, id) != 0)
        return -1;
    self->mmap_fd = open(self->filename, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (self->mmap_fd < 0) {
        GZ_ERROR("error opening device file %s : %s", self->filename, strerror(errno));
        return -1;
    }
    if (is_foreign(self))
        return release(self);
    /* Access to mapped memory beyond the end of a file raises SIGBUS, so check the size before mapping. */
    if (status_of(self->mmap_fd, &about) == 0 && about.st_size < (off_t) size) {
        GZ_ERROR("expected file size: %d < %d", (int) size, (int) about.st_size);
        return release(self);
    }
    if (map_file(self, size) != 0) {
        GZ_ERROR("error mapping device file: %s", strerror(errno));
        return release(self);
    }
    announced = ((gz_data_t *) self->mmap)->size;
    if (announced < size) {
        GZ_ERROR("expected file size: %d < %d", (int) size, (int) announced);
        return release(self);
    }
    GZ_MESSAGE(GZ_FILES, "opening %s %03X %lu", self->filename, ((gz_data_t *) self->mmap)->version,
               (unsigned long) size);
    return 0;
}

int gz_iface_close(gz_iface_t *self)
{
    GZ_MESSAGE(GZ_FILES, "closing %s", self->filename);
    release(self);
    return 0;
}

int gz_iface_lock(gz_iface_t *self, int blocking)
{
    (void) blocking; /* never had an effect */
    if (IS_HOSTED(self->server))
        return gz_host->lock(self);
    if (flock(self->mmap_fd, LOCK_EX) == 0)
        return 0;
    GZ_ERROR("flock %s error: %s", self->filename, strerror(errno));
    return -1;
}

void gz_iface_unlock(gz_iface_t *self)
{
    if (IS_HOSTED(self->server))
        gz_host->unlock(self);
    else if (flock(self->mmap_fd, LOCK_UN) != 0)
        GZ_ERROR("flock error: %s", strerror(errno));
}

int gz_iface_post(gz_iface_t *self)
{
    if (self->server == NULL) {
        GZ_ERROR("interface %s belongs to a client, and only servers post", self->filename ? self->filename : "");
        return -1;
    }
    return gz_server_post(self->server);
}
