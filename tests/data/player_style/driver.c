/* Connects as Player does, with its client id and its test of the version, and prints the laser's first sample. */

#include <stdio.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();
    gz_sim_t *sim = gz_sim_alloc();
    gz_laser_t *laser = gz_laser_alloc();

    gz_error_init(1, 0);
    if (count != 2 || gz_client_connect_wait(client, atoi(words[1]), GZ_CLIENT_ID_PLAYER) != 0)
        return 1;
    if (gz_sim_open(sim, client, "default") != 0 || sim->data->head.version != LIBGAZEBO_VERSION)
        return 2;
    if (gz_laser_open(laser, client, "laser1") != 0)
        return 3;
    do {
        if (gz_client_wait(client) != 0)
            return 4;
    } while (laser->data->range_count == 0);
    gz_laser_lock(laser, 1);
    printf("%d readings up to %.1f m\n", laser->data->range_count, laser->data->max_range);
    gz_laser_unlock(laser);
    gz_laser_close(laser);
    gz_sim_close(sim);
    gz_client_disconnect(client);
    return 0;
}
