/* How a server that runs plugins serves the interfaces that they create. In other programs gz_host is NULL. */

#ifndef LIBGZ_HOST_H
#define LIBGZ_HOST_H

#include "gazebo.h"

/* The semaphores of a server of this process, which the C library leaves alone. */
enum { GZ_HOSTED = -0x6877 };

struct gz_host {
    int (*create)(gz_iface_t *iface, const char *type, const char *id, size_t size);
    void (*set_owner)(gz_iface_t *iface, const char *model_type, int model_id, int parent_model_id);
    int (*destroy)(gz_iface_t *iface);
    int (*lock)(gz_iface_t *iface);
    void (*unlock)(gz_iface_t *iface);
    int (*post)(gz_server_t *server);
};

extern const struct gz_host *gz_host __attribute__((visibility("hidden")));

#define IS_HOSTED(server) (gz_host != NULL && (server) != NULL && (server)->sem_cid == GZ_HOSTED)

#endif
