/* gz_server_*: a directory for interface files, and the semaphores that wake clients. */

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ipc.h>
#include <sys/sem.h>
#include <sys/stat.h>
#include <unistd.h>

#include "error.h"
#include "gazebo.h"
#include "host.h"
#include "status.h"

enum { CLIENT_IDS = 16 };

/* On Linux, programs must define this union themselves. */
union semun {
    int val;
    struct semid_ds *buf;
    unsigned short *array;
};

static int set_flags(int semaphores, unsigned short value)
{
    unsigned short flags[CLIENT_IDS];
    union semun argument;
    int i;

    for (i = 0; i < CLIENT_IDS; i++)
        flags[i] = value;
    argument.array = flags;
    if (semctl(semaphores, 0, SETALL, argument) < 0) {
        GZ_ERROR("failed to initialize semaphore [%s]", strerror(errno));
        return -1;
    }
    return 0;
}

gz_server_t *gz_server_alloc(void)
{
    gz_server_t *self = calloc(1, sizeof *self);

    if (self != NULL)
        self->sem_cid = -1;
    return self;
}

void gz_server_free(gz_server_t *self)
{
    if (self == NULL)
        return;
    free(self->filename);
    free(self);
}

static int make_semaphores(gz_server_t *self, int force)
{
    self->sem_cid = semget(self->sem_key, CLIENT_IDS, IPC_CREAT | (force ? 0 : IPC_EXCL) | S_IRWXU);
    if (self->sem_cid >= 0)
        return set_flags(self->sem_cid, 0);
    GZ_ERROR("Failed to allocate semaphore [%s]", strerror(errno));
    if (errno == EEXIST) {
        GZ_ERROR("There appears to be another server running.");
        GZ_ERROR("Use the -s flag to try a different server id,");
        GZ_ERROR("or use the -f flag if you definitely want to use this id.");
    }
    return -1;
}

static int make_directory(const char *path, int force)
{
    struct stat about;

    GZ_MESSAGE(GZ_FILES, "creating %s", path);
    if (mkdir(path, S_IRWXU) == 0)
        return 0;
    if (errno != EEXIST) {
        GZ_ERROR("failed to create [%s] : [%s]", path, strerror(errno));
        return -1;
    }
    /* /tmp is shared: never use a link or another user's directory, not even with force. */
    if (force && status_of_path(path, &about) == 0 && S_ISDIR(about.st_mode) && about.st_uid == geteuid())
        return 0;
    GZ_ERROR("directory [%s] already exists (previous crash?)", path);
    GZ_ERROR("remove the directory and re-run gazebo");
    return -1;
}

int gz_server_init(gz_server_t *self, int server_id, int force)
{
    char path[GZ_PATH_SIZE];

    gz_server_path(path, server_id);
    free(self->filename);
    self->filename = strdup(path);
    self->server_id = server_id;
    self->sem_key = GZ_SEM_KEY + server_id;
    if (make_semaphores(self, force) != 0)
        return -1;
    if (make_directory(path, force) != 0) {
        semctl(self->sem_cid, 0, IPC_RMID);
        self->sem_cid = -1;
        return -1;
    }
    return 0;
}

/* Remove the files of a directory, but no directories in it: a server never creates any. */
static void empty_directory(const char *path)
{
    DIR *directory = opendir(path);
    struct dirent *entry;

    if (directory == NULL)
        return;
    while ((entry = readdir(directory)) != NULL)
        unlinkat(dirfd(directory), entry->d_name, 0);
    closedir(directory);
}

int gz_server_fini(gz_server_t *self)
{
    if (IS_HOSTED(self))
        return 0; /* it ends with its world */
    GZ_MESSAGE(GZ_FILES, "deleting %s", self->filename);
    if (rmdir(self->filename) != 0) {
        GZ_MESSAGE(0, "failed to cleanly remove [%s] : [%s]", self->filename, strerror(errno));
        empty_directory(self->filename);
        rmdir(self->filename);
    }
    if (semctl(self->sem_cid, 0, IPC_RMID) < 0) {
        GZ_ERROR("failed to deallocate semaphore [%s]", strerror(errno));
        return -1;
    }
    self->sem_cid = -1;
    return 0;
}

int gz_server_post(gz_server_t *self)
{
    if (IS_HOSTED(self))
        return gz_host->post(self);
    return set_flags(self->sem_cid, 1);
}
