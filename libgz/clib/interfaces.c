/* gz_<type>_*: the functions of every interface of interfaces.def. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "gazebo.h"
#include "host.h"

#define INTERFACE(type, data_t)                                                                                      \
    gz_##type##_t *gz_##type##_alloc(void)                                                                           \
    {                                                                                                                \
        gz_##type##_t *self = calloc(1, sizeof *self);                                                               \
        if (self != NULL && (self->iface = gz_iface_alloc()) == NULL) {                                              \
            free(self);                                                                                              \
            return NULL;                                                                                             \
        }                                                                                                            \
        return self;                                                                                                 \
    }                                                                                                                \
    void gz_##type##_free(gz_##type##_t *self)                                                                       \
    {                                                                                                                \
        if (self != NULL)                                                                                            \
            gz_iface_free(self->iface);                                                                              \
        free(self);                                                                                                  \
    }                                                                                                                \
    int gz_##type##_destroy(gz_##type##_t *self)                                                                     \
    {                                                                                                                \
        self->data = NULL;                                                                                           \
        return gz_iface_destroy(self->iface);                                                                        \
    }                                                                                                                \
    int gz_##type##_open(gz_##type##_t *self, gz_client_t *client, const char *id)                                   \
    {                                                                                                                \
        if (gz_iface_open(self->iface, client, #type, id, sizeof(data_t)) != 0)                                      \
            return -1;                                                                                               \
        self->data = self->iface->mmap;                                                                              \
        return 0;                                                                                                    \
    }                                                                                                                \
    int gz_##type##_close(gz_##type##_t *self)                                                                       \
    {                                                                                                                \
        self->data = NULL;                                                                                           \
        return gz_iface_close(self->iface);                                                                          \
    }                                                                                                                \
    int gz_##type##_lock(gz_##type##_t *self, int blocking)                                                          \
    {                                                                                                                \
        return gz_iface_lock(self->iface, blocking);                                                                 \
    }                                                                                                                \
    void gz_##type##_unlock(gz_##type##_t *self)                                                                     \
    {                                                                                                                \
        gz_iface_unlock(self->iface);                                                                                \
    }

#define CREATE(type, data_t)                                                                                         \
    int gz_##type##_create(gz_##type##_t *self, gz_server_t *server, const char *id, const char *model_type,         \
                           int model_id, int parent_model_id)                                                        \
    {                                                                                                                \
        if (gz_iface_create(self->iface, server, #type, id, sizeof(data_t)) != 0)                                    \
            return -1;                                                                                               \
        self->data = self->iface->mmap;                                                                              \
        set_owner(self->iface, model_type, model_id, parent_model_id);                                               \
        return 0;                                                                                                    \
    }

#define INTERFACE_WITHOUT_POST(type, data_t) INTERFACE(type, data_t) CREATE(type, data_t)

#define INTERFACE_WITH_POST(type, data_t)                                                                            \
    INTERFACE_WITHOUT_POST(type, data_t)                                                                             \
    int gz_##type##_post(gz_##type##_t *self)                                                                        \
    {                                                                                                                \
        return gz_iface_post(self->iface);                                                                           \
    }

#define INTERFACE_WITHOUT_MODEL(type, data_t)                                                                        \
    INTERFACE(type, data_t)                                                                                          \
    int gz_##type##_create(gz_##type##_t *self, gz_server_t *server, const char *id)                                 \
    {                                                                                                                \
        if (gz_iface_create(self->iface, server, #type, id, sizeof(data_t)) != 0)                                    \
            return -1;                                                                                               \
        self->data = self->iface->mmap;                                                                              \
        return 0;                                                                                                    \
    }

/* Write the model that owns an interface into the head. */
static void set_owner(gz_iface_t *iface, const char *model_type, int model_id, int parent_model_id)
{
    gz_data_t *head = iface->mmap;

    if (IS_HOSTED(iface->server)) {
        gz_host->set_owner(iface, model_type, model_id, parent_model_id);
        return;
    }
    if (model_type != NULL)
        strncpy(head->model_type, model_type, sizeof head->model_type - 1);
    head->model_id = model_id;
    head->parent_model_id = parent_model_id;
}

#include "interfaces.def"

/* Rotation about fixed axes: roll about x first, then pitch about y, then yaw about z. */

void gz_truth_euler_from_quatern(gz_truth_t *self, double *e, double *q)
{
    double u = q[0], x = q[1], y = q[2], z = q[3];
    double sine = 2.0 * (u * y - x * z) / (u * u + x * x + y * y + z * z);

    (void) self;
    e[0] = atan2(2.0 * (y * z + u * x), u * u - x * x - y * y + z * z);
    e[1] = asin(fmax(-1.0, fmin(1.0, sine)));
    e[2] = atan2(2.0 * (x * y + u * z), u * u + x * x - y * y - z * z);
}

void gz_truth_quatern_from_euler(gz_truth_t *self, double *q, double *e)
{
    double cr = cos(e[0] / 2.0), cp = cos(e[1] / 2.0), cy = cos(e[2] / 2.0);
    double sr = sin(e[0] / 2.0), sp = sin(e[1] / 2.0), sy = sin(e[2] / 2.0);

    (void) self;
    q[0] = cr * cp * cy + sr * sp * sy;
    q[1] = sr * cp * cy - cr * sp * sy;
    q[2] = cr * sp * cy + sr * cp * sy;
    q[3] = cr * cp * sy - sr * sp * cy;
}
