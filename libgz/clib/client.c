/* gz_client_*: connecting to a server and waiting for its posts. */

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ipc.h>
#include <sys/sem.h>
#include <sys/stat.h>

#include "error.h"
#include "gazebo.h"

enum { CLIENT_IDS = 16 };

gz_client_t *gz_client_alloc(void)
{
    gz_client_t *self = calloc(1, sizeof *self);

    if (self != NULL)
        self->client_id = self->sem_cid = -1;
    return self;
}

void gz_client_free(gz_client_t *self)
{
    if (self == NULL)
        return;
    free(self->filename);
    free(self);
}

int gz_client_query(gz_client_t *self, int server_id)
{
    (void) self;
    if (semget(GZ_SEM_KEY + server_id, 0, S_IRWXU) >= 0)
        return 0;
    if (errno == ENOENT)
        return 1;
    GZ_ERROR("failed to query semaphore [%s]", strerror(errno));
    return -1;
}

int gz_client_connect(gz_client_t *self, int server_id)
{
    return gz_client_connect_wait(self, server_id, -1);
}

int gz_client_connect_wait(gz_client_t *self, int server_id, int client_id)
{
    char path[GZ_PATH_SIZE];

    if (client_id >= CLIENT_IDS) {
        GZ_ERROR("invalid client ID [%d]", client_id);
        return -1;
    }
    gz_server_path(path, server_id);
    free(self->filename);
    self->filename = strdup(path);
    self->server_id = server_id;
    self->client_id = client_id;
    self->sem_key = GZ_SEM_KEY + server_id;
    self->sem_cid = -1;
    if (client_id >= 0) {
        self->sem_cid = semget(self->sem_key, 0, S_IRWXU);
        if (self->sem_cid < 0) {
            GZ_ERROR("Failed to allocate semaphore [%s]", strerror(errno));
            GZ_ERROR("The server does not appear to be running");
            return -1;
        }
    }
    GZ_MESSAGE(GZ_SESSION, "opening %s", path);
    return 0;
}

int gz_client_disconnect(gz_client_t *self)
{
    if (self->filename != NULL)
        GZ_MESSAGE(GZ_SESSION, "closing %s", self->filename);
    free(self->filename);
    self->filename = NULL;
    return 0;
}

int gz_client_wait(gz_client_t *self)
{
    struct sembuf flag_down;

    if (self->client_id < 0)
        return 0;
    flag_down.sem_num = (unsigned short) self->client_id;
    flag_down.sem_op = -1;
    flag_down.sem_flg = SEM_UNDO;
    if (semop(self->sem_cid, &flag_down, 1) < 0) {
        GZ_ERROR("error on semaphore wait [%s]", strerror(errno));
        return -1;
    }
    return 0;
}
